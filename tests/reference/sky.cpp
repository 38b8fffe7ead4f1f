#include "tests/reference/sky.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

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

double calibratedSky(const std::vector<Field>& levels, const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& up,
                     const std::vector<Tap>& taps, double alpha, const std::vector<Step>& steps) {
  double e = 0.0;
  std::vector<double> z;
  for (const Step& step : steps) z.push_back(step.start + step.facing * alpha * (1.0 - glm::dot(normal, up)));
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const Tap& tap = taps[i];
    const double phi = continuedField(levels, tap.level, point + tap.distance * normal + tap.distance * alpha * up);
    const double missing = ((1.0 + alpha) * tap.distance - phi) / tap.distance;
    e += tap.weight * missing;
    for (std::size_t s = 0; s < steps.size(); ++s) z[s] += steps[s].weights[i] * missing;
  }
  for (std::size_t s = 0; s < steps.size(); ++s)
    e += steps[s].height * (z[s] / (1.0 + std::abs(z[s])) - steps[s].start / (1.0 + std::abs(steps[s].start)));
  return e <= 0.0 ? 1.0 : std::exp(-e * e / (e + 1.0 / 16.0));
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
