#include "runtime/passes/composite/composite_object.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace overcast {

static_assert(sizeof(shared::CompositeObject) == 112 && offsetof(shared::CompositeObject, lastSample) == 80 &&
              offsetof(shared::CompositeObject, slack) == 96);

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

bool orthogonalColumns(const glm::dmat3& m) {
  for (const auto& [p, q] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}})
    if (std::abs(glm::dot(m[p], m[q])) > kOrthogonal * glm::length(m[p]) * glm::length(m[q])) return false;
  return true;
}

/// Bound of what two evaluations may be off in global voxels: by filter weights of 8 bits (each axis off by at most 1/256 of a local voxel,
/// so at most sqrt(3) / 256 times the slope), and by rounding of coordinates (`magnitude`: of points and of the object's place).
double slackOf(const AtlasEntry& entry, double sigmaMin, double magnitude) {
  const double filtering = std::sqrt(3.0) / 256.0 * sigmaMin * entry.lipschitz;
  const double rounding = std::sqrt(3.0) * 0x1p-21 * magnitude * entry.lipschitz;
  return 2.0 * (filtering + rounding);
}

}  // namespace

glm::dvec3 singularValues(const glm::dmat3& matrix) {
  const double scale = largestMagnitude(matrix);
  OVERCAST_REQUIRE(std::isfinite(scale), "a matrix with an entry that is not finite");
  if (scale == 0.0) return glm::dvec3(0.0);
  glm::dmat3 m = matrix / scale;
  constexpr int kSweeps = 30;  // convergence is quadratic; four or five do
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool rotated = rotateColumns(m, 0, 1);
    rotated = rotateColumns(m, 0, 2) || rotated;
    rotated = rotateColumns(m, 1, 2) || rotated;
    if (!rotated) break;
  }
  std::array<double, 3> values{glm::length(m[0]), glm::length(m[1]), glm::length(m[2])};
  std::sort(values.begin(), values.end(), std::greater<>());
  return scale * glm::dvec3(values[0], values[1], values[2]);
}

shared::CompositeObject compositeObject(const AtlasEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid) {
  shared::CompositeObject object{};
  const glm::dmat3 globalFromVoxel = glm::dmat3(worldFromLocal) * (entry.voxelSize / grid.voxelSize);
  const glm::dvec3 first = (glm::dvec3(worldFromLocal * glm::dvec4(entry.origin, 1.0)) - centre(grid)) / grid.voxelSize;
  const double farthest = std::max({std::abs(first.x), std::abs(first.y), std::abs(first.z)});
  if (!(largestMagnitude(globalFromVoxel) < kLargestCoordinate) || !(farthest < kLargestCoordinate)) return object;
  const double sigmaMin = singularValues(globalFromVoxel).z;
  if (!(sigmaMin * kLargestCoordinate > 1.0)) return object;

  const glm::dmat3 voxelFromGlobal = glm::inverse(globalFromVoxel);
  const glm::dvec3 shift = -(voxelFromGlobal * first);
  if (!(largestMagnitude({shift, glm::dvec3(0.0), glm::dvec3(0.0)}) < kLargestCoordinate)) return object;
  const auto row = [&](int r) {
    return glm::vec4(glm::dvec4(voxelFromGlobal[0][r], voxelFromGlobal[1][r], voxelFromGlobal[2][r], shift[r]));
  };
  object.rowX = row(0);
  object.rowY = row(1);
  object.rowZ = row(2);
  glm::dvec3 gapScale(sigmaMin);
  if (orthogonalColumns(globalFromVoxel))
    gapScale = {glm::length(globalFromVoxel[0]), glm::length(globalFromVoxel[1]), glm::length(globalFromVoxel[2])};
  object.axisScale = glm::vec4(glm::dvec4(gapScale, sigmaMin));
  object.firstTexel = glm::vec4(glm::vec3(entry.offset) + 0.5f, static_cast<float>(sigmaMin * entry.lowestBorder));
  object.lastSample = glm::vec4(glm::vec3(entry.size - 1), entry.lipschitz);
  const glm::dvec3 spread = globalFromVoxel * glm::dvec3(entry.size);
  const double magnitude = 0.5 * glm::length(glm::dvec3(grid.size)) + glm::length(first) + glm::length(spread);
  object.slack = static_cast<float>(slackOf(entry, sigmaMin, magnitude));
  object.present = 1;
  return object;
}

}  // namespace overcast
