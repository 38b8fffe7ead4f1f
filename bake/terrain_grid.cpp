#include "bake/terrain_grid.h"

#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace overcast {
namespace {

std::int64_t cross(const glm::ivec2& a, const glm::ivec2& b) {
  return std::int64_t{a.x} * b.y - std::int64_t{a.y} * b.x;
}

std::int64_t doubleArea(const GridTriangle& t) {
  return cross(t.corner[1] - t.corner[0], t.corner[2] - t.corner[0]);
}

/// A weighted height; corners that do not count may lack one.
double share(double weight, double height) {
  return weight > 1e-9 ? weight * height : 0.0;
}

/// Height of the finest surface at a point of the grid; NaN where it has none. Diagonals run through the places with two odd numbers.
double finestHeight(const TerrainGrid& grid, const glm::dvec2& at) {
  const glm::ivec2 cell = glm::min(glm::ivec2(glm::floor(at)), grid.last() - 1);
  const double x = at.x - cell.x, y = at.y - cell.y;
  const auto h = [&](int i, int j) { return grid.height(cell + glm::ivec2(i, j)); };
  if ((cell.x + cell.y) % 2 == 0)  // cut from (0, 0) to (1, 1)
    return share(1.0 - std::max(x, y), h(0, 0)) + share(std::min(x, y), h(1, 1)) + share(x - y, h(1, 0)) + share(y - x, h(0, 1));
  if (x + y <= 1.0) return share(1.0 - x - y, h(0, 0)) + share(x, h(1, 0)) + share(y, h(0, 1));
  return share(x + y - 1.0, h(1, 1)) + share(1.0 - y, h(1, 0)) + share(1.0 - x, h(0, 1));
}

/// The plane over three corners.
struct Plane {
  double constant = 0.0;
  glm::dvec2 slope{0.0};
  double at(const glm::dvec2& p) const { return constant + glm::dot(slope, p); }
};

Plane planeOver(const TerrainGrid& grid, const GridTriangle& t) {
  const glm::dvec2 a = glm::dvec2(t.corner[1] - t.corner[0]), b = glm::dvec2(t.corner[2] - t.corner[0]);
  const double area = a.x * b.y - a.y * b.x;
  const double base = grid.height(t.corner[0]), da = grid.height(t.corner[1]) - base, db = grid.height(t.corner[2]) - base;
  Plane plane;
  plane.slope = {(da * b.y - db * a.y) / area, (db * a.x - da * b.x) / area};
  plane.constant = base - glm::dot(plane.slope, glm::dvec2(t.corner[0]));
  return plane;
}

/// Calls visit for every place of the grid in or on the triangle.
template <class Visit>
void forPlaces(const GridTriangle& t, const Visit& visit) {
  const std::int64_t sign = doubleArea(t) > 0 ? 1 : -1;
  const glm::ivec2 low = glm::min(t.corner[0], glm::min(t.corner[1], t.corner[2]));
  const glm::ivec2 high = glm::max(t.corner[0], glm::max(t.corner[1], t.corner[2]));
  for (int y = low.y; y <= high.y; ++y)
    for (int x = low.x; x <= high.x; ++x) {
      const glm::ivec2 p(x, y);
      bool inside = true;
      for (std::size_t c = 0; c < 3; ++c) inside = inside && sign * cross(t.corner[(c + 1) % 3] - t.corner[c], p - t.corner[c]) >= 0;
      if (inside) visit(p);
    }
}

/// Largest difference where the triangle's edges cross those of the finest ones: needed where these are no parts of it.
double deviationOnEdges(const TerrainGrid& grid, const GridTriangle& t, const Plane& plane) {
  double largest = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const glm::ivec2 a = t.corner[c], way = t.corner[(c + 1) % 3] - a;
    // Edges of cells lie at whole x, y, x + y and x - y.
    for (const int steps : {way.x, way.y, way.x + way.y, way.x - way.y})
      for (int i = 1; i < std::abs(steps); ++i) {
        const glm::dvec2 p = glm::dvec2(a) + glm::dvec2(way) * (static_cast<double>(i) / std::abs(steps));
        const double difference = std::abs(plane.at(p) - finestHeight(grid, p));
        if (difference > largest) largest = difference;
      }
  }
  return largest;
}

}  // namespace

std::vector<GridTriangle> rootTriangles(const TerrainGrid& grid, int power) {
  std::vector<GridTriangle> roots;
  const int side = 1 << power;
  for (int y = 0; y < grid.last().y; y += side)
    for (int x = 0; x < grid.last().x; x += side) {
      const glm::ivec2 a(x, y), b(x + side, y + side);
      roots.push_back({{a, b, {x + side, y}}});
      roots.push_back({{b, a, {x, y + side}}});
    }
  return roots;
}

bool withinGrid(const TerrainGrid& grid, const GridTriangle& t, GridTriangle& within) {
  for (std::size_t c = 0; c < 3; ++c) within.corner[c] = grid.clamped(t.corner[c]);
  return doubleArea(within) != 0;
}

double deviation(const TerrainGrid& grid, const GridTriangle& t, bool nested) {
  std::size_t known = 0, missing = 0;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  forPlaces(t, [&](const glm::ivec2& p) {
    const bool has = grid.has(p);
    ++(has ? known : missing);
    if (!has) return;
    low = std::min(low, grid.height(p));
    high = std::max(high, grid.height(p));
  });
  if (known == 0) return 0.0;
  if (missing > 0) {
    double size = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      size = std::max(size, glm::length(glm::dvec2(t.corner[(c + 1) % 3] - t.corner[c]) * grid.terrain.spacing));
    return std::hypot(size, high - low);
  }
  const Plane plane = planeOver(grid, t);
  double largest = nested ? 0.0 : deviationOnEdges(grid, t, plane);
  forPlaces(t, [&](const glm::ivec2& p) { largest = std::max(largest, std::abs(plane.at(glm::dvec2(p)) - grid.height(p))); });
  return largest;
}

}  // namespace overcast
