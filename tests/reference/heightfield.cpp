#include "tests/reference/heightfield.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace overcast::reference {
namespace {

/// The quadratic B-spline about 0, support 3 (de Boor).
double spline(double x) {
  x = std::abs(x);
  if (x <= 0.5) return 0.75 - x * x;
  return x < 1.5 ? 0.5 * (1.5 - x) * (1.5 - x) : 0.0;
}

double splineSlope(double x) {
  if (std::abs(x) <= 0.5) return -2.0 * x;
  if (std::abs(x) >= 1.5) return 0.0;
  return x > 0.0 ? x - 1.5 : x + 1.5;
}

glm::ivec2 sizeAt(const HeightField& field, int level) {
  return {std::max(1, field.size.x >> level), std::max(1, field.size.y >> level)};
}

/// The layer's values on one more texel at each side.
double extended(const HeightField& field, const HeightLevels& layer, int level, int i, int j, bool mean) {
  const int w = sizeAt(field, level).x, h = sizeAt(field, level).y;
  const auto value = [&](int x, int y) {
    const HeightTexel& texel = layer[static_cast<std::size_t>(level)][static_cast<std::size_t>(y * w + x)];
    return static_cast<double>(mean ? texel.mean : texel.variance);
  };
  const int x = i < 0 ? 0 : (i >= w ? w - 1 : i), y = j < 0 ? 0 : (j >= h ? h - 1 : j);
  double sum = value(x, y);
  if (!mean) return sum;
  if (i < 0) sum -= value(1, y) - value(0, y);
  if (i >= w) sum += value(w - 1, y) - value(w - 2, y);
  if (j < 0) sum -= value(x, 1) - value(x, 0);
  if (j >= h) sum += value(x, h - 1) - value(x, h - 2);
  return sum;
}

/// Height, its two derivatives and squared slope with roughness over a place of field space, local units.
glm::dvec4 ground(const HeightField& field, int level, double x, double y) {
  const glm::dvec3 e = field.halfExtent;
  const double cx = 2.0 * e.x / sizeAt(field, level).x, cy = 2.0 * e.y / sizeAt(field, level).y;
  const glm::dvec4 s = surface(field, field.front, {(x + e.x) / cx, (y + e.y) / cy}, level) * e.z;
  const double rough = (12.0 * s.w * e.z - s.y * s.y - s.z * s.z) / (cx * cy);
  const double dx = s.y / cx, dy = s.z / cy;
  return {s.x, dx, dy, dx * dx + dy * dy + (rough > 0.0 ? rough : 0.0)};
}

/// The same at a level that need not be whole.
glm::dvec4 ground(const HeightField& field, double level, double x, double y) {
  double last = 0.0;
  while (std::min(field.size.x, field.size.y) / std::exp2(last + 1.0) >= 2.0) last += 1.0;
  level = std::min(std::max(level, 0.0), last);
  const double whole = std::floor(level), rest = level - whole;
  const glm::dvec4 fine = ground(field, static_cast<int>(whole), x, y);
  return rest == 0.0 ? fine : (1.0 - rest) * fine + rest * ground(field, static_cast<int>(whole) + 1, x, y);
}

/// The sheet's distance at a point of field space: the first-order one, or that of the point a step away from the one below.
double sheet(const HeightField& field, const glm::dvec3& p) {
  const glm::dvec3 e = field.halfExtent;
  const double cell = 2.0 * std::max(e.x / field.size.x, e.y / field.size.y);
  const auto within = [](double v, double half) { return std::min(std::max(v, -half), half); };
  const auto reach = [&](double x, double y) { return glm::length(p - glm::dvec3(x, y, ground(field, 0, x, y).x)); };
  // Where the perpendicular from p to the plane through (x, y, h) with these slopes meets it, moved onto the rectangle.
  const auto foot = [&](double x, double y, double h, const glm::dvec4& g) {
    const glm::dvec3 normal = glm::normalize(glm::dvec3(-g.y, -g.z, 1.0));
    const glm::dvec3 f = p - normal * glm::dot(normal, p - glm::dvec3(x, y, h));
    return glm::dvec2(within(f.x, e.x), within(f.y, e.y));
  };
  const double x0 = within(p.x, e.x), y0 = within(p.y, e.y), h0 = ground(field, 0, x0, y0).x;
  const glm::dvec4 first = ground(field, std::log2(0.35 * reach(x0, y0) / cell), x0, y0);
  const glm::dvec2 one = foot(x0, y0, h0, first);
  const double slope2 = first.y * first.y + first.z * first.z;
  const double up = p.z - h0 - first.y * (one.x - x0) - first.z * (one.y - y0);
  const glm::dvec3 apart(p.x - one.x, p.y - one.y, up * std::sqrt((1.0 + slope2) / (1.0 + first.w)));
  return std::min({glm::length(apart), reach(x0, y0), reach(one.x, one.y)});
}

/// A pair's distance at a point of the box, field space.
double boxed(const HeightField& field, const glm::dvec3& q) {
  const glm::dvec3 e = field.halfExtent;
  const double cx = 2.0 * e.x / field.size.x, cy = 2.0 * e.y / field.size.y;
  const auto layerDistance = [&](const HeightLevels& layer, double side) {
    const glm::dvec4 s = surface(field, layer, {(q.x + e.x) / cx, (q.y + e.y) / cy}) * e.z;
    const double slope2 = s.y * s.y / (cx * cx) + s.z * s.z / (cy * cy);
    const double rough = (12.0 * s.w * e.z - s.y * s.y - s.z * s.z) / (cx * cy);
    return side * (q.z - s.x) / std::sqrt(1.0 + slope2 + (rough > 0.0 ? rough : 0.0));
  };
  double phi = std::max(layerDistance(field.front, 1.0), layerDistance(field.back, -1.0));
  for (int a = 0; a < 3; ++a) phi = std::max(phi, std::abs(q[a]) - e[a]);
  return phi;
}

}  // namespace

