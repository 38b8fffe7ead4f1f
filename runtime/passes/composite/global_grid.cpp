#include "runtime/passes/composite/global_grid.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "runtime/passes/composite/composite.h"

namespace overcast {

GlobalGrid globalGrid(const Box& bounds, int resolution, int padding) {
  OVERCAST_REQUIRE(resolution >= shared::kBrickSide && resolution % shared::kBrickSide == 0 && 2 * padding < resolution,
                   "resolution {}, padding {}", resolution, padding);
  glm::dvec3 middle = isEmpty(bounds) ? glm::dvec3(0.0) : centre(bounds);
  glm::dvec3 sides = extent(bounds);
  double longest = std::max({sides.x, sides.y, sides.z});
  if (!(longest > 0.0)) {
    sides = glm::dvec3(1.0);
    longest = 1.0;
  }
  GlobalGrid grid;
  grid.voxelSize = longest / (resolution - 2 * padding);
  for (int axis = 0; axis < 3; ++axis) {
    // The tolerance keeps a side that is a whole number of bricks from gaining one by rounding.
    const double bricks = (sides[axis] / grid.voxelSize + 2 * padding) / shared::kBrickSide;
    grid.size[axis] = shared::kBrickSide * std::max(1, static_cast<int>(std::ceil(bricks * (1.0 - 1e-12))));
  }
  grid.origin = middle - 0.5 * grid.voxelSize * glm::dvec3(grid.size);
  return grid;
}

glm::dmat4 voxelFromWorld(const GlobalGrid& grid) {
  glm::dmat4 matrix(1.0 / grid.voxelSize);
  matrix[3] = glm::dvec4(-grid.origin / grid.voxelSize, 1.0);
  return matrix;
}

glm::dvec3 centre(const GlobalGrid& grid) {
  return grid.origin + 0.5 * grid.voxelSize * glm::dvec3(grid.size);
}

}  // namespace overcast
