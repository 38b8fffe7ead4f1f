#include "runtime/rest_window.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace overcast {
namespace {

constexpr int kSmallest = 32;
/// Of the object's box: where it is not steeper than a distance, it reads more than two voxels there, between voxels too.
constexpr double kPadding = 4.0;

/// The object's box in voxels of the grid.
Box voxelBox(const GlobalGrid& grid, const shared::CompositeObject& object) {
  const glm::dmat3 voxelFromUnit = glm::inverse(glm::transpose(glm::dmat3(object.rowX, object.rowY, object.rowZ)));
  const glm::dvec3 shift(object.rowX.w, object.rowY.w, object.rowZ.w);
  Box box;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 unit(corner & 1 ? object.boxMax.x : object.boxMin.x, corner & 2 ? object.boxMax.y : object.boxMin.y,
                          corner & 4 ? object.boxMax.z : object.boxMin.z);
    include(box, 0.5 * glm::dvec3(grid.size) + voxelFromUnit * (unit - shift));
  }
  return box;
}

}  // namespace

GlobalGrid windowAbout(const GlobalGrid& grid, const shared::CompositeObject& object) {
  const double padding = kPadding - static_cast<double>(object.boxMin.w);
  const Box box = voxelBox(grid, object);
  const glm::dvec3 size(grid.size);
  const glm::dvec3 low = glm::clamp(glm::floor(box.min - padding), glm::dvec3(0.0), size);
  const glm::dvec3 high = glm::clamp(glm::ceil(box.max + padding), glm::dvec3(0.0), size);
  const glm::dvec3 needed = high - low;
  const int longest = static_cast<int>(std::max({needed.x, needed.y, needed.z}));
  int side = kSmallest;
  while (side < longest) side *= 2;
  GlobalGrid window = grid;
  window.size = glm::min(grid.size, glm::ivec3(side));
  const glm::ivec3 first = glm::min(glm::ivec3(low), grid.size - window.size);
  window.origin += grid.voxelSize * glm::dvec3(first);
  return window;
}

}  // namespace overcast
