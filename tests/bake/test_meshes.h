// Small meshes that the tests of bake share.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <glm/geometric.hpp>

#include "bake/distance.h"
#include "formats/mesh.h"

namespace overcast::test {

inline void append(Mesh& mesh, const Mesh& other) {
  const auto offset = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const glm::uvec3& t : other.triangles) mesh.triangles.push_back(t + offset);
}

/// Twelve triangles, outward; the last two are the face at high z.
inline Mesh boxMesh(const glm::dvec3& low, const glm::dvec3& high) {
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

/// Torus around the z axis, outward.
inline Mesh torusMesh(double major, double minor, int around, int across) {
  Mesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2.0 * std::numbers::pi * i / around, v = 2.0 * std::numbers::pi * j / across;
      mesh.positions.emplace_back((major + minor * std::cos(v)) * std::cos(u), (major + minor * std::cos(v)) * std::sin(u),
                                  minor * std::sin(v));
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i % around * across + j % across); };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return mesh;
}

/// Unconnected random triangles in the unit cube.
inline Mesh soupMesh(int count, double size, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 base(uniform(), uniform(), uniform());
    for (std::uint32_t corner = 0; corner < 3; ++corner)
      mesh.positions.push_back(base + size * (glm::dvec3(uniform(), uniform(), uniform()) - 0.5));
    mesh.triangles.push_back(glm::uvec3(0, 1, 2) + static_cast<std::uint32_t>(3 * i));
  }
  return mesh;
}

inline Mesh reversed(Mesh mesh) {
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
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

/// The generalised winding number by summing solid angles in double (van Oosterom and Strackee 1983).
inline double bruteWinding(const Mesh& mesh, const glm::dvec3& point) {
  double sum = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x] - point, b = mesh.positions[t.y] - point, c = mesh.positions[t.z] - point;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    sum += std::atan2(glm::dot(a, glm::cross(b, c)), la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (2.0 * std::numbers::pi);
}

}  // namespace overcast::test
