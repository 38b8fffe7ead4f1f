// Mesh: an indexed triangle mesh, and the reader of OBJ, PLY, STL and OFF files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "formats/aperture.h"
#include "formats/aperture_bake.h"
#include "formats/aperture_link.h"
#include "formats/result.h"
#include "formats/sandbox.h"
#include "formats/terrain_levels.h"

namespace overcast {

/// An axis-aligned box; empty (min > max) until something is put in.
struct Box {
  glm::dvec3 min{1e300};
  glm::dvec3 max{-1e300};
};

bool isEmpty(const Box& box);
glm::dvec3 centre(const Box& box);
glm::dvec3 extent(const Box& box);  ///< max - min; zero for an empty box
double diagonal(const Box& box);    ///< length of the extent
void include(Box& box, const glm::dvec3& point);
void include(Box& box, const Box& other);

/// A run of triangles with one material.
struct MeshPart {
  std::uint32_t firstTriangle = 0;
  std::uint32_t triangleCount = 0;
  int material = -1;  ///< index into Scene::materials, or -1
};

/// Triangles over shared vertices, in the units and axes of the file. Positions are double: meshes far from the origin keep their detail.
/// Invariants after any reader of `formats`: positions finite, every index below positions.size(), normals empty or one per
/// position (unit length or zero), texture coordinates empty or one per position and finite, parts cover all triangles in order without
/// gaps, visibility only beside normals and whole (formats/aperture.h, brokenVisibility), word of its bake only beside visibility, an
/// aperture map only beside normals and texture coordinates, levels whole (formats/terrain_levels.h, brokenLevels).
/// Not promised: closed, manifold, oriented, free of degenerate or duplicate triangles. `bake/repair.h` looks at that.
struct Mesh {
  std::string name;
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
  std::vector<glm::uvec3> triangles;
  std::vector<MeshPart> parts;
  std::optional<VertexVisibility> visibility = std::nullopt;  ///< of baked meshes
  std::vector<glm::vec2> textureCoordinates = {};             ///< v down, as in glTF
  std::optional<ApertureLink> apertureMap = std::nullopt;     ///< of baked meshes
  std::optional<ApertureBake> apertureBake = std::nullopt;    ///< of baked meshes: what made the visibility
  std::optional<MeshLevels> levels = std::nullopt;            ///< of terrains: coarser triangles over the same vertices
};

Box bounds(const Mesh& mesh);  ///< of the vertices that triangles use; empty when there is no triangle

/// What the reader saw and mended, so that nothing is silent.
struct MeshReadReport {
  std::uint64_t polygons = 0;           ///< faces in the file (PLY strips: their triangles)
  std::uint64_t triangulated = 0;       ///< of these, with more than three corners
  std::uint64_t shortFaces = 0;         ///< left out: fewer than three corners
  std::uint64_t badIndexFaces = 0;      ///< left out: an index outside the vertices
  std::uint64_t nonFiniteVertices = 0;  ///< faces that use one are left out
  std::uint64_t nonFiniteFaces = 0;
};

/// A mesh file and what had to be left out of it.
struct MeshFile {
  Mesh mesh;
  MeshReadReport report;
};

/// True when the extension (any case) is one that readMesh knows: .obj .ply .stl .off
bool isMeshFile(const std::filesystem::path& path);

/// Reads OBJ, PLY (ASCII, both endians, with faces or triangle strips), STL (ASCII, binary), OFF (ASCII, binary). Coordinates keep the
/// precision of the file: double for text and for PLY's doubles. The parse runs in a sandbox; counts and ranges of what comes back are
/// checked. Polygons are triangulated (concave ones by ear clipping). Faces with fewer than three corners, with bad indices or with
/// non-finite vertices are left out and counted; a non-finite vertex itself stays in place as zero, so that indices keep their meaning.
/// An Error when the file cannot be read, is cut short, or holds no usable triangle. (OBJ declares no counts: a cut between two of its
/// lines cannot be seen.) Vertices are kept as the file has them (STL: three per triangle), but for those of OBJ with several texture
/// coordinates, which are split where all faces have some (the v of OBJ points up: it becomes 1 - v); parts is one run without material.
///
/// OpenMesh 9 reads the faces of OBJ. It does not read the other formats here, because measured against real files it keeps single floats
/// only, welds or drops what it reads, takes cut files for whole, refuses legal ones (comments before OFF, bare returns, strips) and hangs
/// or crashes on damaged ones.
Result<MeshFile> readMesh(const std::filesystem::path& path, const SandboxLimits& limits = {});

/// Writes a mesh as ASCII OFF with 17 significant digits (reads back bit for bit). For tests and the data the project makes.
Result<Done> writeOff(const std::filesystem::path& path, const Mesh& mesh);

}  // namespace overcast
