// Builds small glTF files piece by piece, valid or not, for the tests of the scene reader.
#pragma once

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace overcast::test {

struct GltfBuilder {
  nlohmann::ordered_json json = {{"asset", {{"version", "2.0"}}}};
  std::string bytes;  ///< of the one buffer

  /// Adds the values as a buffer view of their own and returns its index.
  template <class T>
  int view(const std::vector<T>& values, int stride = 0) {
    while (bytes.size() % 4 != 0) bytes.push_back('\0');
    nlohmann::ordered_json entry = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(T)}};
    if (stride != 0) entry["byteStride"] = stride;
    json["bufferViews"].push_back(entry);
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return static_cast<int>(json["bufferViews"].size()) - 1;
  }

  int accessor(nlohmann::ordered_json entry) {
    json["accessors"].push_back(std::move(entry));
    return static_cast<int>(json["accessors"].size()) - 1;
  }

  int floats(const std::vector<float>& values, int width) {
    const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    const int index = view(values);
    return accessor({{"bufferView", index},
                     {"componentType", 5126},
                     {"count", values.size() / static_cast<std::size_t>(width)},
                     {"type", types[width]}});
  }

  int indices(const std::vector<std::uint16_t>& values) {
    const int index = view(values);
    return accessor({{"bufferView", index}, {"componentType", 5123}, {"count", values.size()}, {"type", "SCALAR"}});
  }

  /// A mesh with one primitive over these accessors (none: -1), and a root node that shows it.
  void show(int position, int index = -1, int mode = 4) {
    nlohmann::ordered_json primitive = {{"attributes", {{"POSITION", position}}}, {"mode", mode}};
    if (index >= 0) primitive["indices"] = index;
    json["meshes"].push_back({{"primitives", {primitive}}});
    json["nodes"].push_back({{"mesh", json["meshes"].size() - 1}});
    root(static_cast<int>(json["nodes"].size()) - 1);
  }

  void root(int node) {
    json["scene"] = 0;
    json["scenes"][0]["nodes"].push_back(node);
  }

  /// One triangle in the plane z = 0, facing +z.
  static GltfBuilder triangle() {
    GltfBuilder builder;
    const int position = builder.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
    builder.show(position, builder.indices({0, 1, 2}));
    return builder;
  }

  static void save(const std::filesystem::path& path, const std::string& content) { std::ofstream(path, std::ios::binary) << content; }

  /// name.gltf and name.bin in `folder`; returns the path of the former.
  std::filesystem::path gltf(const std::filesystem::path& folder, const std::string& name = "scene") const {
    nlohmann::ordered_json document = json;
    if (!bytes.empty() && !document.contains("buffers"))
      document["buffers"].push_back({{"uri", name + ".bin"}, {"byteLength", bytes.size()}});
    save(folder / (name + ".bin"), bytes);
    save(folder / (name + ".gltf"), document.dump());
    return folder / (name + ".gltf");
  }

  std::string glbBytes() const {
    nlohmann::ordered_json document = json;
    std::string binary = bytes;
    while (binary.size() % 4 != 0) binary.push_back('\0');
    if (!bytes.empty()) document["buffers"].push_back({{"byteLength", bytes.size()}});
    std::string text = document.dump();
    while (text.size() % 4 != 0) text.push_back(' ');
    std::string file = "glTF" + word(2) + word(static_cast<std::uint32_t>(20 + text.size() + (binary.empty() ? 0 : 8 + binary.size())));
    file += word(static_cast<std::uint32_t>(text.size())) + "JSON" + text;
    if (!binary.empty()) file += word(static_cast<std::uint32_t>(binary.size())) + std::string("BIN\0", 4) + binary;
    return file;
  }

  std::filesystem::path glb(const std::filesystem::path& folder, const std::string& name = "scene") const {
    save(folder / (name + ".glb"), glbBytes());
    return folder / (name + ".glb");
  }

 private:
  static std::string word(std::uint32_t value) {
    std::string text(4, '\0');
    for (std::size_t i = 0; i < 4; ++i) text[i] = static_cast<char>(value >> (8 * i) & 0xFF);
    return text;
  }
};

}  // namespace overcast::test
