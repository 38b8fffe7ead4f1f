#include "bake/height_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace overcast {
namespace {

/// Lines this close to an edge, in barycentric coordinates, meet both triangles that share it.
constexpr double kEdgeTolerance = 1e-12;

/// Crossings of steeper surfaces than this cosine weigh no more: one line would outvote the rest.
constexpr double kLeastCosine = 1e-3;

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// Range of line indices whose coordinate lies within [low, high].
std::array<int, 2> lineRange(double low, double high, double origin, double step, int count) {
  const double first = std::ceil((low - origin) / step - 0.5 - 1e-9), last = std::floor((high - origin) / step - 0.5 + 1e-9);
  return {static_cast<int>(std::clamp(first, 0.0, static_cast<double>(count))),
          static_cast<int>(std::clamp(last, -1.0, static_cast<double>(count - 1)))};
}

/// Calls visit(line, z) for every line that meets the triangle.
template <class Visit>
void forLines(const std::array<glm::dvec3, 3>& corner, const LineGrid& grid, Visit visit) {
  const glm::dvec2 a(corner[0]), b(corner[1]), c(corner[2]);
  const double area = cross(b - a, c - a);
  if (area == 0.0) return;
  const glm::dvec2 low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
  const auto [firstX, lastX] = lineRange(low.x, high.x, grid.origin.x, grid.step.x, grid.size.x);
  const auto [firstY, lastY] = lineRange(low.y, high.y, grid.origin.y, grid.step.y, grid.size.y);
  for (int j = firstY; j <= lastY; ++j)
    for (int i = firstX; i <= lastX; ++i) {
      const glm::dvec2 p = grid.origin + grid.step * (glm::dvec2(i, j) + 0.5);
      const double u = cross(b - p, c - p) / area, v = cross(c - p, a - p) / area, w = 1.0 - u - v;
      if (std::min({u, v, w}) < -kEdgeTolerance) continue;
      const std::size_t line = static_cast<std::size_t>(i) + static_cast<std::size_t>(grid.size.x) * static_cast<std::size_t>(j);
      visit(line, u * corner[0].z + v * corner[1].z + w * corner[2].z);
    }
}

std::array<glm::dvec3, 3> cornersOf(std::span<const glm::dvec3> points, const glm::uvec3& triangle) {
  return {points[triangle.x], points[triangle.y], points[triangle.z]};
}

}  // namespace

HeightRaster rasterHeights(std::span<const glm::dvec3> points, const std::vector<glm::uvec3>& triangles, const LineGrid& grid) {
  const std::size_t lines = static_cast<std::size_t>(grid.size.x) * static_cast<std::size_t>(grid.size.y);
  HeightRaster raster{std::vector<double>(lines, -std::numeric_limits<double>::infinity()),
                      std::vector<double>(lines, std::numeric_limits<double>::infinity())};
  for (const glm::uvec3& triangle : triangles)
    forLines(cornersOf(points, triangle), grid, [&](std::size_t line, double z) {
      raster.top[line] = std::max(raster.top[line], z);
      raster.bottom[line] = std::min(raster.bottom[line], z);
    });
  return raster;
}

HeightShares measureShares(std::span<const glm::dvec3> points, const std::vector<glm::uvec3>& triangles, const LineGrid& grid,
                           double tolerance) {
  const HeightRaster raster = rasterHeights(points, triangles, grid);
  double all = 0.0, top = 0.0, either = 0.0, facing = 0.0;
  for (const glm::uvec3& triangle : triangles) {
    const std::array<glm::dvec3, 3> corner = cornersOf(points, triangle);
    const glm::dvec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    const double weight = glm::length(normal) / std::max(std::abs(normal.z), kLeastCosine * glm::length(normal));
    forLines(corner, grid, [&](std::size_t line, double z) {
      const bool seen = z >= raster.top[line] - tolerance;
      all += weight;
      if (seen) top += weight;
      if (seen && normal.z > 0.0) facing += weight;
      if (seen || z <= raster.bottom[line] + tolerance) either += weight;
    });
  }
  if (all == 0.0) return {};
  const auto met = std::count_if(raster.top.begin(), raster.top.end(), [](double z) { return std::isfinite(z); });
  return {top / all, either / all, top > 0.0 ? facing / top : 0.0, std::min(1.0, static_cast<double>(met) / top)};
}

}  // namespace overcast
