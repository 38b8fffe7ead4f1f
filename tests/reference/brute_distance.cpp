#include "tests/reference/brute_distance.h"

#include <algorithm>
#include <limits>

#include <glm/geometric.hpp>

namespace overcast::reference {
namespace {

double distanceToSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const double along = glm::dot(p - a, b - a);
  if (along <= 0.0) return glm::distance(p, a);
  if (glm::dot(p - b, a - b) <= 0.0) return glm::distance(p, b);
  return glm::distance(p, glm::mix(a, b, along / glm::dot(b - a, b - a)));
}

}  // namespace

double distanceToTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double edges = std::min({distanceToSegment(p, a, b), distanceToSegment(p, b, c), distanceToSegment(p, c, a)});
  const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  if (glm::length(normal) <= 1e-14 * longest * longest) return edges;
  const bool above = glm::dot(glm::cross(b - a, p - a), normal) >= 0.0 && glm::dot(glm::cross(c - b, p - b), normal) >= 0.0 &&
                     glm::dot(glm::cross(a - c, p - c), normal) >= 0.0;
  return above ? std::abs(glm::dot(p - a, normal)) / glm::length(normal) : edges;
}

double distanceToMesh(const glm::dvec3& p, const Mesh& mesh) {
  double nearest = std::numeric_limits<double>::max();
  for (const glm::uvec3& t : mesh.triangles) {
    nearest = std::min(nearest, distanceToTriangle(p, mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]));
  }
  return nearest;
}

}  // namespace overcast::reference
