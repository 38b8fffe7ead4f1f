// A Scene as .gltf and .bin (glTF 2.0).
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "formats/extension_json.h"
#include "formats/files.h"
#include "formats/gltf_levels.h"
#include "formats/normals.h"
#include "formats/scene.h"
#include "formats/scene_check.h"
#include "formats/trs.h"
#include "formats/uri.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;

/// The .bin under way and the JSON that describes it.
struct Binary {
  std::vector<std::byte> bytes;
  Json views = Json::array();
  Json accessors = Json::array();
};

template <class T>
std::size_t addView(Binary& binary, const std::vector<T>& values, int target) {
  const std::size_t size = values.size() * sizeof(T);
  Json view = {{"buffer", 0}, {"byteOffset", binary.bytes.size()}, {"byteLength", size}};
  if (target != 0) view["target"] = target;
  binary.views.push_back(std::move(view));
  const auto* begin = reinterpret_cast<const std::byte*>(values.data());
  binary.bytes.insert(binary.bytes.end(), begin, begin + size);
  return binary.views.size() - 1;
}

std::size_t addAccessor(Binary& binary, std::size_t view, std::size_t byteOffset, int componentType, std::size_t count, const char* type) {
  Json accessor = {{"bufferView", view}};
  if (byteOffset != 0) accessor["byteOffset"] = byteOffset;
  accessor["componentType"] = componentType;
  accessor["count"] = count;
  accessor["type"] = type;
  binary.accessors.push_back(std::move(accessor));
  return binary.accessors.size() - 1;
}

/// Floats, `width` per element, in a view and an accessor of their own; with the extent where glTF asks for it.
std::size_t addFloats(Binary& binary, const std::vector<float>& values, std::size_t width, int target, bool withExtent) {
  const char* types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  const std::size_t view = addView(binary, values, target);
  const std::size_t index = addAccessor(binary, view, 0, kFloat, values.size() / width, types[width]);
  if (!withExtent) return index;
  for (std::size_t c = 0; c < width; ++c) {
    float low = values[c], high = values[c];
    for (std::size_t i = c; i < values.size(); i += width) {
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
    }
    binary.accessors[index]["min"].push_back(static_cast<double>(low));
    binary.accessors[index]["max"].push_back(static_cast<double>(high));
  }
  return index;
}

template <class Vector>
Json arrayOf(const Vector& v) {
  Json json = Json::array();
  for (int i = 0; i < Vector::length(); ++i) json.push_back(v[i]);
  return json;
}

Json named(const std::string& name) {
  return name.empty() ? Json::object() : Json{{"name", name}};
}

/// Floats of the positions; nothing when one does not fit a single float.
std::optional<std::vector<float>> positionFloats(const Mesh& mesh) {
  std::vector<float> floats;
  floats.reserve(3 * mesh.positions.size());
  for (const glm::dvec3& p : mesh.positions) {
    for (int c = 0; c < 3; ++c) {
      if (std::abs(p[c]) > static_cast<double>(std::numeric_limits<float>::max())) return std::nullopt;
      floats.push_back(static_cast<float>(p[c]));
    }
  }
  return floats;
}

/// Adds the attributes of what a mesh's vertices see.
void addVisibility(const VertexVisibility& visibility, Json& attributes, Binary& binary) {
  const std::size_t count = visibility.apertures.size();
  if (visibility.bits == ApertureBits::packed32 && count > 0) {
    std::vector<std::uint32_t> codes;
    for (const Aperture& aperture : visibility.apertures) codes.push_back(packAperture32(aperture));
    attributes["_APERTURE"] = addAccessor(binary, addView(binary, codes, kArrayBuffer), 0, kUnsignedByte, count, "VEC4");
  } else if (count > 0) {
    std::vector<std::uint64_t> codes;
    for (std::size_t i = 0; i < count; ++i) codes.push_back(packAperture64(visibility.apertures[i], visibility.ambient[i]));
    attributes["_APERTURE"] = addAccessor(binary, addView(binary, codes, kArrayBuffer), 0, kUnsignedShort, count, "VEC4");
  }
  for (std::size_t k = 0; k < 3 && !visibility.transfer.empty(); ++k) {
    std::vector<float> floats;
    for (const std::array<float, 9>& transfer : visibility.transfer)
      floats.insert(floats.end(), {transfer[3 * k], transfer[3 * k + 1], transfer[3 * k + 2]});
    attributes[fmt::format("_TRANSFER_{}", k)] = addFloats(binary, floats, 3, kArrayBuffer, false);
  }
}

