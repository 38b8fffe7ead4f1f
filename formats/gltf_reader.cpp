#include "formats/gltf_reader.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <tiny_gltf.h>
#include <nlohmann/json.hpp>

#include "formats/extension_json.h"
#include "formats/gltf_document.h"
#include "formats/gltf_levels.h"

namespace overcast {
namespace {

std::size_t at(int index) {
  return static_cast<std::size_t>(index);
}

bool isIndex(int index, std::size_t size) {
  return index >= 0 && at(index) < size;
}

/// Parents of all nodes of the file. Every node has at most one, and no node is its own ancestor (glTF 2.0, 3.5.2).
Result<std::vector<int>> parentsOf(const tinygltf::Model& model) {
  const std::size_t count = model.nodes.size();
  std::vector<int> parents(count, -1);
  for (std::size_t i = 0; i < count; ++i) {
    for (const int child : model.nodes[i].children) {
      if (!isIndex(child, count)) return Error{"", fmt::format("nodes/{}/children", i), fmt::format("{} does not exist", child)};
      if (parents[at(child)] >= 0) return Error{"", fmt::format("nodes/{}", child), "has more than one parent"};
      parents[at(child)] = static_cast<int>(i);
    }
  }
  std::vector<bool> reached(count, false);
  std::vector<int> open;
  for (std::size_t i = 0; i < count; ++i)
    if (parents[i] < 0) open.push_back(static_cast<int>(i));
  while (!open.empty()) {
    const int node = open.back();
    open.pop_back();
    reached[at(node)] = true;
    open.insert(open.end(), model.nodes[at(node)].children.begin(), model.nodes[at(node)].children.end());
  }
  const auto lost = std::find(reached.begin(), reached.end(), false);
  if (lost != reached.end()) return Error{"", fmt::format("nodes/{}", lost - reached.begin()), "is part of a cycle"};
  return parents;
}

/// Roots of the default scene; of the first scene when none is the default; all parentless nodes when there is no scene.
Result<std::vector<int>> rootsOf(const tinygltf::Model& model, const std::vector<int>& parents, int scene) {
  std::vector<int> roots;
  if (scene < 0) {
    for (std::size_t i = 0; i < parents.size(); ++i)
      if (parents[i] < 0) roots.push_back(static_cast<int>(i));
    return roots;
  }
  const std::string place = fmt::format("scenes/{}/nodes", scene);
  for (const int node : model.scenes[at(scene)].nodes) {
    if (!isIndex(node, parents.size())) return Error{"", place, fmt::format("{} does not exist", node)};
    if (parents[at(node)] >= 0) return Error{"", place, fmt::format("{} is not a root: it is a child of node {}", node, parents[at(node)])};
    roots.push_back(node);
  }
  return roots;
}

/// Old node index to new for what the roots reach, -1 for the rest. The order of the file is kept.
std::vector<int> newNodeIndices(const tinygltf::Model& model, std::vector<int> open) {
  std::vector<int> indices(model.nodes.size(), -1);
  while (!open.empty()) {
    const int node = open.back();
    open.pop_back();
    if (indices[at(node)] == 0) continue;
    indices[at(node)] = 0;
    open.insert(open.end(), model.nodes[at(node)].children.begin(), model.nodes[at(node)].children.end());
  }
  int next = 0;
  for (int& index : indices)
    if (index == 0) index = next++;
  return indices;
}

Result<Done> checkNumbers(const std::vector<double>& numbers, std::size_t size, const std::string& place) {
  if (!numbers.empty() && numbers.size() != size) return Error{"", place, fmt::format("has {} numbers, not {}", numbers.size(), size)};
  for (const double v : numbers)
    if (!std::isfinite(v)) return Error{"", place, "is not finite"};
  return Done{};
}

Result<Done> readTransform(const tinygltf::Node& source, const std::string& place, Node& node) {
  for (const auto& check : {checkNumbers(source.matrix, 16, place + "/matrix"), checkNumbers(source.translation, 3, place + "/translation"),
                            checkNumbers(source.rotation, 4, place + "/rotation"), checkNumbers(source.scale, 3, place + "/scale")})
    if (!check) return check.error();
  if (!source.matrix.empty()) {
    glm::dmat4 matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = source.matrix[at(i)];
    if (matrix[0][3] != 0.0 || matrix[1][3] != 0.0 || matrix[2][3] != 0.0 || matrix[3][3] != 1.0)
      return Error{"", place + "/matrix", "is not affine: its last row is not 0 0 0 1"};
    node.matrix = matrix;
    return Done{};
  }
  const auto& t = source.translation;
  const auto& r = source.rotation;
  const auto& s = source.scale;
  if (!t.empty()) node.translation = {t[0], t[1], t[2]};
  if (!s.empty()) node.scale = {s[0], s[1], s[2]};
  if (r.empty()) return Done{};
  const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  if (!(length > 1e-3 && length < 1e3)) return Error{"", place + "/rotation", "is not a unit quaternion"};
  const double factor = std::abs(length - 1.0) < 1e-14 ? 1.0 : 1.0 / length;
  node.rotation = glm::dquat(r[3] * factor, r[0] * factor, r[1] * factor, r[2] * factor);
  return Done{};
}

/// The text of one extension out of the text of all, or nothing when it is not there.
std::optional<std::string> extensionText(const std::string& all, const char* name) {
  if (all.empty()) return std::nullopt;
  const auto extensions = nlohmann::ordered_json::parse(all);
  const auto found = extensions.find(name);
  if (found == extensions.end()) return std::nullopt;
  return found->dump();
}

Result<Node> readNode(const tinygltf::Model& model, int index, const std::vector<int>& parents, const std::vector<int>& newIndex,
                      Tally& tally) {
  const tinygltf::Node& source = model.nodes[at(index)];
  const std::string place = fmt::format("nodes/{}", index);
  Node node;
  node.name = source.name;
  node.parent = parents[at(index)] < 0 ? -1 : newIndex[at(parents[at(index)])];
  for (const int child : source.children) node.children.push_back(newIndex[at(child)]);
  auto transform = readTransform(source, place, node);
  if (!transform) return transform.error();
  if (source.mesh >= 0 && !isIndex(source.mesh, model.meshes.size()))
    return Error{"", place + "/mesh", fmt::format("{} does not exist", source.mesh)};
  if (source.camera >= 0 && !isIndex(source.camera, model.cameras.size()))
    return Error{"", place + "/camera", fmt::format("{} does not exist", source.camera)};
  node.mesh = source.mesh;
  node.camera = source.camera;
  if (source.skin >= 0) ++tally["skinned nodes are shown undeformed"];
  if (const auto text = extensionText(source.extensions_json_string, "OVERCAST_occluder")) {
    auto occluder = parseOccluder(*text, place + "/extensions/OVERCAST_occluder");
    if (!occluder) return occluder.error();
    node.occluder = std::move(occluder).value();
  }
  return node;
}

Result<Mesh> readMesh(const tinygltf::Model& model, int index, Tally& tally) {
  std::optional<ApertureLink> link;
  if (const auto text = extensionText(model.meshes[at(index)].extensions_json_string, "OVERCAST_aperture")) {
    auto parsed = parseAperture(*text, fmt::format("meshes/{}/extensions/OVERCAST_aperture", index));
    if (!parsed) return parsed.error();
    link = std::move(parsed).value();
  }
  std::optional<ApertureBake> bake;
  if (const auto text = extensionText(model.meshes[at(index)].extensions_json_string, "OVERCAST_aperture_bake")) {
    auto parsed = parseApertureBake(*text, fmt::format("meshes/{}/extensions/OVERCAST_aperture_bake", index));
    if (!parsed) return parsed.error();
    bake = std::move(parsed).value();
  }
  auto mesh = readGltfMesh(model, index, link ? std::exchange(link->texCoord, 0) : 0, tally);
  if (mesh && mesh.value().visibility) mesh.value().apertureBake = bake;
  if (!mesh || !link) return mesh;
  if (mesh.value().textureCoordinates.empty() || mesh.value().normals.empty())
    ++tally["meshes have an aperture map, but no texture coordinates or normals on all primitives; it was left out"];
  else
    mesh.value().apertureMap = std::move(link);
  return mesh;
}

/// Reads the meshes that nodes use, drops those without triangles, and points the nodes at what is left.
Result<Done> readMeshes(const tinygltf::Model& model, Scene& scene, Tally& tally) {
  std::vector<bool> used(model.meshes.size(), false);
  for (const Node& node : scene.nodes)
    if (node.mesh >= 0) used[at(node.mesh)] = true;
  std::vector<int> newIndex(model.meshes.size(), -1);
  for (std::size_t i = 0; i < model.meshes.size(); ++i) {
    if (!used[i]) continue;
    auto mesh = readMesh(model, static_cast<int>(i), tally);
    if (!mesh) return mesh.error();
    if (mesh.value().triangles.empty()) {
      ++tally["meshes without triangles were left out"];
      continue;
    }
    if (const auto text = extensionText(model.meshes[i].extensions_json_string, "OVERCAST_levels")) {
      auto levels = readGltfLevels(model, *text, fmt::format("meshes/{}/extensions/OVERCAST_levels", i), mesh.value());
      if (!levels) return levels.error();
    }
    newIndex[i] = static_cast<int>(scene.meshes.size());
    scene.meshes.push_back(std::move(mesh).value());
  }
  for (Node& node : scene.nodes)
    if (node.mesh >= 0) node.mesh = newIndex[at(node.mesh)];
  return Done{};
}

/// Reads the perspective cameras and points the nodes at them.
void readCameras(const tinygltf::Model& model, Scene& scene, Tally& tally) {
  std::vector<int> newIndex(model.cameras.size(), -1);
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const tinygltf::Camera& source = model.cameras[i];
    const double angle = source.perspective.yfov;
    const double near = source.perspective.znear;
    if (source.type != "perspective" || !(angle > 0.0 && angle < std::numbers::pi) || !(near > 0.0) || !std::isfinite(near)) {
      ++tally["cameras that are not perspective or have impossible values were left out"];
      continue;
    }
    newIndex[i] = static_cast<int>(scene.cameras.size());
    scene.cameras.push_back({source.name, angle, near});
  }
  for (Node& node : scene.nodes)
    if (node.camera >= 0) node.camera = newIndex[at(node.camera)];
}

/// The old specular-glossiness materials keep their base colour in an extension.
std::vector<double> baseColourOf(const tinygltf::Material& source) {
  const auto found = source.extensions.find("KHR_materials_pbrSpecularGlossiness");
  if (found == source.extensions.end() || !found->second.Has("diffuseFactor")) return source.pbrMetallicRoughness.baseColorFactor;
  const tinygltf::Value& factor = found->second.Get("diffuseFactor");
  std::vector<double> colour;
  for (std::size_t i = 0; factor.IsArray() && i < factor.ArrayLen(); ++i)
    colour.push_back(factor.Get(static_cast<int>(i)).GetNumberAsDouble());
  return colour;
}

void readMaterials(const tinygltf::Model& model, Scene& scene, Tally& tally) {
  for (const tinygltf::Material& source : model.materials) {
    Material material{source.name, glm::vec4(1.0f)};
    const std::vector<double> colour = baseColourOf(source);
    bool inRange = colour.size() == 4;
    for (int c = 0; c < 4 && colour.size() == 4; ++c) {
      inRange = inRange && colour[at(c)] >= 0.0 && colour[at(c)] <= 1.0;
      material.baseColour[c] = static_cast<float>(std::clamp(colour[at(c)], 0.0, 1.0));
    }
    if (!inRange) ++tally["base colours outside 0 to 1 were clamped"];
    scene.materials.push_back(std::move(material));
  }
}

Result<Done> readLighting(const tinygltf::Scene& source, int index, const std::vector<int>& newIndex, Scene& scene) {
  const auto text = extensionText(source.extensions_json_string, "OVERCAST_lighting");
  if (!text) return Done{};
  const std::string place = fmt::format("scenes/{}/extensions/OVERCAST_lighting", index);
  auto lighting = parseLighting(*text, place);
  if (!lighting) return lighting.error();
  for (std::size_t i = 0; i < lighting.value().areaLights.size(); ++i) {
    int& node = lighting.value().areaLights[i].node;
    if (node < 0) continue;
    if (!isIndex(node, newIndex.size()) || newIndex[at(node)] < 0)
      return Error{"", fmt::format("{}/areaLights/{}/node", place, i), fmt::format("{} is no node of the scene", node)};
    node = newIndex[at(node)];
  }
  scene.lighting = std::move(lighting).value();
  return Done{};
}

Result<Scene> convert(const tinygltf::Model& model, Tally& tally) {
  Scene scene;
  auto parents = parentsOf(model);
  if (!parents) return parents.error();
  const int index = model.defaultScene >= 0 || model.scenes.empty() ? model.defaultScene : 0;
  if (index >= 0 && !isIndex(index, model.scenes.size())) return Error{"", "scene", fmt::format("{} does not exist", index)};
  auto roots = rootsOf(model, parents.value(), index);
  if (!roots) return roots.error();
  const std::vector<int> newIndex = newNodeIndices(model, roots.value());
  for (std::size_t i = 0; i < newIndex.size(); ++i) {
    if (newIndex[i] < 0) {
      ++tally["nodes outside the default scene were left out"];
      continue;
    }
    auto node = readNode(model, static_cast<int>(i), parents.value(), newIndex, tally);
    if (!node) return node.error();
    scene.nodes.push_back(std::move(node).value());
  }
  auto meshes = readMeshes(model, scene, tally);
  if (!meshes) return meshes.error();
  readCameras(model, scene, tally);
  readMaterials(model, scene, tally);
  auto animations = readGltfAnimations(model, newIndex, scene.nodes, tally);
  if (!animations) return animations.error();
  scene.animations = std::move(animations).value();
  if (index < 0) return scene;
  scene.name = model.scenes[at(index)].name;
  auto lighting = readLighting(model.scenes[at(index)], index, newIndex, scene);
  if (!lighting) return lighting.error();
  return scene;
}

}  // namespace

Result<Scene> readGltfScene(const std::filesystem::path& path) {
  auto document = readGltfDocument(path);
  if (!document) return document.error();
  Tally tally;
  auto scene = convert(*document.value().model, tally);
  if (!scene) return Error{path.string(), scene.error().place, scene.error().reason};
  scene.value().notes = std::move(document.value().notes);
  for (const auto& [what, count] : tally) scene.value().notes.push_back(fmt::format("{} {}", count, what));
  return scene;
}

}  // namespace overcast
