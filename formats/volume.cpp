#include "formats/volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Imath/half.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace overcast {
namespace {

constexpr float kLargestHalf = 65504.0f;
constexpr float kLargestSnorm8 = 127.0f;
constexpr double kSmallestHalfStep = 0x1p-24;

/// Trilinear interpolation at a point in units of samples, inside the box.
double interpolate(const Volume& volume, const glm::dvec3& u) {
  const glm::ivec3 cell = glm::min(glm::ivec3(u), volume.size - 2);
  const glm::dvec3 t = u - glm::dvec3(cell);
  const auto along = [&](int j, int k) {
    const std::size_t first = sampleIndex(volume, cell.x, cell.y + j, cell.z + k);
    return volume.distance[first] * (1.0 - t.x) + volume.distance[first + 1] * t.x;
  };
  const double near = along(0, 0) * (1.0 - t.y) + along(1, 0) * t.y;
  const double far = along(0, 1) * (1.0 - t.y) + along(1, 1) * t.y;
  return near * (1.0 - t.z) + far * t.z;
}

/// Largest squared norm of the gradient within one cell, times the squared voxel size. Along each axis one component of a trilinear
/// function's gradient is constant and the others are linear, so that the squared norm is convex: it is largest at a corner, where the
/// gradient is made of the differences along the corner's three edges.
double squaredSlope(const Volume& volume, int i, int j, int k) {
  std::array<double, 8> corner{};
  for (int c = 0; c < 8; ++c)
    corner[static_cast<std::size_t>(c)] = volume.distance[sampleIndex(volume, i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2))];
  double largest = 0.0;
  for (std::size_t c = 0; c < 8; ++c) {
    double sum = 0.0;
    for (const std::size_t axis : {1u, 2u, 4u}) sum += (corner[c ^ axis] - corner[c]) * (corner[c ^ axis] - corner[c]);
    largest = std::max(largest, sum);
  }
  return largest;
}

/// The smallest float of 4 significant bits, 127 of which reach `largest`: 7 bits times 4 are 11, which half floats hold exactly.
float stepFor(float largest) {
  int exponent = 0;
  const double share = std::frexp(static_cast<double>(largest) / kLargestSnorm8, &exponent);
  const double step = std::ldexp(std::ceil(16.0 * share) / 16.0, exponent);
  return static_cast<float>(std::max(step, 0x1p-126));  // exact down there too, and never 0
}

bool isMultipleOf(float step, float distance) {
  const float count = std::nearbyint(distance / step);
  return std::abs(count) <= kLargestSnorm8 && count * step == distance;
}

bool isQuantised(const Volume& volume) {
  return volume.step >= std::numeric_limits<float>::min() &&
         std::all_of(volume.distance.begin(), volume.distance.end(), [&](float d) { return isMultipleOf(volume.step, d); });
}

Volume rounded(Volume volume, float step) {
  for (float& d : volume.distance) d = step * std::nearbyint(d / step) + 0.0f;  // 0 and not -0, which no 8 bits hold
  volume.step = step;
  return volume;
}

bool borderIsNegative(const Volume& volume) {
  for (int k = 0; k < volume.size.z; ++k)
    for (int j = 0; j < volume.size.y; ++j) {
      const bool whole = k == 0 || j == 0 || k == volume.size.z - 1 || j == volume.size.y - 1;
      for (int i = 0; i < volume.size.x; i += whole ? 1 : volume.size.x - 1)
        if (volume.distance[sampleIndex(volume, i, j, k)] < 0.0f) return true;
    }
  return false;
}

}  // namespace

std::size_t sampleIndex(const Volume& volume, int i, int j, int k) {
  return static_cast<std::size_t>(i) +
         static_cast<std::size_t>(volume.size.x) *
             (static_cast<std::size_t>(j) + static_cast<std::size_t>(volume.size.y) * static_cast<std::size_t>(k));
}

