#include "tests/reference/sky.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <glm/geometric.hpp>

namespace overcast::reference {

double continuedField(const std::vector<Field>& levels, int level, const glm::dvec3& point) {
  const double texel = std::pow(2.0, level);
  glm::dvec3 inside = point;
  for (int axis = 0; axis < 3; ++axis) {
    const double side = levels[0].size[axis];
    const double inset = std::min(0.5 * texel, 0.5 * side);
    inside[axis] = std::min(std::max(point[axis], inset), side - inset);
  }
  return interpolate(levels[static_cast<std::size_t>(level)], inside / texel) + glm::length(point - inside);
}

double publishedSky(const std::vector<Field>& levels, const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& up, double k,
                    double alpha) {
  double missing = 0.0, open = 0.0, reach = 0.0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double d = std::pow(2.0, static_cast<double>(i));
    const double skewedLength = 1.0 + alpha;
    missing += d - continuedField(levels, static_cast<int>(i), point + d * (normal + alpha * up));
    open += d - d * skewedLength;
    reach += d;
  }
  const double visibility = std::exp(-k / reach * missing) / std::exp(-k / reach * open);
  if (visibility >= 1.0) return 1.0;
  const double darkening = -std::log(visibility);
  return std::pow(visibility, darkening / (darkening + 1.0 / 16.0));
}

double calibratedSky(const Field& field, const glm::dvec3& point, const glm::dvec3& normal, double first, const std::vector<Step>& steps,
                     int stride) {
  const glm::dvec3 axis(normal.z, 0.0, -normal.x);  // of the shortest turn from +y to the normal
  const auto turn = [&](const glm::dvec3& v) {
    const glm::dvec3 once = glm::cross(axis, v);
    return v + once + glm::cross(axis, once) / (1.0 + normal.y);
  };
  const std::vector<Field> levels{field};
  const std::size_t taps = steps.front().weights.size();
  double sum = 0.0;
  for (int n = stride / 2; n < 256; n += stride) {
    const double squared = (91 * n % 256 + 0.5) / 256.0, angle = 2.0 * std::numbers::pi * n / 256.0, u = std::sqrt(1.0 - squared);
    const glm::dvec3 direction = turn({std::sqrt(squared) * std::cos(angle), u, std::sqrt(squared) * std::sin(angle)});
    double border = 1e9;
    for (int side = 0; side < 3; ++side)
      if (std::abs(direction[side]) > 1e-9)
        border = std::min(border, ((direction[side] > 0.0 ? field.size[side] : 0.0) - point[side]) / direction[side]);
    const double start = first * std::pow(2.0, 2.5 * ((165 * n % 256 + 0.5) / 256.0 - 0.5)), last = std::max(border, 8.0 * first);
    std::vector<double> d, phi, e;
    for (std::size_t i = 0; i < taps; ++i) {
      d.push_back(std::min(start * std::pow(last / start, static_cast<double>(i) / static_cast<double>(taps - 1)), std::max(border, 1.0)));
      phi.push_back(continuedField(levels, 0, point + d.back() * direction));
    }
    double exponent = 0.0;
    for (const Step& step : steps) {
      const double open = step.start + step.slant * (1.0 - u);
      double z = open;
      for (std::size_t i = 0; i < taps; ++i) z += step.weights[i] * std::max((u - phi[i] / d[i]) / (u + 0.05), -0.3);
      for (std::size_t i = 0; i + 1 < taps; ++i) {
        const double way = std::max(d[i + 1] - d[i], 0.1);
        const double gap = 1.0 - (phi[i] + phi[i + 1]) / way, openGap = 1.0 - u * (d[i] + d[i + 1]) / way;
        z += step.gaps[i] * (std::max(gap, -1.0) - std::max(openGap, -1.0));
      }
      exponent += step.height * (std::tanh(z) - std::tanh(open));
    }
    sum += std::exp(-std::max(exponent, 0.0));
  }
  return sum * stride / 256.0;
}

double conesSky(const std::vector<Field>& levels, const glm::dvec3& point, const std::vector<glm::dvec3>& axes,
                const std::vector<Tap>& taps, const glm::dvec3& cone) {
  double sum = 0.0;
  for (const glm::dvec3& axis : axes) {
    double open = 1.0;
    for (const Tap& tap : taps) {
      const double share = continuedField(levels, tap.level, point + tap.distance * axis) / (tap.distance * cone.x) + cone.y;
      open = std::min(open, std::min(std::max(share, 0.0), 1.0));
    }
    sum += open;
  }
  return std::pow(sum / static_cast<double>(axes.size()), cone.z);
}

}  // namespace overcast::reference
