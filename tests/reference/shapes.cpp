#include "tests/reference/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace overcast::reference {
namespace {

/// Not std::uniform_real_distribution, whose values differ between libraries.
double uniform(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11) * 0x1p-53;
}

Mesh finished(Mesh mesh, const char* name) {
  mesh.name = name;
  mesh.parts = {{0, static_cast<std::uint32_t>(mesh.triangles.size()), -1}};
  return mesh;
}

/// Calls change(triangles, triangle, chosen) for every triangle, a seeded choice of them chosen.
template <class Change>
Mesh spoiled(const Mesh& mesh, double share, std::uint64_t seed, const char* name, const Change& change) {
  std::mt19937_64 engine(seed);
  Mesh result = mesh;
  result.normals.clear();
  result.triangles.clear();
  for (const glm::uvec3& triangle : mesh.triangles) change(result.triangles, triangle, uniform(engine) < share);
  return finished(std::move(result), name);
}

Mesh icosahedron() {
  const double t = std::numbers::phi;
  Mesh mesh;
  mesh.positions = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                    {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  mesh.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2}, {3, 2, 6}, {3, 6, 8},  {3, 8, 9},   {4, 9, 5}, {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  return mesh;
}

Mesh subdivided(const Mesh& mesh) {
  Mesh result;
  result.positions = mesh.positions;
  std::map<std::pair<unsigned, unsigned>, unsigned> middles;
  const auto middle = [&](unsigned i, unsigned j) {
    const auto [at, added] = middles.try_emplace(std::minmax(i, j), static_cast<unsigned>(result.positions.size()));
    if (added) result.positions.push_back((mesh.positions[i] + mesh.positions[j]) * 0.5);
    return at->second;
  };
  for (const glm::uvec3& t : mesh.triangles) {
    const unsigned ab = middle(t.x, t.y);
    const unsigned bc = middle(t.y, t.z);
    const unsigned ca = middle(t.z, t.x);
    result.triangles.insert(result.triangles.end(), {{t.x, ab, ca}, {t.y, bc, ab}, {t.z, ca, bc}, {ab, bc, ca}});
  }
  return result;
}

}  // namespace

double sphereDistance(const glm::dvec3& point, double radius) {
  return glm::length(point) - radius;
}

double boxDistance(const glm::dvec3& point, const glm::dvec3& halfExtent) {
  const glm::dvec3 q = glm::abs(point) - halfExtent;
  return glm::length(glm::max(q, 0.0)) + std::min(std::max({q.x, q.y, q.z}), 0.0);
}

double torusDistance(const glm::dvec3& point, double majorRadius, double minorRadius) {
  return std::hypot(std::hypot(point.x, point.z) - majorRadius, point.y) - minorRadius;
}

Mesh icosphere(double radius, int subdivisions) {
  Mesh mesh = icosahedron();
  for (int i = 0; i < subdivisions; ++i) {
    mesh = subdivided(mesh);
    for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
  }
  for (glm::dvec3& p : mesh.positions) p = glm::normalize(p) * radius;
  return finished(std::move(mesh), "icosphere");
}

double icosphereSag(double radius, int subdivisions) {
  const Mesh mesh = icosphere(radius, subdivisions);
  double nearest = radius;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3& a = mesh.positions[t.x];
    const glm::dvec3 normal = glm::normalize(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a));
    nearest = std::min(nearest, glm::dot(a, normal));
  }
  return radius - nearest;
}

Mesh boxMesh(const glm::dvec3& halfExtent) {
  Mesh mesh;
  for (int c = 0; c < 8; ++c)
    mesh.positions.push_back(halfExtent * glm::dvec3((c & 1) != 0 ? 1 : -1, (c & 2) != 0 ? 1 : -1, (c & 4) != 0 ? 1 : -1));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return finished(std::move(mesh), "box");
}