bool isWhole(const Volume& volume) {
  const auto side = [](int n) { return n >= 2 && n <= kMaxVolumeSide; };
  return side(volume.size.x) && side(volume.size.y) && side(volume.size.z) && std::isfinite(volume.voxelSize) && volume.voxelSize > 0.0 &&
         std::isfinite(volume.origin.x) && std::isfinite(volume.origin.y) && std::isfinite(volume.origin.z) &&
         volume.distance.size() == sampleIndex(volume, 0, 0, volume.size.z) &&
         std::all_of(volume.distance.begin(), volume.distance.end(), [](float d) { return std::isfinite(d); }) &&
         (volume.step == 0.0f || isQuantised(volume));
}

Box bounds(const Volume& volume) {
  return {volume.origin, volume.origin + glm::dvec3(volume.size - 1) * volume.voxelSize};
}

double sampleVolume(const Volume& volume, const glm::dvec3& point) {
  const glm::dvec3 u = (point - volume.origin) / volume.voxelSize;
  const glm::dvec3 q = glm::clamp(u, glm::dvec3(0.0), glm::dvec3(volume.size - 1));
  const double phi = interpolate(volume, q);
  if (u == q) return phi;
  const glm::dvec3 beyond = u - q;
  const double gap = glm::length(beyond) * volume.voxelSize;
  if (phi < 0.0) return gap + phi;
  const glm::dvec3 step = beyond / std::max({std::abs(beyond.x), std::abs(beyond.y), std::abs(beyond.z)});
  const double slope = (phi - interpolate(volume, q - step)) / (glm::length(step) * volume.voxelSize);
  const double cosine = std::clamp(slope, 0.0, 1.0);
  return std::hypot(gap + cosine * phi, std::sqrt(1.0 - cosine * cosine) * phi);
}

double lipschitzBound(const Volume& volume) {
  OVERCAST_REQUIRE(isWhole(volume), "a volume of {} distances is not whole", volume.distance.size());
  double largest = 0.0;
  for (int k = 0; k + 1 < volume.size.z; ++k)
    for (int j = 0; j + 1 < volume.size.y; ++j)
      for (int i = 0; i + 1 < volume.size.x; ++i) largest = std::max(largest, squaredSlope(volume, i, j, k));
  const double slope = std::sqrt(largest) / volume.voxelSize;
  return borderIsNegative(volume) ? std::hypot(1.0, slope) : std::max(1.0, slope);
}

VolumeBits chooseBits(const Volume& volume, VolumeBits bits) {
  if (bits != VolumeBits::automatic) return bits;
  if (volume.step > 0.0f) return VolumeBits::snorm8;
  if (kSmallestHalfStep > volume.voxelSize / 1000.0) return VolumeBits::single;
  const bool fits = std::all_of(volume.distance.begin(), volume.distance.end(), [](float d) { return std::abs(d) <= kLargestHalf; });
  return fits ? VolumeBits::half : VolumeBits::single;
}

int bitCount(VolumeBits bits) {
  OVERCAST_REQUIRE(bits != VolumeBits::automatic, "no bits were chosen ({})", static_cast<int>(bits));
  return bits == VolumeBits::snorm8 ? 8 : bits == VolumeBits::half ? 16 : 32;
}

const char* name(VolumeBits bits) {
  const int count = bitCount(bits);
  return count == 8 ? "snorm8" : count == 16 ? "half" : "single";
}

Volume asStored(Volume volume, VolumeBits bits) {
  const VolumeBits chosen = chooseBits(volume, bits);
  if (chosen == VolumeBits::snorm8) {
    if (volume.step > 0.0f) return volume;
    float largest = 0.0f;
    for (const float d : volume.distance) largest = std::max(largest, std::abs(d));
    return rounded(std::move(volume), stepFor(largest));
  }
  if (chosen == VolumeBits::half)
    for (float& d : volume.distance) d = static_cast<float>(Imath::half(d));
  volume.step = 0.0f;
  return volume;
}

}  // namespace overcast
