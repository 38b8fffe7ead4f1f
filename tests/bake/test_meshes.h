// Meshes and grids that the tests of bake share, beside tests/reference/shapes.h.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include <glm/geometric.hpp>

#include "bake/distance.h"
#include "formats/mesh.h"

namespace overcast::test {

/// Twelve triangles, outward; the last two are the face at high z.
inline Mesh boxBetween(const glm::dvec3& low, const glm::dvec3& high) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return mesh;
}

/// Latitude-longitude sphere, outward, vertices on the sphere; the first triangles are those around +z.
inline Mesh sphereMesh(const glm::dvec3& centre, double radius, int rings, int segments) {
  Mesh mesh;
  mesh.positions.push_back(centre + glm::dvec3(0.0, 0.0, radius));
  for (int r = 1; r < rings; ++r)
    for (int s = 0; s < segments; ++s) {
      const double theta = std::numbers::pi * r / rings, phi = 2.0 * std::numbers::pi * s / segments;
      mesh.positions.push_back(centre +
                               radius * glm::dvec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  mesh.positions.push_back(centre - glm::dvec3(0.0, 0.0, radius));
  const auto at = [&](int r, int s) {
    if (r == 0) return 0u;
    if (r == rings) return static_cast<std::uint32_t>(mesh.positions.size() - 1);
    return static_cast<std::uint32_t>(1 + (r - 1) * segments + s % segments);
  };
  for (int r = 0; r < rings; ++r)
    for (int s = 0; s < segments; ++s) {
      if (r > 0) mesh.triangles.emplace_back(at(r, s), at(r + 1, s + 1), at(r, s + 1));
      if (r < rings - 1) mesh.triangles.emplace_back(at(r, s), at(r + 1, s), at(r + 1, s + 1));
    }
  return mesh;
}

/// A cubic grid of n^3 samples over [low, high]^3.
inline Grid cubeGrid(int n, double low, double high) {
  return {glm::ivec3(n), glm::dvec3(low), (high - low) / (n - 1)};
}

inline glm::dvec3 samplePoint(const Grid& grid, std::uint64_t index) {
  const auto nx = static_cast<std::uint64_t>(grid.size.x), ny = static_cast<std::uint64_t>(grid.size.y);
  return grid.origin + grid.voxelSize * glm::dvec3(static_cast<double>(index % nx), static_cast<double>(index / nx % ny),
                                                   static_cast<double>(index / nx / ny));
}

}  // namespace overcast::test