glm::dvec2 momentsBelow(const HeightField& field, const HeightLevels& layer, int level, int i, int j) {
  const int stepX = field.size.x / std::max(1, field.size.x >> level), stepY = field.size.y / std::max(1, field.size.y >> level);
  double mean = 0.0, square = 0.0;
  for (int y = j * stepY; y < (j + 1) * stepY; ++y)
    for (int x = i * stepX; x < (i + 1) * stepX; ++x) {
      const HeightTexel& texel = layer[0][static_cast<std::size_t>(y * field.size.x + x)];
      mean += texel.mean;
      square += double{texel.variance} + double{texel.mean} * double{texel.mean};
    }
  const double count = static_cast<double>(stepX) * stepY;
  return {mean / count, square / count - mean / count * (mean / count)};
}

glm::dvec4 surface(const HeightField& field, const HeightLevels& layer, const glm::dvec2& at, int level) {
  glm::dvec4 sum(0.0);
  for (int j = -1; j <= sizeAt(field, level).y; ++j)
    for (int i = -1; i <= sizeAt(field, level).x; ++i) {
      const double x = at.x - i - 0.5, y = at.y - j - 0.5, h = extended(field, layer, level, i, j, true);
      sum += glm::dvec4(h * spline(x) * spline(y), h * splineSlope(x) * spline(y), h * spline(x) * splineSlope(y),
                        extended(field, layer, level, i, j, false) * spline(x) * spline(y));
    }
  return sum;
}

double heightFieldDistance(const HeightField& field, const glm::dvec3& point) {
  const glm::dvec3 e = field.halfExtent;
  glm::dvec3 p, q;
  for (int a = 0; a < 3; ++a) {
    p[a] = glm::dot(field.localFromField[a], point - field.origin);
    q[a] = std::min(std::max(p[a], -e[a]), e[a]);
  }
  const double gap = glm::length(p - q);
  if (field.back.empty()) return std::max(sheet(field, p), gap);
  const double phi = boxed(field, q);
  if (gap == 0.0) return phi;
  const glm::dvec3 d = p - q;
  const double longest = std::max(std::abs(d.x), std::max(std::abs(d.y), std::abs(d.z)));
  const double unit = 2.0 * std::max(e.x / field.size.x, e.y / field.size.y);
  const double cosine = (phi - boxed(field, q - d / longest * unit)) / (gap / longest * unit);
  return std::sqrt(gap * gap + phi * phi + 2.0 * gap * phi * std::min(std::max(cosine, 0.0), 1.0));
}

}  // namespace overcast::reference
