#include "tests/reference/radius.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

namespace overcast::reference {

RadiusFunction sphereRadius(const glm::dvec3& centre, double radius) {
  return [=](const glm::dvec3& d) {
    const double along = glm::dot(d, centre);
    return along + std::sqrt(along * along - glm::dot(centre, centre) + radius * radius);
  };
}

RadiusFunction ellipsoidRadius(const glm::dvec3& halfExtents) {
  return [=](const glm::dvec3& d) { return 1.0 / glm::length(d / halfExtents); };
}

RadiusFunction cuboidRadius(const glm::dvec3& halfExtents) {
  return [=](const glm::dvec3& d) {
    const glm::dvec3 share = glm::abs(d) / halfExtents;
    return 1.0 / std::max({share.x, share.y, share.z});
  };
}

RadiusFunction bumpyRadius() {
  return [](const glm::dvec3& d) {
    return 1.0 + 0.15 * std::sin(3.0 * d.x + 1.0) + 0.15 * std::cos(4.0 * d.y - 2.0 * d.z) + 0.1 * std::sin(5.0 * d.z + 2.0 * d.x);
  };
}

double outermostCrossing(const Mesh& mesh, const glm::dvec3& origin, const glm::dvec3& direction) {
  double farthest = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x] - origin, ab = mesh.positions[t.y] - origin - a, ac = mesh.positions[t.z] - origin - a;
    const glm::dvec3 across = glm::cross(direction, ac);
    const double determinant = glm::dot(ab, across);
    if (determinant == 0.0) continue;
    const double u = -glm::dot(a, across) / determinant;
    const glm::dvec3 q = glm::cross(-a, ab);
    const double v = glm::dot(direction, q) / determinant, distance = glm::dot(ac, q) / determinant;
    constexpr double kEdge = 1e-12;  // a ray along an edge must not slip between its triangles
    if (u >= -kEdge && v >= -kEdge && u + v <= 1.0 + kEdge) farthest = std::max(farthest, distance);
  }
  return farthest;
}

double firstOrderDistance(const RadiusFunction& radius, const glm::dvec3& point) {
  constexpr double kStep = 1e-5;
  const double rho = glm::length(point);
  const glm::dvec3 d = point / rho;
  const glm::dvec3 u = glm::normalize(glm::cross(d, std::abs(d.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
  const glm::dvec3 v = glm::cross(d, u);
  const double alongU = (radius(glm::normalize(d + kStep * u)) - radius(glm::normalize(d - kStep * u))) / (2.0 * kStep);
  const double alongV = (radius(glm::normalize(d + kStep * v)) - radius(glm::normalize(d - kStep * v))) / (2.0 * kStep);
  const double r = radius(d);
  return (rho - r) / std::sqrt(1.0 + (alongU * alongU + alongV * alongV) / (r * r));
}

double largestMargin(const Mesh& mesh) {
  std::vector<glm::dvec4> rows;  // normal, 1
  std::vector<double> offsets;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x];
    const glm::dvec3 n = glm::normalize(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a));
    rows.emplace_back(n, 1.0);
    offsets.push_back(glm::dot(n, a));
  }
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (std::size_t k = 0; k < j; ++k)
        for (std::size_t l = 0; l < k; ++l) {
          const glm::dmat4 system = glm::transpose(glm::dmat4(rows[i], rows[j], rows[k], rows[l]));
          if (std::abs(glm::determinant(system)) < 1e-12) continue;
          const glm::dvec4 point = glm::inverse(system) * glm::dvec4(offsets[i], offsets[j], offsets[k], offsets[l]);
          double margin = std::numeric_limits<double>::infinity();
          for (std::size_t m = 0; m < rows.size(); ++m)
            margin = std::min(margin, offsets[m] - glm::dot(glm::dvec3(rows[m]), glm::dvec3(point)));
          best = std::max(best, margin);
        }
  return best;
}

Mesh withRadius(Mesh mesh, const RadiusFunction& radius) {
  for (glm::dvec3& p : mesh.positions) {
    const glm::dvec3 d = glm::normalize(p);
    p = radius(d) * d;
  }
  return mesh;
}

}  // namespace overcast::reference