/// The extension OVERCAST_levels.
Json levelsJson(const MeshLevels& levels, Binary& binary) {
  const auto addIntegers = [&](const std::vector<std::uint32_t>& values, int target) {
    return addAccessor(binary, addView(binary, values, target), 0, kUnsignedInt, values.size(), "SCALAR");
  };
  std::vector<std::uint32_t> indices, counts, own, coarser;
  for (const glm::uvec3& t : levels.triangles) indices.insert(indices.end(), {t.x, t.y, t.z});
  for (const LevelCluster& cluster : levels.clusters) {
    counts.push_back(cluster.triangleCount);
    own.push_back(cluster.own);
    coarser.push_back(cluster.coarser);
  }
  std::vector<float> balls, errors;
  for (const LevelGroup& group : levels.groups) {
    balls.insert(balls.end(), {group.centre.x, group.centre.y, group.centre.z, group.radius});
    errors.push_back(group.error);
  }
  return {{"version", kLevelsVersion},
          {"indices", addIntegers(indices, kElementArrayBuffer)},
          {"counts", addIntegers(counts, 0)},
          {"own", addIntegers(own, 0)},
          {"coarser", addIntegers(coarser, 0)},
          {"balls", addFloats(binary, balls, 4, 0, false)},
          {"errors", addFloats(binary, errors, 1, 0, false)}};
}

Result<Json> meshJson(Mesh mesh, std::size_t index, Binary& binary) {
  if (mesh.normals.empty()) mesh = withNormals(std::move(mesh));
  mendNormals(mesh);
  const auto positions = positionFloats(mesh);
  if (!positions) return Error{"", fmt::format("meshes/{}", index), "has a position that does not fit a single float"};
  std::vector<float> normals;
  normals.reserve(3 * mesh.normals.size());
  for (const glm::vec3& n : mesh.normals) normals.insert(normals.end(), {n.x, n.y, n.z});
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) indices.insert(indices.end(), {t.x, t.y, t.z});

  const std::size_t position = addFloats(binary, *positions, 3, kArrayBuffer, true);
  const std::size_t normal = addFloats(binary, normals, 3, kArrayBuffer, false);
  Json attributes = {{"NORMAL", normal}, {"POSITION", position}};
  if (!mesh.textureCoordinates.empty()) {
    std::vector<float> coordinates;
    for (const glm::vec2& c : mesh.textureCoordinates) coordinates.insert(coordinates.end(), {c.x, c.y});
    attributes["TEXCOORD_0"] = addFloats(binary, coordinates, 2, kArrayBuffer, false);
  }
  if (mesh.visibility) addVisibility(*mesh.visibility, attributes, binary);
  const std::size_t view = addView(binary, indices, kElementArrayBuffer);
  Json primitives = Json::array();
  for (const MeshPart& part : mesh.parts) {
    if (part.triangleCount == 0) continue;
    const std::size_t first = std::size_t{12} * part.firstTriangle;
    const std::size_t accessor = addAccessor(binary, view, first, kUnsignedInt, std::size_t{3} * part.triangleCount, "SCALAR");
    Json primitive = {{"attributes", attributes}, {"indices", accessor}};
    if (part.material >= 0) primitive["material"] = part.material;
    primitives.push_back(std::move(primitive));
  }
  Json json = named(mesh.name);
  json["primitives"] = std::move(primitives);
  if (mesh.levels) json["extensions"]["OVERCAST_levels"] = levelsJson(*mesh.levels, binary);
  if (mesh.apertureBake) {
    const std::string text = apertureBakeJson(*mesh.apertureBake);
    const auto readable = parseApertureBake(text, fmt::format("meshes/{}/extensions/OVERCAST_aperture_bake", index));
    if (!readable) return readable.error();
    json["extensions"]["OVERCAST_aperture_bake"] = Json::parse(text);
  }
  if (!mesh.apertureMap) return json;
  const std::string text = apertureJson(*mesh.apertureMap);
  const auto readable = parseAperture(text, fmt::format("meshes/{}/extensions/OVERCAST_aperture", index));
  if (!readable) return readable.error();
  json["extensions"]["OVERCAST_aperture"] = Json::parse(text);
  return json;
}

