#include "bake/oriented_box.h"

#include <array>
#include <exception>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/optimal_bounding_box.h>
#include <glm/geometric.hpp>

namespace overcast {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// Below this share of the largest edge an edge of the box has no direction of its own.
constexpr double kFlat = 1e-7;

}  // namespace

std::optional<glm::dmat3> orientedBoxAxes(std::span<const glm::dvec3> points) {
  if (points.size() < 4) return std::nullopt;
  std::vector<Kernel::Point_3> input;
  input.reserve(points.size());
  for (const glm::dvec3& p : points) input.emplace_back(p.x, p.y, p.z);
  std::array<Kernel::Point_3, 8> box;
  try {
    CGAL::oriented_bounding_box(input, box, CGAL::parameters::use_convex_hull(true).random_seed(1));
  } catch (const std::exception&) {
    return std::nullopt;  // degenerate input that the hull cannot take
  }
  // Corners are in the order of CGAL::make_hexahedron: 1, 3 and 5 are the neighbours of 0.
  const auto edge = [&](std::size_t to) {
    const Kernel::Vector_3 v = box[to] - box[0];
    return glm::dvec3(v.x(), v.y(), v.z());
  };
  const glm::dvec3 x = edge(1), y = edge(3), z = edge(5);
  const double largest = std::max({glm::length(x), glm::length(y), glm::length(z)});
  if (!(std::min({glm::length(x), glm::length(y), glm::length(z)}) > kFlat * largest)) return std::nullopt;
  const glm::dvec3 first = glm::normalize(x);
  const glm::dvec3 second = glm::normalize(y - glm::dot(y, first) * first);
  return glm::dmat3(first, second, glm::cross(first, second));
}

}  // namespace overcast
