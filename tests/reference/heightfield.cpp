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

/// The layer's values on one more texel at each side.
double extended(const HeightField& field, const HeightLevels& layer, int i, int j, bool mean) {
  const int w = field.size.x, h = field.size.y;
  const auto value = [&](int x, int y) {
    const HeightTexel& texel = layer[0][static_cast<std::size_t>(y * w + x)];
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

/// The distance at a point of the box, field space.
double boxed(const HeightField& field, const glm::dvec3& q) {
  const glm::dvec3 e = field.halfExtent;
  const double cx = 2.0 * e.x / field.size.x, cy = 2.0 * e.y / field.size.y;
  const auto layerDistance = [&](const HeightLevels& layer, double side) {
    const glm::dvec4 s = surface(field, layer, {(q.x + e.x) / cx, (q.y + e.y) / cy}) * e.z;
    const double slope2 = s.y * s.y / (cx * cx) + s.z * s.z / (cy * cy);
    const double rough = (12.0 * s.w * e.z - s.y * s.y - s.z * s.z) / (cx * cy);
    return side * (q.z - s.x) / std::sqrt(1.0 + slope2 + (rough > 0.0 ? rough : 0.0));
  };
  double phi = layerDistance(field.front, 1.0);
  if (!field.back.empty()) phi = std::max(phi, layerDistance(field.back, -1.0));
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

glm::dvec4 surface(const HeightField& field, const HeightLevels& layer, const glm::dvec2& at) {
  glm::dvec4 sum(0.0);
  for (int j = -1; j <= field.size.y; ++j)
    for (int i = -1; i <= field.size.x; ++i) {
      const double x = at.x - i - 0.5, y = at.y - j - 0.5, h = extended(field, layer, i, j, true);
      sum += glm::dvec4(h * spline(x) * spline(y), h * splineSlope(x) * spline(y), h * spline(x) * splineSlope(y),
                        extended(field, layer, i, j, false) * spline(x) * spline(y));
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
  const double phi = boxed(field, q), gap = glm::length(p - q);
  if (gap == 0.0) return phi;
  const glm::dvec3 d = p - q;
  const double longest = std::max(std::abs(d.x), std::max(std::abs(d.y), std::abs(d.z)));
  const double unit = 2.0 * std::max(e.x / field.size.x, e.y / field.size.y);
  const double cosine = (phi - boxed(field, q - d / longest * unit)) / (gap / longest * unit);
  return std::sqrt(gap * gap + phi * phi + 2.0 * gap * phi * std::min(std::max(cosine, 0.0), 1.0));
}

}  // namespace overcast::reference