Json materialJson(const Material& material) {
  Json colour = Json::array();
  for (int c = 0; c < 4; ++c) colour.push_back(shortest(std::clamp(material.baseColour[c], 0.0f, 1.0f)));
  Json json = named(material.name);
  json["pbrMetallicRoughness"] = {{"baseColorFactor", std::move(colour)}, {"metallicFactor", 0.0}, {"roughnessFactor", 1.0}};
  return json;
}

Json cameraJson(const Camera& camera) {
  Json json = named(camera.name);
  json["type"] = "perspective";
  json["perspective"] = {{"yfov", camera.verticalFieldOfView}, {"znear", camera.nearPlane}};
  return json;
}

void putTransform(Json& json, const glm::dvec3& translation, const glm::dquat& r, const glm::dvec3& scale) {
  if (translation != glm::dvec3(0.0)) json["translation"] = arrayOf(translation);
  if (r != glm::dquat(1.0, 0.0, 0.0, 0.0)) json["rotation"] = Json::array({r.x, r.y, r.z, r.w});
  if (scale != glm::dvec3(1.0)) json["scale"] = arrayOf(scale);
}

/// What a node carries besides its place.
Result<Done> putLoad(Json& json, const Node& node, std::size_t index, const std::vector<int>& meshIndex) {
  if (!node.children.empty()) json["children"] = node.children;
  const int mesh = node.mesh < 0 ? -1 : meshIndex[static_cast<std::size_t>(node.mesh)];
  if (mesh >= 0) json["mesh"] = mesh;
  if (node.camera >= 0) json["camera"] = node.camera;
  if (!node.occluder) return Done{};
  const std::string text = occluderJson(*node.occluder);
  auto readable = parseOccluder(text, fmt::format("nodes/{}/extensions/OVERCAST_occluder", index));
  if (!readable) return readable.error();
  json["extensions"]["OVERCAST_occluder"] = Json::parse(text);
  return Done{};
}

/// Whether the node's matrix shears, which takes two nodes of glTF.
bool needsTwoNodes(const Node& node) {
  if (!node.matrix) return false;
  const Trs parts = decompose(*node.matrix);
  return parts.inner && !isPlainTrs(*node.matrix, parts);
}

/// The node of the file that has the whole transform of node `index`.
std::size_t wholeNode(const Scene& scene, std::size_t index) {
  if (!needsTwoNodes(scene.nodes[index])) return index;
  std::size_t whole = scene.nodes.size();
  for (std::size_t i = 0; i < index; ++i) whole += needsTwoNodes(scene.nodes[i]) ? 1 : 0;
  return whole;
}

/// The nodes in their order. A matrix that glTF forbids is written as its parts; one that shears needs two nodes, the second of which
/// follows all others and carries the load.
Result<Json> nodesJson(const Scene& scene, const std::vector<int>& meshIndex) {
  Json nodes = Json::array();
  Json seconds = Json::array();
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    Json json = named(node.name);
    std::optional<Json> second;
    if (!node.matrix) {
      putTransform(json, node.translation, node.rotation, node.scale);
    } else if (const Trs parts = decompose(*node.matrix); isPlainTrs(*node.matrix, parts)) {
      for (int k = 0; k < 16; ++k) json["matrix"].push_back((*node.matrix)[k / 4][k % 4]);
    } else {
      putTransform(json, parts.translation, parts.rotation, parts.scale);
      if (parts.inner) putTransform(second.emplace(Json::object()), glm::dvec3(0.0), *parts.inner, glm::dvec3(1.0));
    }
    auto loaded = putLoad(second ? *second : json, node, i, meshIndex);
    if (!loaded) return loaded.error();
    if (second) {
      json["children"] = Json::array({scene.nodes.size() + seconds.size()});
      seconds.push_back(std::move(*second));
    }
    nodes.push_back(std::move(json));
  }
  for (Json& second : seconds) nodes.push_back(std::move(second));
  return nodes;
}

const char* pathOf(AnimatedProperty property) {
  const char* names[] = {"translation", "rotation", "scale"};
  return names[static_cast<std::size_t>(property)];
}

const char* nameOf(Interpolation interpolation) {
  const char* names[] = {"STEP", "LINEAR", "CUBICSPLINE"};
  return names[static_cast<std::size_t>(interpolation)];
}

