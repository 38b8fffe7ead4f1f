// What the readers of mesh formats hand to readMesh. Internal to formats; everything here runs inside the sandbox.
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "formats/mesh.h"
#include "formats/result.h"

namespace overcast {

/// A corner whose index the file gave as negative or beyond 32 bits.
inline constexpr std::uint32_t kBadIndex = std::numeric_limits<std::uint32_t>::max();

/// Polygons as the file has them: nothing is checked against the number of vertices, positions may be infinite.
struct RawMesh {
  std::vector<glm::dvec3> positions;
  std::vector<std::uint32_t> corners;              ///< vertex indices of all faces, one after another
  std::vector<std::uint64_t> faceEnds;             ///< face f has the corners [faceEnds[f - 1], faceEnds[f])
  std::uint64_t shortFaces = 0;                    ///< faces with fewer than three corners, already left out
  std::vector<glm::vec2> textureCoordinates = {};  ///< empty or one per position, finite
};

bool isFinite(const glm::dvec3& p);

/// The corner that refers to vertex `index`; kBadIndex when that is negative or beyond 32 bits.
std::uint32_t toCorner(std::int64_t index);

/// Ends the face whose corners were appended since the last call; one with fewer than three is taken back and counted.
void endFace(RawMesh& mesh);

/// A corner of a face as a file with texture coordinates has it: indices that may name nothing.
struct MappedCorner {
  std::uint32_t vertex = kBadIndex;
  std::uint32_t coordinate = kBadIndex;
};

/// Gives `mesh` the texture coordinates that the corners of its faces name. `corners` are those of all faces of the file, faceEnds as in
/// RawMesh; some of the faces the mesh may have lost, and corners that repeat a vertex of their face. Vertices with several coordinates are
/// split: the first keeps its place, the others follow all vertices. Leaves the mesh alone when a face whose vertices are there lacks a
/// finite coordinate, or the faces are not those of the mesh.
void mapCorners(RawMesh& mesh, const std::vector<glm::vec2>& coordinates, const std::vector<MappedCorner>& corners,
                const std::vector<std::uint64_t>& faceEnds);

/// One reader for each format. Error::place says where; Error::file is filled in by the caller. Files cut short are an Error.
Result<RawMesh> parseObj(std::string_view text);
Result<RawMesh> parseOff(std::string_view text);
Result<RawMesh> parsePly(std::string_view text);
Result<RawMesh> parseStl(std::string_view text);

/// Drops faces that cannot be used, cuts the others into triangles, puts zero in place of positions that are not finite, and
/// counts all of that. Leaves Mesh::name and Mesh::parts empty. An Error when there are more vertices or triangles than Overcast takes.
Result<MeshFile> finishMesh(RawMesh raw);

}  // namespace overcast
