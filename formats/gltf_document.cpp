#include "formats/gltf_document.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>

#include <tiny_gltf.h>
#include <nlohmann/json.hpp>

#include "formats/files.h"

namespace overcast {
namespace {

using Json = nlohmann::json;
using Bytes = std::span<const std::byte>;

/// The two parts of a container: JSON text, and the binary chunk of a .glb.
struct Container {
  std::string_view json;
  Bytes binary;
};

std::uint32_t word(Bytes bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

std::string_view textOf(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// glTF 2.0, section 4.4: header of 12 bytes, then chunks of length, type, data. Unknown chunks are skipped, as the specification asks.
Result<Container> splitGlb(Bytes file) {
  constexpr std::uint32_t kJson = 0x4E4F534A;
  constexpr std::uint32_t kBinary = 0x004E4942;
  if (file.size() < 20) return Error{"", "GLB header", "is cut short"};
  if (word(file, 4) != 2) return Error{"", "GLB header", fmt::format("version {} is not supported, only 2", word(file, 4))};
  const std::uint64_t length = word(file, 8);
  if (length > file.size()) return Error{"", "GLB header", fmt::format("says {} bytes but the file has {}", length, file.size())};
  Container container;
  std::uint64_t at = 12;
  for (int chunk = 0; at + 8 <= length; ++chunk) {
    const std::uint64_t size = word(file, at);
    const std::uint32_t type = word(file, at + 4);
    if (at + 8 + size > length) return Error{"", fmt::format("GLB chunk {}", chunk), "is longer than the file"};
    const Bytes data = file.subspan(at + 8, size);
    if (chunk == 0 && type != kJson) return Error{"", "GLB chunk 0", "is not JSON"};
    if (chunk == 0) container.json = textOf(data);
    if (chunk == 1 && type == kBinary) container.binary = data;
    at += 8 + (size + 3) / 4 * 4;
  }
  return container;
}

/// The member of an object, or null when there is none (also when `json` is no object).
const Json& member(const Json& json, const char* key) {
  static const Json nothing;
  const auto found = json.is_object() ? json.find(key) : json.end();
  return json.is_object() && found != json.end() ? *found : nothing;
}

bool startsWithAny(std::string_view name, std::initializer_list<std::string_view> prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(), [&](std::string_view prefix) { return name.starts_with(prefix); });
}

bool isKnownToKeepGeometry(std::string_view name) {
  return startsWithAny(name, {"OVERCAST_", "KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_xmp", "KHR_audio",
                              "KHR_techniques_webgl", "EXT_texture_", "EXT_lights_", "EXT_mesh_manifold", "MSFT_texture_", "MSFT_packing_",
                              "ADOBE_materials_", "FB_materials_", "GOOGLE_texture_"});
}

/// These move, hide or animate whole nodes; the scene stays usable without them, and a note says what is missing.
bool isLeftOutWithNote(std::string_view name) {
  return startsWithAny(name, {"CESIUM_RTC", "KHR_node_visibility", "KHR_animation_pointer", "KHR_node_hoverability",
                              "KHR_node_selectability", "KHR_interactivity", "MSFT_lod"});
}

Result<Done> checkExtensions(const Json& document, std::vector<std::string>& notes) {
  for (const Json& entry : member(document, "extensionsRequired")) {
    const std::string name = entry.is_string() ? entry.get<std::string>() : "";
    if (isKnownToKeepGeometry(name) || isLeftOutWithNote(name) || name == "EXT_meshopt_compression") continue;
    return Error{"", "extensionsRequired", fmt::format("{} may change geometry and is not supported", name)};
  }
  for (const Json& entry : member(document, "extensionsUsed")) {
    const std::string name = entry.is_string() ? entry.get<std::string>() : "";
    if (isLeftOutWithNote(name) || name == "EXT_mesh_gpu_instancing") notes.push_back(fmt::format("extension {} was left out", name));
  }
  return Done{};
}

/// Compressed geometry is usable only where the asset also holds it plain.
Result<Done> checkCompression(const Json& document) {
  const Json& accessors = member(document, "accessors");
  std::size_t meshIndex = 0;
  for (const Json& mesh : member(document, "meshes")) {
    std::size_t primitiveIndex = 0;
    for (const Json& primitive : member(mesh, "primitives")) {
      const bool draco = member(member(primitive, "extensions"), "KHR_draco_mesh_compression").is_object();
      const Json& position = member(member(primitive, "attributes"), "POSITION");
      const bool plain = position.is_number_unsigned() && accessors.is_array() && position.get<std::size_t>() < accessors.size() &&
                         !member(accessors[position.get<std::size_t>()], "bufferView").is_null();
      if (draco && !plain) {
        return Error{"", fmt::format("meshes/{}/primitives/{}", meshIndex, primitiveIndex),
                     "KHR_draco_mesh_compression without plain data is not supported"};
      }
      ++primitiveIndex;
    }
    ++meshIndex;
  }
  return Done{};
}

/// A buffer outside the JSON: its bytes are handed to tinygltf when it asks for the next external file.
struct ExternalBuffers {
  std::vector<std::vector<unsigned char>> contents;
  std::size_t next = 0;
};

Result<std::vector<unsigned char>> readBuffer(const std::filesystem::path& asset, const Json& buffer, std::size_t index, Bytes binary) {
  const std::string place = fmt::format("buffers/{}", index);
  const std::uint64_t length = member(buffer, "byteLength").is_number_unsigned() ? buffer["byteLength"].get<std::uint64_t>() : 0;
  if (length == 0) return Error{"", place + "/byteLength", "is missing or not a positive integer"};
  const Json& uri = member(buffer, "uri");
  std::vector<std::byte> file;
  if (uri.is_string()) {
    auto inside = resolveInside(asset.parent_path(), uri.get<std::string>());
    if (!inside) return Error{"", place + "/uri", inside.error().reason};
    auto read = readFile(inside.value());
    if (!read) return Error{"", place + "/uri", message(read.error())};
    file = std::move(read).value();
    binary = file;
  } else if (member(member(buffer, "extensions"), "EXT_meshopt_compression").is_object()) {
    return Error{"", place, "EXT_meshopt_compression without a fallback buffer is not supported"};
  } else if (!uri.is_null() || index != 0 || binary.empty()) {
    return Error{"", place + "/uri", uri.is_null() ? "is missing" : "is not a string"};
  }
  if (binary.size() < length) return Error{"", place, fmt::format("has {} bytes but byteLength says {}", binary.size(), length)};
  std::vector<unsigned char> content(length);
  std::memcpy(content.data(), binary.data(), length);
  return content;
}

bool isDataUri(const Json& uri) {
  return uri.is_string() && uri.get_ref<const std::string&>().starts_with("data:");
}

/// Loads every external buffer and gives it a name that tinygltf takes for a file.
Result<ExternalBuffers> takeBuffers(const std::filesystem::path& asset, Json& document, Bytes binary) {
  ExternalBuffers external;
  if (!member(document, "buffers").is_array()) return external;
  std::size_t index = 0;
  for (Json& buffer : document["buffers"]) {
    if (buffer.is_object() && !isDataUri(member(buffer, "uri"))) {
      auto content = readBuffer(asset, buffer, index, binary);
      if (!content) return content.error();
      external.contents.push_back(std::move(content).value());
      buffer["uri"] = "external";
    }
    ++index;
  }
  return external;
}

tinygltf::FsCallbacks callbacks(ExternalBuffers& external) {
  tinygltf::FsCallbacks fs{};
  fs.FileExists = [](const std::string&, void* user) {
    const auto& buffers = *static_cast<ExternalBuffers*>(user);
    return buffers.next < buffers.contents.size();
  };
  fs.ExpandFilePath = [](const std::string& path, void*) { return path; };
  fs.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*, const std::string&, void* user) {
    auto& buffers = *static_cast<ExternalBuffers*>(user);
    *out = std::move(buffers.contents.at(buffers.next++));
    return true;
  };
  fs.user_data = &external;
  return fs;
}

Result<Done> checkVersion(const Json& document) {
  const Json& asset = member(document, "asset");
  const Json& version = member(asset, "version");
  if (!version.is_string()) return Error{"", "asset/version", "is missing: not a glTF 2.0 file"};
  if (!version.get_ref<const std::string&>().starts_with("2."))
    return Error{"", "asset/version", fmt::format("'{}' is not supported, only 2.x", version.get<std::string>())};
  const Json& minimum = member(asset, "minVersion");
  if (minimum.is_string() && minimum != "2.0")
    return Error{"", "asset/minVersion", fmt::format("'{}' is not supported, only 2.0", minimum.get<std::string>())};
  return Done{};
}

/// tinygltf's messages end in line breaks and may be many: the first line says what went wrong first.
std::string firstLine(const std::string& text) {
  const std::string line = text.substr(0, text.find('\n'));
  return line.empty() ? "is not valid glTF 2.0" : line;
}

/// A parsed file and, of a .glb, its binary chunk.
struct ParsedJson {
  Json document;
  Bytes binary;
};

Result<ParsedJson> parseJson(Bytes file) {
  const bool binary = file.size() >= 4 && textOf(file.first(4)) == "glTF";
  const auto container = binary ? splitGlb(file) : Result<Container>(Container{textOf(file), {}});
  if (!container) return container.error();
  ParsedJson parsed{Json::parse(container.value().json), container.value().binary};
  if (!parsed.document.is_object()) return Error{"", "", "is not a JSON object"};
  return parsed;
}

Result<std::vector<std::string>> listFiles(const std::filesystem::path& path, Bytes file) {
  const auto parsed = parseJson(file);
  if (!parsed) return parsed.error();
  std::vector<std::string> files{path.string()};
  std::size_t index = 0;
  for (const Json& buffer : member(parsed.value().document, "buffers")) {
    const std::string place = fmt::format("buffers/{}/uri", index++);
    const Json& uri = member(buffer, "uri");
    if (!uri.is_string() || isDataUri(uri)) continue;
    const auto inside = resolveInside(path.parent_path(), uri.get<std::string>());
    if (!inside) return Error{"", place, inside.error().reason};
    files.push_back(inside.value().string());
  }
  index = 0;
  for (const Json& scene : member(parsed.value().document, "scenes")) {
    const std::string place = fmt::format("scenes/{}/extensions/OVERCAST_lighting/sky/image", index++);
    const Json& image = member(member(member(member(scene, "extensions"), "OVERCAST_lighting"), "sky"), "image");
    if (!image.is_string()) continue;
    const auto inside = resolveInside(path.parent_path(), image.get<std::string>());
    if (!inside) return Error{"", place, inside.error().reason};
    files.push_back(inside.value().string());
  }
  return files;
}

Result<GltfDocument> parse(const std::filesystem::path& path, Bytes file) {
  auto parsed = parseJson(file);
  if (!parsed) return parsed.error();
  Json& document = parsed.value().document;
  GltfDocument result;
  for (const auto& check : {checkVersion(document), checkExtensions(document, result.notes), checkCompression(document)})
    if (!check) return check.error();
  auto external = takeBuffers(path, document, parsed.value().binary);
  if (!external) return external.error();

  // Textures are of no use here: what is missing, huge or in an unknown format among them must not matter.
  for (const char* key : {"images", "textures", "samplers"}) document.erase(key);
  const std::string text = document.dump();
  document = nullptr;
  tinygltf::TinyGLTF parser;
  parser.SetFsCallbacks(callbacks(external.value()));
  parser.SetImageLoader([](tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) { return true; },
                        nullptr);
  parser.SetStoreOriginalJSONForExtrasAndExtensions(true);
  result.model.reset(new tinygltf::Model);
  std::string errors, warnings;
  if (text.size() > 0xFFFFFFFFu) return Error{"", "", "holds more than 4 GiB of JSON"};
  if (!parser.LoadASCIIFromString(result.model.get(), &errors, &warnings, text.c_str(), static_cast<unsigned int>(text.size()), ""))
    return Error{"", "", firstLine(errors)};
  if (!errors.empty()) result.notes.push_back("left out what could not be parsed: " + firstLine(errors));
  return result;
}

}  // namespace

void GltfModelDeleter::operator()(tinygltf::Model* model) const {
  delete model;
}

namespace {

/// What `parse` makes of the file; everything it throws but for want of memory becomes an Error that names the file.
template <class T>
Result<T> parsedFile(const std::filesystem::path& path, Result<T> (*parse)(const std::filesystem::path&, Bytes)) {
  auto file = readFile(path);
  if (!file) return file.error();
  Result<T> result = Error{};
  try {
    result = parse(path, file.value());
  } catch (const nlohmann::json::exception& failure) {
    result = Error{"", "", std::string("is not valid JSON: ") + failure.what()};
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& failure) {
    result = Error{"", "", std::string("is not valid glTF 2.0: ") + failure.what()};
  }
  if (result) return result;
  Error error = result.error();
  error.file = path.string();
  return error;
}

}  // namespace

Result<GltfDocument> readGltfDocument(const std::filesystem::path& path) {
  return parsedFile(path, parse);
}

Result<std::vector<std::string>> listGltfFiles(const std::filesystem::path& path) {
  return parsedFile(path, listFiles);
}

}  // namespace overcast