/// glTF asks for two keys of a cubic spline; with one key it is a step.
AnimationChannel withoutLoneSpline(AnimationChannel channel) {
  if (channel.interpolation != Interpolation::cubicSpline || channel.times.size() > 1) return channel;
  channel.interpolation = Interpolation::step;
  channel.values = {channel.values[1]};
  return channel;
}

/// Values as floats; rotations that drifted from unit length are brought back, tangents are left alone.
std::vector<float> keyFloats(const AnimationChannel& channel) {
  const bool rotation = channel.property == AnimatedProperty::rotation;
  const bool cubic = channel.interpolation == Interpolation::cubicSpline;
  std::vector<float> floats;
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    glm::dvec4 value = channel.values[i];
    const double length = std::sqrt(value.x * value.x + value.y * value.y + value.z * value.z + value.w * value.w);
    if (rotation && (!cubic || i % 3 == 1) && std::abs(length - 1.0) > 1e-5 && length > 0.0) value /= length;
    for (int c = 0; c < (rotation ? 4 : 3); ++c) floats.push_back(static_cast<float>(value[c]));
  }
  return floats;
}

Result<Json> animationJson(const Scene& scene, std::size_t index, Binary& binary) {
  const Animation& animation = scene.animations[index];
  Json json = named(animation.name);
  std::set<std::pair<int, AnimatedProperty>> targets;
  for (std::size_t c = 0; c < animation.channels.size(); ++c) {
    const AnimationChannel channel = withoutLoneSpline(animation.channels[c]);
    const std::string place = fmt::format("animations/{}/channels/{}", index, c);
    if (scene.nodes[static_cast<std::size_t>(channel.node)].matrix) return Error{"", place, "moves a node that has a matrix"};
    if (!targets.insert({channel.node, channel.property}).second) return Error{"", place, "moves a property that another channel moves"};
    std::vector<float> times;
    for (const double time : channel.times) {
      times.push_back(static_cast<float>(time));
      if (times.size() > 1 && !(times.back() > times[times.size() - 2]))
        return Error{"", place, fmt::format("has keys too close for single floats at {} s", time)};
    }
    const std::size_t width = channel.property == AnimatedProperty::rotation ? 4 : 3;
    const std::size_t input = addFloats(binary, times, 1, 0, true);
    const std::size_t output = addFloats(binary, keyFloats(channel), width, 0, false);
    json["channels"].push_back({{"sampler", c}, {"target", {{"node", channel.node}, {"path", pathOf(channel.property)}}}});
    json["samplers"].push_back({{"input", input}, {"interpolation", nameOf(channel.interpolation)}, {"output", output}});
  }
  return json;
}

Result<Json> sceneJson(const Scene& scene) {
  Json json = named(scene.name);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (scene.nodes[i].parent < 0) json["nodes"].push_back(i);
  if (!scene.lighting) return json;
  Lighting lighting = *scene.lighting;
  for (AreaLight& light : lighting.areaLights)
    if (light.node >= 0) light.node = static_cast<int>(wholeNode(scene, static_cast<std::size_t>(light.node)));
  const std::string text = lightingJson(lighting);
  auto readable = parseLighting(text, "scenes/0/extensions/OVERCAST_lighting");
  if (!readable) return readable.error();
  json["extensions"]["OVERCAST_lighting"] = Json::parse(text);
  return json;
}

/// glTF forbids empty arrays: what has no entry is left out.
void putUnlessEmpty(Json& document, const char* key, Json array) {
  if (!array.empty()) document[key] = std::move(array);
}

