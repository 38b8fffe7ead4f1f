// How the brute-force loops are laid out: points in blocks of kLanes, coordinate by coordinate, so that one triangle meets a whole block in
// one loop that the compiler turns into vector instructions. Sums run over triangles in their order: no result depends on the vector width.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/vec3.hpp>

// One copy of a function per instruction set, chosen at run time. Not under sanitizers, which are not set up when the choice is made.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define OVERCAST_REFERENCE_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define OVERCAST_REFERENCE_CLONES
#endif

namespace overcast::reference {

inline constexpr std::size_t kLanes = 16;

using Lanes = std::array<double, kLanes>;

struct PointBlock {
  Lanes x{};
  Lanes y{};
  Lanes z{};
};

/// Calls block(points, results) for blocks of points in parallel; the last one is filled up with copies of its first point.
template <class Block>
std::vector<double> forBlocks(std::span<const glm::dvec3> points, const Block& block) {
  std::vector<double> results(points.size());
  const std::size_t blocks = (points.size() + kLanes - 1) / kLanes;
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t b) {
    const std::size_t first = b * kLanes;
    const std::size_t count = std::min(kLanes, points.size() - first);
    PointBlock lanes;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const glm::dvec3& p = points[first + (l < count ? l : 0)];
      lanes.x[l] = p.x;
      lanes.y[l] = p.y;
      lanes.z[l] = p.z;
    }
    Lanes values{};
    block(lanes, values);
    std::copy_n(values.begin(), count, results.begin() + static_cast<std::ptrdiff_t>(first));
  });
  return results;
}

}  // namespace overcast::reference
