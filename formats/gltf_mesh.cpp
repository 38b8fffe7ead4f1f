// Primitives of a glTF mesh to triangles (glTF 2.0, 3.7.2).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <tiny_gltf.h>

#include "formats/gltf_accessor.h"
#include "formats/gltf_reader.h"

namespace overcast {
namespace {

bool isFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Positions of one primitive: where they start in the mesh, and how many there are.
struct VertexRange {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// Vertices already in the mesh by their POSITION and NORMAL accessors, so that primitives which share vertices go on sharing them.
using SharedVertices = std::map<std::pair<int, int>, VertexRange>;

struct MeshUnderway {
  Mesh mesh;
  SharedVertices shared;
  std::vector<bool> finite;  ///< one per position
  bool lacksNormals = false;
};

/// A unit vector as it is (bit for bit), another one normalised, and zero when it has no direction.
glm::vec3 unitOrZero(const glm::dvec3& v) {
  const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0.0) || !std::isfinite(length)) return glm::vec3(0.0f);
  return std::abs(length - 1.0) < 1e-5 ? glm::vec3(v) : glm::vec3(v / length);
}

int attribute(const tinygltf::Primitive& primitive, const char* name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

Result<VertexRange> addVertices(const tinygltf::Model& model, int position, int normal, MeshUnderway& underway, Tally& tally) {
  const auto known = underway.shared.find({position, normal});
  if (known != underway.shared.end()) return known->second;
  auto positions = readNumbers(model, position, 3);
  if (!positions) return positions.error();
  const std::vector<double>& p = positions.value();
  const std::size_t count = p.size() / 3;
  Mesh& mesh = underway.mesh;
  if (count > std::numeric_limits<std::uint32_t>::max() - mesh.positions.size()) return Error{"", "POSITION", "has too many vertices"};
  const VertexRange range{static_cast<std::uint32_t>(mesh.positions.size()), static_cast<std::uint32_t>(count)};
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 point{p[3 * i], p[3 * i + 1], p[3 * i + 2]};
    underway.finite.push_back(isFinite(point));
    mesh.positions.push_back(isFinite(point) ? point : glm::dvec3(0.0));
    if (!isFinite(point)) ++tally["vertices are not finite numbers; their triangles were left out"];
  }
  mesh.normals.resize(mesh.positions.size(), glm::vec3(0.0f));
  if (normal >= 0) {
    auto normals = readNumbers(model, normal, 3);
    if (!normals) return normals.error();
    const std::vector<double>& n = normals.value();
    if (n.size() != p.size()) return Error{"", "NORMAL", fmt::format("has {} elements where POSITION has {}", n.size() / 3, count)};
    for (std::size_t i = 0; i < count; ++i) mesh.normals[range.first + i] = unitOrZero({n[3 * i], n[3 * i + 1], n[3 * i + 2]});
  }
  underway.shared.emplace(std::pair{position, normal}, range);
  return range;
}

/// Corner numbers of triangle `i` in the order of glTF 2.0, 3.7.2.1, so that strips and fans keep their winding.
std::array<std::size_t, 3> corners(int mode, std::size_t i) {
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) return {i, i + 1 + i % 2, i + 2 - i % 2};
  if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {i + 1, i + 2, 0};
  return {3 * i, 3 * i + 1, 3 * i + 2};
}

Result<std::vector<std::uint32_t>> indicesOf(const tinygltf::Model& model, const tinygltf::Primitive& primitive, std::uint32_t vertices) {
  if (primitive.indices >= 0) return readIndices(model, primitive.indices);
  std::vector<std::uint32_t> all(vertices);
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

Result<Done> addPrimitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive, MeshUnderway& underway, Tally& tally) {
  const bool triangles = primitive.mode == TINYGLTF_MODE_TRIANGLES;
  if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
    return Error{"", "mode", fmt::format("{} is not a glTF 2.0 primitive mode", primitive.mode)};
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
    ++tally["primitives of points or lines were left out"];
    return Done{};
  }
  const int position = attribute(primitive, "POSITION");
  const int normal = attribute(primitive, "NORMAL");
  if (position < 0) {
    ++tally["primitives without positions were left out"];
    return Done{};
  }
  if (primitive.material >= 0 && static_cast<std::size_t>(primitive.material) >= model.materials.size())
    return Error{"", "material", fmt::format("{} does not exist", primitive.material)};
  if (!primitive.targets.empty()) ++tally["primitives with morph targets are undeformed"];
  auto range = addVertices(model, position, normal, underway, tally);
  if (!range) return range.error();
  auto indices = indicesOf(model, primitive, range.value().count);
  if (!indices) return indices.error();
  const std::vector<std::uint32_t>& index = indices.value();
  for (const std::uint32_t i : index)
    if (i >= range.value().count) return Error{"", "indices", fmt::format("{} is outside the {} vertices", i, range.value().count)};

  Mesh& mesh = underway.mesh;
  MeshPart part{static_cast<std::uint32_t>(mesh.triangles.size()), 0, primitive.material};
  const std::size_t count = triangles ? index.size() / 3 : index.size() < 3 ? 0 : index.size() - 2;
  if (count > std::numeric_limits<std::uint32_t>::max() - mesh.triangles.size()) return Error{"", "indices", "hold too many triangles"};
  if (triangles && index.size() % 3 != 0) ++tally["primitives end in an incomplete triangle, which was left out"];
  for (std::size_t i = 0; i < count; ++i) {
    glm::uvec3 triangle;
    bool finite = true;
    for (int c = 0; c < 3; ++c) {
      triangle[c] = range.value().first + index[corners(primitive.mode, i)[static_cast<std::size_t>(c)]];
      finite = finite && underway.finite[triangle[c]];
    }
    if (finite) mesh.triangles.push_back(triangle);
  }
  part.triangleCount = static_cast<std::uint32_t>(mesh.triangles.size()) - part.firstTriangle;
  if (part.triangleCount == 0) return Done{};
  if (normal < 0) underway.lacksNormals = true;
  mesh.parts.push_back(part);
  return Done{};
}

}  // namespace

Result<Mesh> readGltfMesh(const tinygltf::Model& model, int mesh, Tally& tally) {
  const tinygltf::Mesh& source = model.meshes[static_cast<std::size_t>(mesh)];
  MeshUnderway underway;
  underway.mesh.name = source.name;
  for (std::size_t i = 0; i < source.primitives.size(); ++i) {
    auto added = addPrimitive(model, source.primitives[i], underway, tally);
    if (added) continue;
    const Error& error = added.error();
    return Error{"", fmt::format("meshes/{}/primitives/{}", mesh, i), error.place + ": " + error.reason};
  }
  if (underway.lacksNormals) {
    const bool someHave = std::any_of(underway.shared.begin(), underway.shared.end(), [](const auto& e) { return e.first.second >= 0; });
    if (someHave) ++tally["meshes have normals on some primitives only; these were left out"];
    underway.mesh.normals.clear();
  }
  if (underway.mesh.parts.empty()) underway.mesh.normals.clear();
  return std::move(underway.mesh);
}

}  // namespace overcast
