#include "formats/mesh_triangulate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace overcast {
namespace {

/// A corner of the projected polygon.
struct Corner {
  glm::dvec2 point;
  std::uint32_t index;
};

double cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The polygon projected along the dominant axis of its Newell normal, counter-clockwise, scaled into [-1, 1] about its first corner
/// so that products neither overflow nor vanish.
std::vector<Corner> projected(std::span<const glm::dvec3> positions, std::span<const std::uint32_t> polygon) {
  const glm::dvec3 origin = positions[polygon[0]];
  double size = 0.0;
  for (const std::uint32_t index : polygon) {
    const glm::dvec3 offset = glm::abs(positions[index] * 0.5 - origin * 0.5);  // halved: the difference of huge values stays finite
    size = std::max({size, offset.x, offset.y, offset.z});
  }
  if (size == 0.0) size = 1.0;
  std::vector<glm::dvec3> local;
  local.reserve(polygon.size());
  for (const std::uint32_t index : polygon) local.push_back((positions[index] * 0.5 - origin * 0.5) / size);

  glm::dvec3 normal(0.0);
  for (std::size_t i = 0; i < local.size(); ++i) normal += glm::cross(local[i], local[(i + 1) % local.size()]);
  const glm::dvec3 weight = glm::abs(normal);
  const int axis = weight.x >= weight.y && weight.x >= weight.z ? 0 : weight.y >= weight.z ? 1 : 2;
  const double flip = normal[axis] < 0.0 ? -1.0 : 1.0;
  std::vector<Corner> corners;
  corners.reserve(polygon.size());
  for (std::size_t i = 0; i < local.size(); ++i) {
    corners.push_back({{local[i][(axis + 1) % 3] * flip, local[i][(axis + 2) % 3]}, polygon[i]});
  }
  return corners;
}

/// All turns to the left (or straight on) and once around: a fan from the first corner covers it.
bool isConvex(const std::vector<Corner>& corners) {
  const std::size_t n = corners.size();
  int signChanges = 0;
  double lastStep = 0.0;
  for (std::size_t i = 0; i < 2 * n; ++i) {
    const glm::dvec2& a = corners[i % n].point;
    const glm::dvec2& b = corners[(i + 1) % n].point;
    if (i < n && cross(a, b, corners[(i + 2) % n].point) < 0.0) return false;
    const double step = b.x - a.x;
    if (step == 0.0) continue;
    if (i >= n && (step > 0.0) != (lastStep > 0.0)) ++signChanges;
    lastStep = step;
  }
  return signChanges <= 2;  // a star that winds twice turns left everywhere too
}

/// Whether another corner of the remaining polygon lies in the triangle of corner `i` and its neighbours.
bool holdsAnother(const std::vector<Corner>& corners, std::span<const std::size_t> next, std::size_t before, std::size_t i,
                  std::size_t after) {
  const glm::dvec2 &a = corners[before].point, &b = corners[i].point, &c = corners[after].point;
  for (std::size_t k = next[after]; k != before; k = next[k]) {
    const glm::dvec2& p = corners[k].point;
    if (p == a || p == b || p == c) continue;  // a bridge to a hole passes the same point twice
    if (cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0) return true;
  }
  return false;
}

void clipEars(const std::vector<Corner>& corners, std::vector<glm::uvec3>& triangles) {
  const std::size_t n = corners.size();
  std::vector<std::size_t> next(n), previous(n);
  for (std::size_t i = 0; i < n; ++i) {
    next[i] = (i + 1) % n;
    previous[i] = (i + n - 1) % n;
  }
  // Every failed test of a corner is paid for once: a budget of n tests for each of the n ears bounds the whole at n^2 corner tests.
  std::size_t i = 0;
  for (std::size_t left = n; left >= 3; --left) {
    std::size_t best = i;
    double bestTurn = -std::numeric_limits<double>::infinity();
    for (std::size_t tried = 0; tried < left; ++tried, i = next[i]) {
      const double turn = cross(corners[previous[i]].point, corners[i].point, corners[next[i]].point);
      if (turn > 0.0 && !holdsAnother(corners, next, previous[i], i, next[i])) {
        best = i;
        break;
      }
      if (turn > bestTurn) {
        bestTurn = turn;
        best = i;
      }
    }
    triangles.emplace_back(corners[previous[best]].index, corners[best].index, corners[next[best]].index);
    next[previous[best]] = next[best];
    previous[next[best]] = previous[best];
    i = next[best];
  }
}

}  // namespace

void triangulate(std::span<const glm::dvec3> positions, std::span<const std::uint32_t> polygon, std::vector<glm::uvec3>& triangles) {
  const auto fan = [&] {
    for (std::size_t i = 2; i < polygon.size(); ++i) triangles.emplace_back(polygon[0], polygon[i - 1], polygon[i]);
  };
  if (polygon.size() == 3 || polygon.size() > kMaxEarClippingCorners) return fan();
  const std::vector<Corner> corners = projected(positions, polygon);
  if (isConvex(corners)) return fan();
  clipEars(corners, triangles);
}

}  // namespace overcast
