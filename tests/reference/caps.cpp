#include "tests/reference/caps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <glm/geometric.hpp>

namespace overcast::reference {
namespace {

constexpr long double kPi = std::numbers::pi_v<long double>;

/// One abscissa of the tanh-sinh rule over [0, 1]: its distance from the nearer end, so that it is exact there too.
struct Node {
  long double fromEnd = 0.0L;
  long double weight = 0.0L;
};

std::vector<Node> makeNodes() {
  constexpr long double kStep = 1.0L / 16.0L;
  std::vector<Node> nodes;
  for (int i = 0; i * kStep < 4.2L; ++i) {
    const long double t = i * kStep, u = 0.5L * kPi * std::sinh(t);
    const long double end = std::exp(-u) / (2.0L * std::cosh(u));
    nodes.push_back({end, kStep * 0.5L * kPi * std::cosh(t) / (2.0L * std::cosh(u) * std::cosh(u))});
  }
  return nodes;
}

/// Half the part of the circle of radius `theta` about the smaller cap's axis that lies in the wide cap.
/// `inner` = theta + wide - d and `outer` = theta + d - wide, the smaller of which is small and exact.
long double halfArc(long double wide, long double d, long double theta, long double inner, long double outer) {
  const long double within = std::sin(inner / 2) * std::sin((wide - theta + d) / 2);
  const long double beyond = std::sin(outer / 2) * std::sin((wide + theta + d) / 2);
  return 2 * std::atan2(std::sqrt(std::max(within, 0.0L)), std::sqrt(std::max(beyond, 0.0L)));
}

}  // namespace

long double capArea(long double radius) {
  const long double s = std::sin(radius / 2);
  return 4 * kPi * s * s;
}

long double capIntersection(long double r0, long double r1, long double d) {
  static const std::vector<Node> nodes = makeNodes();
  const long double wide = std::max(r0, r1), small = std::min(r0, r1), start = std::abs(wide - d);
  const bool holdsAxis = d < wide;
  if (start >= small) return holdsAxis ? capArea(small) : 0.0L;
  const long double span = small - start;
  long double sum = 0.0L;
  const auto add = [&](long double share, long double weight) {
    const long double offset = span * share, theta = start + offset;
    const long double other = 2 * start + offset;
    sum += weight * std::sin(theta) * halfArc(wide, d, theta, holdsAxis ? other : offset, holdsAxis ? offset : other);
  };
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    add(nodes[i].fromEnd, nodes[i].weight);
    if (i > 0) add(1.0L - nodes[i].fromEnd, nodes[i].weight);
  }
  return (holdsAxis ? capArea(start) : 0.0L) + 2 * span * sum;
}

CapMoments capMoments(const glm::dvec3& normal, const glm::dvec3& axis0, double r0, const glm::dvec3& axis1, double r1, int steps) {
  const bool first = r0 < r1;
  const glm::dvec3 axis = first ? axis0 : axis1, other = first ? axis1 : axis0;
  const double height = 2.0 * std::pow(std::sin(0.5 * std::min(r0, r1)), 2.0), least = std::cos(std::max(r0, r1));
  const glm::dvec3 side = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
  const glm::dvec3 front = glm::cross(axis, side);
  const double cell = 2.0 * std::numbers::pi * height / (static_cast<double>(steps) * steps);
  CapMoments moments;
  for (int i = 0; i < steps; ++i) {
    const double h = height * (i + 0.5) / steps, sine = std::sqrt(h * (2.0 - h));
    for (int j = 0; j < steps; ++j) {
      const double angle = 2.0 * std::numbers::pi * (j + 0.5) / steps;
      const glm::dvec3 direction = (1.0 - h) * axis + sine * (std::cos(angle) * side + std::sin(angle) * front);
      if (glm::dot(direction, other) < least) continue;
      moments.area += cell;
      moments.moment += cell * direction;
      moments.cosine += cell * std::max(glm::dot(direction, normal), 0.0);
    }
  }
  return moments;
}

}  // namespace overcast::reference
