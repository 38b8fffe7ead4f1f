// Texture coordinates of formats that give them to the corners of faces, for vertices that have one each.
#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "formats/mesh_reader.h"

namespace overcast {
namespace {

/// A face without the corners that repeat one of its vertices.
std::vector<MappedCorner> distinctCorners(std::span<const MappedCorner> face) {
  std::vector<MappedCorner> distinct;
  std::unordered_set<std::uint32_t> seen;
  for (const MappedCorner& corner : face)
    if (seen.insert(corner.vertex).second) distinct.push_back(corner);
  return distinct;
}

/// One for each corner of the mesh; nothing when its faces are not found among those of the file.
std::optional<std::vector<MappedCorner>> matched(const RawMesh& mesh, const std::vector<MappedCorner>& corners,
                                                 const std::vector<std::uint64_t>& faceEnds) {
  std::vector<MappedCorner> all;
  all.reserve(mesh.corners.size());
  std::uint64_t begin = 0;
  for (const std::uint64_t end : faceEnds) {
    const std::vector<MappedCorner> face = distinctCorners(std::span(corners).subspan(begin, end - begin));
    begin = end;
    if (face.size() >= 3) all.insert(all.end(), face.begin(), face.end());
  }
  const bool same = std::equal(all.begin(), all.end(), mesh.corners.begin(), mesh.corners.end(),
                               [](const MappedCorner& corner, std::uint32_t vertex) { return corner.vertex == vertex; });
  if (!same) return std::nullopt;
  return all;
}

struct VertexAndCoordinate {
  std::uint32_t vertex;
  std::uint64_t coordinate;  ///< its bits: files name equal coordinates by many numbers
  bool operator==(const VertexAndCoordinate&) const = default;
};

struct Hash {
  std::size_t operator()(const VertexAndCoordinate& key) const {
    return static_cast<std::size_t>((key.coordinate ^ key.vertex * 0x9e3779b97f4a7c15u) * 0xff51afd7ed558ccdu);
  }
};

std::uint64_t bitsOf(const glm::vec2& coordinate) {
  return std::bit_cast<std::uint32_t>(coordinate.x) | std::uint64_t{std::bit_cast<std::uint32_t>(coordinate.y)} << 32;
}

}  // namespace

void mapCorners(RawMesh& mesh, const std::vector<glm::vec2>& coordinates, const std::vector<MappedCorner>& corners,
                const std::vector<std::uint64_t>& faceEnds) {
  const auto found = matched(mesh, corners, faceEnds);
  if (!found) return;
  const std::size_t vertices = mesh.positions.size();
  for (const MappedCorner& corner : *found) {
    if (corner.vertex >= vertices) continue;
    if (corner.coordinate >= coordinates.size() || !isFinite(glm::dvec3(coordinates[corner.coordinate], 0.0))) return;
  }
  std::unordered_map<VertexAndCoordinate, std::uint32_t, Hash> places;
  std::vector<bool> taken(vertices, false);
  mesh.textureCoordinates.assign(vertices, glm::vec2(0.0f));
  for (std::size_t i = 0; i < found->size(); ++i) {
    const std::uint32_t vertex = (*found)[i].vertex;
    if (vertex >= vertices) continue;
    const glm::vec2 coordinate = coordinates[(*found)[i].coordinate] + 0.0f;  // no negative zeros
    const auto [place, fresh] = places.emplace(VertexAndCoordinate{vertex, bitsOf(coordinate)}, vertex);
    if (fresh && taken[vertex]) {
      place->second = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(glm::dvec3(mesh.positions[vertex]));
      mesh.textureCoordinates.push_back(coordinate);
    } else if (fresh) {
      mesh.textureCoordinates[vertex] = coordinate;
      taken[vertex] = true;
    }
    mesh.corners[i] = place->second;
  }
}

}  // namespace overcast
