#include "bake/lattice.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace overcast {

Lattice snap(const Mesh& mesh, const Grid& grid) {
  double reach = std::max({grid.size.x, grid.size.y, grid.size.z});
  for (const glm::dvec3& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) reach = std::max(reach, std::abs(p[axis] - grid.origin[axis]) / grid.voxelSize);
  const int bits = 29 - static_cast<int>(std::ceil(std::log2(reach + 1.0)));
  OVERCAST_REQUIRE(bits >= 1, "mesh reaches {} voxels from the grid's origin, at most 2^27 are allowed", reach);
  Lattice lattice;
  lattice.unit = std::int64_t{1} << bits;
  lattice.points.reserve(mesh.positions.size());
  for (const glm::dvec3& p : mesh.positions) lattice.points.push_back(snapPoint(lattice, grid, p));
  return lattice;
}

glm::ivec3 snapPoint(const Lattice& lattice, const Grid& grid, const glm::dvec3& point) {
  return glm::ivec3(glm::round((point - grid.origin) / grid.voxelSize * static_cast<double>(lattice.unit)));
}

}  // namespace overcast
