// Lattice: vertices rounded to integers relative to a grid, so that every orientation predicate of bake/sign.cpp is exact.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "bake/distance.h"
#include "formats/mesh.h"

namespace overcast {

/// Mesh vertices in units of voxelSize / unit, relative to the grid's origin: sample i of the grid lies at i * unit along each axis.
/// Coordinates are below 2^29 in magnitude, so 2D orientations fit 64 bits and 3D ones 128. Rounding moves a vertex by at most
/// half a unit: voxelSize * 2^-24 for a grid of 32.
struct Lattice {
  std::vector<glm::ivec3> points;
  std::int64_t unit = 1;  ///< a power of two
};

/// `mesh` lies within 2^27 voxels of the grid's origin.
Lattice snap(const Mesh& mesh, const Grid& grid);

/// One more point of the grid's box or the mesh's in units of `lattice`.
glm::ivec3 snapPoint(const Lattice& lattice, const Grid& grid, const glm::dvec3& point);

__extension__ typedef __int128 Int128;  // NOLINT(modernize-use-using): __extension__ takes no using

/// Twice the signed area of (a, b, c) seen along -x, in the plane (y, z): the x component of (b - a) x (c - a).
inline std::int64_t orientation(const glm::ivec3& a, const glm::ivec3& b, const glm::ivec3& c) {
  return std::int64_t{b.y - a.y} * (c.z - a.z) - std::int64_t{b.z - a.z} * (c.y - a.y);
}

}  // namespace overcast
