#include "runtime/passes/composite/composite_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "runtime/passes/composite/primitive.h"

namespace overcast {

static_assert(sizeof(shared::CompositeObject) == 160 && offsetof(shared::CompositeObject, boxMax) == 80 &&
              offsetof(shared::CompositeObject, field) == 128 && offsetof(shared::CompositeObject, slack) == 144);

namespace {

/// Coordinates whose squares still fit into a float with room for sums; a record beyond them could give infinity minus infinity.
constexpr double kLargestCoordinate = 1e15;

/// Share of the product of two columns' lengths up to which they count as orthogonal: transforms come as products of doubles.
constexpr double kOrthogonal = 1e-9;

double largestMagnitude(const glm::dmat3& m) {
  double largest = 0.0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) {
      if (!std::isfinite(m[c][r])) return std::numeric_limits<double>::infinity();
      largest = std::max(largest, std::abs(m[c][r]));
    }
  return largest;
}

/// Rotates columns p and q until they are orthogonal; false when they already are to the last bit that matters.
bool rotateColumns(glm::dmat3& m, int p, int q) {
  const double a = glm::dot(m[p], m[p]);
  const double b = glm::dot(m[q], m[q]);
  const double g = glm::dot(m[p], m[q]);
  if (std::abs(g) <= std::numeric_limits<double>::epsilon() * std::sqrt(a * b)) return false;
  const double zeta = (b - a) / (2.0 * g);
  const double t = std::copysign(1.0, zeta) / (std::abs(zeta) + std::hypot(1.0, zeta));
  const double c = 1.0 / std::hypot(1.0, t);
  const double s = c * t;
  const glm::dvec3 old = m[p];
  m[p] = c * old - s * m[q];
  m[q] = s * old + c * m[q];
  return true;
}

bool hasOrthogonalColumns(const glm::dmat3& m) {
  for (const auto& [p, q] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}})
    if (std::abs(glm::dot(m[p], m[q])) > kOrthogonal * glm::length(m[p]) * glm::length(m[q])) return false;
  return true;
}

double largestOf(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// The linear part as columns of lengths and the frame they make; columns are orthogonal and none is zero.
glm::dvec3 splitColumns(const glm::dmat3& m, glm::dmat3& frame) {
  const glm::dvec3 lengths(glm::length(m[0]), glm::length(m[1]), glm::length(m[2]));
  for (int axis = 0; axis < 3; ++axis) frame[axis] = m[axis] / lengths[axis];
  return lengths;
}

}  // namespace

glm::dmat3 orthogonalColumns(const glm::dmat3& matrix) {
  const double scale = largestMagnitude(matrix);
  OVERCAST_REQUIRE(std::isfinite(scale), "a matrix with an entry that is not finite");
  if (scale == 0.0) return matrix;
  glm::dmat3 m = matrix / scale;
  constexpr int kSweeps = 30;  // convergence is quadratic; four or five do
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool rotated = rotateColumns(m, 0, 1);
    rotated = rotateColumns(m, 0, 2) || rotated;
    rotated = rotateColumns(m, 1, 2) || rotated;
    if (!rotated) break;
  }
  return scale * m;
}

glm::dvec3 singularValues(const glm::dmat3& matrix) {
  const glm::dmat3 m = orthogonalColumns(matrix);
  std::array<double, 3> values{glm::length(m[0]), glm::length(m[1]), glm::length(m[2])};
  std::sort(values.begin(), values.end(), std::greater<>());
  return {values[0], values[1], values[2]};
}

PlacedObject placeObject(const Box& box, const glm::dmat4& worldFromUnits, const GlobalGrid& grid) {
  PlacedObject placed;
  const glm::dmat3 globalFromUnits = glm::dmat3(worldFromUnits) / grid.voxelSize;
  const glm::dvec3 origin = (glm::dvec3(worldFromUnits[3]) - centre(grid)) / grid.voxelSize;
  if (!(largestMagnitude(globalFromUnits) < kLargestCoordinate) || !(largestOf(origin) < kLargestCoordinate)) return placed;
  placed.sigmaMin = singularValues(globalFromUnits).z;
  if (!(placed.sigmaMin * kLargestCoordinate > 1.0)) return placed;
  const glm::dmat3 unitsFromGlobal = glm::inverse(globalFromUnits);
  const glm::dvec3 shift = -(unitsFromGlobal * origin);
  if (!(largestOf(shift) < kLargestCoordinate)) return placed;

  const auto row = [&](int r) {
    return glm::vec4(glm::dvec4(unitsFromGlobal[0][r], unitsFromGlobal[1][r], unitsFromGlobal[2][r], shift[r]));
  };
  shared::CompositeObject& object = placed.object;
  object.rowX = row(0);
  object.rowY = row(1);
  object.rowZ = row(2);
  glm::dvec3 gapScale(placed.sigmaMin);
  if (hasOrthogonalColumns(globalFromUnits))
    gapScale = {glm::length(globalFromUnits[0]), glm::length(globalFromUnits[1]), glm::length(globalFromUnits[2])};
  object.axisScale = glm::vec4(glm::dvec4(gapScale, placed.sigmaMin));
  object.boxMin = glm::vec4(glm::vec3(box.min), 0.0f);
  object.boxMax = glm::vec4(glm::vec3(box.max), 1.0f);
  object.present = 1;
  const glm::dvec3 middle = globalFromUnits * centre(box);
  const glm::dvec3 spread = globalFromUnits * extent(box);
  const double magnitude = 0.5 * glm::length(glm::dvec3(grid.size)) + glm::length(origin) + glm::length(middle) + glm::length(spread);
  placed.rounding = std::sqrt(3.0) * 0x1p-21 * magnitude;
  return placed;
}

