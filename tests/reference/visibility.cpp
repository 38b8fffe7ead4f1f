#include "tests/reference/visibility.h"

#include <cstddef>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

namespace overcast::reference {
namespace {

bool meets(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 ab = b - a, ac = c - a;
  const glm::dvec3 p = glm::cross(direction, ac);
  const double determinant = glm::dot(ab, p);
  if (determinant == 0.0) return false;
  const glm::dvec3 from = origin - a;
  const double u = glm::dot(from, p) / determinant;
  const glm::dvec3 q = glm::cross(from, ab);
  const double v = glm::dot(direction, q) / determinant;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && glm::dot(ac, q) / determinant > 0.0;
}

}  // namespace

std::vector<char> blocked(const Mesh& mesh, const glm::dvec3& origin, std::span<const glm::dvec3> directions) {
  std::vector<char> result(directions.size(), 0);
  tbb::parallel_for(std::size_t{0}, directions.size(), [&](std::size_t i) {
    for (const glm::uvec3& t : mesh.triangles) {
      if (!meets(origin, directions[i], mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z])) continue;
      result[i] = 1;
      return;
    }
  });
  return result;
}

}  // namespace overcast::reference