Mesh torusMesh(double majorRadius, double minorRadius, int majorSteps, int minorSteps) {
  Mesh mesh;
  for (int i = 0; i < majorSteps; ++i)
    for (int j = 0; j < minorSteps; ++j) {
      const double u = 2.0 * std::numbers::pi * i / majorSteps;
      const double v = 2.0 * std::numbers::pi * j / minorSteps;
      const double ring = majorRadius + minorRadius * std::cos(v);
      mesh.positions.emplace_back(ring * std::cos(u), minorRadius * std::sin(v), ring * std::sin(u));
    }
  const auto vertex = [&](int i, int j) { return static_cast<unsigned>((i % majorSteps) * minorSteps + j % minorSteps); };
  for (int i = 0; i < majorSteps; ++i)
    for (int j = 0; j < minorSteps; ++j) {
      mesh.triangles.emplace_back(vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1));
      mesh.triangles.emplace_back(vertex(i, j), vertex(i + 1, j + 1), vertex(i + 1, j));
    }
  return finished(std::move(mesh), "torus");
}

Mesh triangleSoup(std::uint64_t seed, int triangles, double extent) {
  Mesh mesh;
  const auto count = static_cast<unsigned>(triangles);
  mesh.positions = randomPoints({glm::dvec3(-extent), glm::dvec3(extent)}, std::size_t{3} * count, seed);
  for (unsigned t = 0; t < count; ++t) mesh.triangles.emplace_back(3 * t, 3 * t + 1, 3 * t + 2);
  return finished(std::move(mesh), "soup");
}

Mesh withHoles(const Mesh& mesh, double share, std::uint64_t seed) {
  return spoiled(mesh, share, seed, "holes", [](auto& triangles, const glm::uvec3& t, bool chosen) {
    if (!chosen) triangles.push_back(t);
  });
}

Mesh withFlips(const Mesh& mesh, double share, std::uint64_t seed) {
  return spoiled(mesh, share, seed, "flips",
                 [](auto& triangles, const glm::uvec3& t, bool chosen) { triangles.push_back(chosen ? glm::uvec3(t.x, t.z, t.y) : t); });
}

Mesh withDuplicates(const Mesh& mesh, double share, std::uint64_t seed) {
  return spoiled(mesh, share, seed, "duplicates", [](auto& triangles, const glm::uvec3& t, bool chosen) {
    triangles.push_back(t);
    if (chosen) triangles.push_back(t);
  });
}

Mesh insideOut(const Mesh& mesh) {
  return withFlips(mesh, 1.0, 0);
}

Mesh unwelded(const Mesh& mesh) {
  Mesh result;
  for (const glm::uvec3& t : mesh.triangles) {
    const auto first = static_cast<unsigned>(result.positions.size());
    for (const unsigned corner : {t.x, t.y, t.z}) result.positions.push_back(mesh.positions[corner]);
    result.triangles.emplace_back(first, first + 1, first + 2);
  }
  return finished(std::move(result), "unwelded");
}

Mesh shuffled(const Mesh& mesh, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<unsigned> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), engine);
  Mesh result;
  result.positions.resize(mesh.positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) result.positions[order[i]] = mesh.positions[i];
  for (const glm::uvec3& t : mesh.triangles) {
    const std::array<unsigned, 3> corner{order[t.x], order[t.y], order[t.z]};
    const std::uint64_t first = engine() % 3;
    result.triangles.emplace_back(corner[first], corner[(first + 1) % 3], corner[(first + 2) % 3]);
  }
  std::shuffle(result.triangles.begin(), result.triangles.end(), engine);
  return finished(std::move(result), "shuffled");
}

Mesh moved(const Mesh& mesh, const glm::dvec3& offset) {
  Mesh result = mesh;
  for (glm::dvec3& p : result.positions) p += offset;
  return result;
}

Mesh scaled(const Mesh& mesh, double factor) {
  Mesh result = mesh;
  for (glm::dvec3& p : result.positions) p *= factor;
  return result;
}

Mesh joined(const Mesh& first, const Mesh& second) {
  Mesh result = first;
  result.normals.clear();
  const auto offset = static_cast<unsigned>(first.positions.size());
  result.positions.insert(result.positions.end(), second.positions.begin(), second.positions.end());
  for (const glm::uvec3& t : second.triangles) result.triangles.push_back(t + offset);
  return finished(std::move(result), "joined");
}

std::vector<glm::dvec3> randomPoints(const Box& box, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<glm::dvec3> points(count);
  for (glm::dvec3& p : points) {
    const double x = uniform(engine);
    const double y = uniform(engine);
    const double z = uniform(engine);
    p = box.min + (box.max - box.min) * glm::dvec3(x, y, z);
  }
  return points;
}

}  // namespace overcast::reference