shared::CompositeObject compositeObject(const AtlasEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid) {
  glm::dmat4 worldFromVoxel = worldFromLocal * glm::dmat4(entry.axes * entry.voxelSize);
  worldFromVoxel[3] = worldFromLocal * glm::dvec4(entry.axes * entry.origin, 1.0);
  PlacedObject placed = placeObject({glm::dvec3(0.0), glm::dvec3(entry.size - 1)}, worldFromVoxel, grid);
  shared::CompositeObject& object = placed.object;
  if (object.present == 0) return object;
  object.kind = entry.snorm8 ? shared::kKindVolume8 : shared::kKindVolume;
  object.parameters = glm::vec4(glm::vec3(entry.offset) + 0.5f, 0.0f);
  object.boxMin.w = static_cast<float>(placed.sigmaMin * entry.lowestBorder);
  object.boxMax.w = entry.lipschitz;
  object.more.x = static_cast<float>(placed.sigmaMin * entry.highest);
  // Filter weights may have 8 bits: each axis is off by at most 1/256 of a voxel, so the value by sqrt(3) / 256 times the slope.
  const double filtering = std::sqrt(3.0) / 256.0 * placed.sigmaMin;
  object.slack = static_cast<float>(2.0 * (filtering + placed.rounding) * entry.lipschitz);
  if (!entry.snorm8) return object;
  object.axisScale.w = static_cast<float>(placed.sigmaMin * entry.unit);
  // Devices may filter 8 bits in fixed point: a sixteenth of a step, twice.
  object.slack += static_cast<float>(2.0 / 16.0 / 127.0 * placed.sigmaMin * entry.unit);
  return object;
}

shared::CompositeObject compositeObject(const Primitive& primitive, const glm::dmat4& worldFromLocal, const GlobalGrid& grid) {
  glm::dmat4 worldFromUnits = worldFromLocal * glm::mat4_cast(primitive.rotation);
  worldFromUnits[3] = worldFromLocal * glm::dvec4(primitive.centre, 1.0);
  glm::dmat3 columns = glm::dmat3(worldFromUnits);
  for (int axis = 0; axis < 3; ++axis) columns[axis] *= primitive.halfExtents[axis];
  if (!(largestMagnitude(columns) / grid.voxelSize < kLargestCoordinate)) return {};
  const bool ellipsoid = primitive.shape == PrimitiveShape::ellipsoid;
  if (ellipsoid) {
    columns = orthogonalColumns(columns);
    for (const int axis : {0, 1})
      if (glm::length(columns[axis]) < glm::length(columns[2])) std::swap(columns[axis], columns[2]);
  }
  glm::dvec3 half = primitive.halfExtents;
  if (ellipsoid || hasOrthogonalColumns(columns)) {
    glm::dmat3 frame;
    half = splitColumns(columns, frame) / grid.voxelSize;
    worldFromUnits = glm::dmat4(frame * grid.voxelSize);
    worldFromUnits[3] = worldFromLocal * glm::dvec4(primitive.centre, 1.0);
  }
  const double largest = largestOf(half);
  half = glm::max(half, glm::dvec3(kThinnestPrimitive * largest));  // thinner than single floats can follow
  PlacedObject placed = placeObject({-half, half}, worldFromUnits, grid);
  if (placed.object.present == 0) return {};
  placed.object.kind = ellipsoid ? shared::kKindEllipsoid : shared::kKindCuboid;
  placed.object.parameters = glm::vec4(glm::vec3(half), 0.0f);
  // The error grows as an ellipsoid becomes thinner than a thousandth of its length.
  const double thin = std::max(1.0, 0.001 * largest / std::min({half.x, half.y, half.z}));
  const double solving = ellipsoid ? static_cast<double>(shared::kEllipsoidError) * thin * largest : 0.0;
  placed.object.slack = static_cast<float>(2.0 * (solving + placed.rounding));
  return placed.object;
}

}  // namespace overcast