Result<Done> putContents(const Scene& scene, Json& document, Binary& binary) {
  std::vector<int> meshIndex;
  Json meshes = Json::array(), materials = Json::array(), cameras = Json::array(), animations = Json::array();
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const bool empty = scene.meshes[i].triangles.empty();
    meshIndex.push_back(empty ? -1 : static_cast<int>(meshes.size()));
    if (empty) continue;
    auto json = meshJson(scene.meshes[i], i, binary);
    if (!json) return json.error();
    meshes.push_back(std::move(json).value());
  }
  for (const Material& material : scene.materials) materials.push_back(materialJson(material));
  for (const Camera& camera : scene.cameras) cameras.push_back(cameraJson(camera));
  auto nodes = nodesJson(scene, meshIndex);
  if (!nodes) return nodes.error();
  for (std::size_t i = 0; i < scene.animations.size(); ++i) {
    if (scene.animations[i].channels.empty()) continue;
    auto json = animationJson(scene, i, binary);
    if (!json) return json.error();
    animations.push_back(std::move(json).value());
  }
  auto root = sceneJson(scene);
  if (!root) return root.error();
  document["scene"] = 0;
  document["scenes"].push_back(std::move(root).value());
  putUnlessEmpty(document, "nodes", std::move(nodes).value());
  putUnlessEmpty(document, "cameras", std::move(cameras));
  putUnlessEmpty(document, "materials", std::move(materials));
  putUnlessEmpty(document, "meshes", std::move(meshes));
  putUnlessEmpty(document, "animations", std::move(animations));
  return Done{};
}

/// Whether `file` is `stem`, a dash, 8 hexadecimal digits and .bin: a name that binaryName gave.
bool isBinaryOf(const std::string& stem, const std::string& file) {
  constexpr std::size_t kDigits = 8;
  if (file.size() != stem.size() + kDigits + 5 || !file.starts_with(stem + "-") || !file.ends_with(".bin")) return false;
  return file.substr(stem.size() + 1, kDigits).find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string binaryName(const fs::path& scene, const std::vector<std::byte>& bytes) {
  return fmt::format("{}-{}.bin", scene.stem().string(), contentHash(bytes).substr(0, 8));
}

}  // namespace

void removeOldBinaries(const fs::path& scene, const std::string& kept) {
  const std::string stem = scene.stem().string();
  const fs::path folder = scene.has_parent_path() ? scene.parent_path() : fs::path(".");
  std::vector<fs::path> old;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    const std::string file = entry->path().filename().string();
    if (file != kept && isBinaryOf(stem, file)) old.push_back(entry->path());
  }
  for (const fs::path& file : old) fs::remove(file, code);
}

Result<std::vector<std::filesystem::path>> writeScene(const std::filesystem::path& path, const Scene& scene) {
  const std::string broken = brokenInvariant(scene);
  OVERCAST_REQUIRE(broken.empty(), "scene for {}: {}", path.string(), broken);
  if (path.extension() != ".gltf") return Error{path.string(), "", "scenes are written as .gltf"};
  Json document = {{"asset", {{"version", "2.0"}, {"generator", "Overcast"}}}};
  Json used = Json::array();
  if (std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& mesh) { return mesh.apertureMap && !mesh.triangles.empty(); }))
    used.push_back("OVERCAST_aperture");
  if (std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& mesh) { return mesh.apertureBake && !mesh.triangles.empty(); }))
    used.push_back("OVERCAST_aperture_bake");
  if (std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& mesh) { return mesh.levels && !mesh.triangles.empty(); }))
    used.push_back("OVERCAST_levels");
  if (scene.lighting) used.push_back("OVERCAST_lighting");
  if (std::any_of(scene.nodes.begin(), scene.nodes.end(), [](const Node& node) { return node.occluder.has_value(); }))
    used.push_back("OVERCAST_occluder");
  putUnlessEmpty(document, "extensionsUsed", std::move(used));
  Binary binary;
  auto contents = putContents(scene, document, binary);
  if (!contents) return Error{path.string(), contents.error().place, contents.error().reason};
  putUnlessEmpty(document, "accessors", std::move(binary.accessors));
  putUnlessEmpty(document, "bufferViews", std::move(binary.views));
  std::vector<fs::path> files;
  std::string bin;
  bool fresh = false;  // the .bin is not one that the old scene may need
  std::error_code code;
  if (!binary.bytes.empty()) {
    bin = binaryName(path, binary.bytes);
    files.push_back(path.parent_path() / bin);
    fresh = !fs::exists(files[0], code);
    document["buffers"].push_back({{"uri", uriFromPath(bin)}, {"byteLength", binary.bytes.size()}});
    auto written = writeFileAtomically(files[0], binary.bytes);
    if (!written) return written.error();
  }
  auto written = writeFileAtomically(path, document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  if (!written) {
    if (fresh) fs::remove(files[0], code);
    return written.error();
  }
  removeOldBinaries(path, bin);
  files.push_back(path);
  return files;
}

}  // namespace overcast
