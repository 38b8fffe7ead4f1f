#include "formats/scene_check.h"

#include <cmath>

namespace overcast {
namespace {

bool isIndexOrNone(int index, std::size_t size) {
  return index >= -1 && index < static_cast<int>(size);
}

bool isFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::string brokenMesh(const Mesh& mesh, std::size_t materials) {
  for (const glm::dvec3& p : mesh.positions)
    if (!isFinite(p)) return "has a position that is not finite";
  if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size()) return "has another number of normals than positions";
  for (const glm::vec3& n : mesh.normals)
    if (!isFinite(n)) return "has a normal that is not finite";
  if (mesh.visibility && mesh.normals.empty()) return "has visibility without normals";
  if (mesh.visibility)
    if (std::string broken = brokenVisibility(*mesh.visibility, mesh.positions.size()); !broken.empty()) return broken;
  if (mesh.apertureBake && !mesh.visibility) return "has word of the bake of visibility without any";
  if (!mesh.textureCoordinates.empty() && mesh.textureCoordinates.size() != mesh.positions.size())
    return "has another number of texture coordinates than positions";
  for (const glm::vec2& c : mesh.textureCoordinates)
    if (!isFinite(glm::dvec3(c, 0.0))) return "has a texture coordinate that is not finite";
  if (mesh.apertureMap && (mesh.normals.empty() || mesh.textureCoordinates.empty()))
    return "has an aperture map without normals or texture coordinates";
  if (mesh.levels && mesh.parts.size() != 1) return "has levels but not one part";
  if (mesh.levels)
    if (std::string broken = brokenLevels(*mesh.levels, mesh.positions.size(), mesh.triangles.size()); !broken.empty()) return broken;
  for (const glm::uvec3& t : mesh.triangles)
    if (t.x >= mesh.positions.size() || t.y >= mesh.positions.size() || t.z >= mesh.positions.size()) return "has an index out of range";
  std::size_t next = 0;
  for (const MeshPart& part : mesh.parts) {
    if (part.firstTriangle != next) return "has parts that do not follow each other";
    if (!isIndexOrNone(part.material, materials)) return "has a part with an unknown material";
    next += part.triangleCount;
  }
  return next == mesh.triangles.size() ? "" : "has triangles outside its parts";
}

std::string brokenLinks(const Scene& scene) {
  const std::size_t count = scene.nodes.size();
  std::vector<int> open;
  for (std::size_t i = 0; i < count; ++i) {
    const Node& node = scene.nodes[i];
    if (!isIndexOrNone(node.parent, count)) return fmt::format("node {} has parent {}", i, node.parent);
    if (!isIndexOrNone(node.mesh, scene.meshes.size())) return fmt::format("node {} has mesh {}", i, node.mesh);
    if (!isIndexOrNone(node.camera, scene.cameras.size())) return fmt::format("node {} has camera {}", i, node.camera);
    for (const int child : node.children)
      if (child < 0 || !isIndexOrNone(child, count) || scene.nodes[static_cast<std::size_t>(child)].parent != static_cast<int>(i))
        return fmt::format("node {} and its child {} disagree", i, child);
    if (node.parent < 0) open.push_back(static_cast<int>(i));
  }
  std::size_t reached = 0;
  for (; !open.empty() && reached <= count; ++reached) {
    const auto& children = scene.nodes[static_cast<std::size_t>(open.back())].children;
    open.pop_back();
    open.insert(open.end(), children.begin(), children.end());
  }
  return reached == count ? "" : "the nodes are no trees";
}

std::string brokenChannel(const AnimationChannel& channel, std::size_t nodes) {
  if (channel.node < 0 || !isIndexOrNone(channel.node, nodes)) return "moves an unknown node";
  if (channel.property < AnimatedProperty::translation || channel.property > AnimatedProperty::scale) return "moves an unknown property";
  if (channel.interpolation < Interpolation::step || channel.interpolation > Interpolation::cubicSpline)
    return "has an unknown interpolation";
  if (channel.times.empty()) return "has no keys";
  for (std::size_t i = 0; i < channel.times.size(); ++i) {
    const double time = channel.times[i];
    if (!std::isfinite(time) || time < 0.0 || (i > 0 && !(time > channel.times[i - 1]))) return "has times that do not increase";
  }
  const std::size_t perKey = channel.interpolation == Interpolation::cubicSpline ? 3 : 1;
  if (channel.values.size() != channel.times.size() * perKey) return "has another number of values than its times need";
  for (const glm::dvec4& v : channel.values)
    if (!isFinite(glm::dvec3(v)) || !std::isfinite(v.w)) return "has a value that is not finite";
  return "";
}

/// Occluders pass the parser of their JSON, whose own promises these are.
std::string brokenOccluder(const Occluder& occluder) {
  if (occluder.representation < Representation::volume || occluder.representation > Representation::heightfield)
    return "has an unknown representation";
  if (occluder.primitive.has_value() != (occluder.representation == Representation::primitive))
    return "has a primitive too many or too few";
  return occluder.primitive && !isWhole(*occluder.primitive) ? "has a primitive that is out of range" : "";
}

}  // namespace

std::string brokenInvariant(const Scene& scene) {
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const std::string broken = brokenMesh(scene.meshes[i], scene.materials.size());
    if (!broken.empty()) return fmt::format("mesh {} {}", i, broken);
  }
  for (std::size_t a = 0; a < scene.animations.size(); ++a) {
    for (std::size_t c = 0; c < scene.animations[a].channels.size(); ++c) {
      const std::string broken = brokenChannel(scene.animations[a].channels[c], scene.nodes.size());
      if (!broken.empty()) return fmt::format("animation {} channel {} {}", a, c, broken);
    }
  }
  if (scene.lighting)
    for (const AreaLight& light : scene.lighting->areaLights)
      if (!isIndexOrNone(light.node, scene.nodes.size())) return fmt::format("an area light moves with node {}", light.node);
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const std::string broken = scene.nodes[n].occluder ? brokenOccluder(*scene.nodes[n].occluder) : "";
    if (!broken.empty()) return fmt::format("node {} {}", n, broken);
  }
  return brokenLinks(scene);
}

}  // namespace overcast
