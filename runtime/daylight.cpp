#include "runtime/daylight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace overcast {
namespace {

constexpr double kLatitude = std::numbers::pi / 4.0;

/// Optical depth of clear air overhead, red, green and blue.
const glm::dvec3 kAir(0.07, 0.13, 0.28);

/// Luminance of the sky as a share of the day's, and its tint, at these sines of the sun's height.
struct SkyKey {
  double sine;
  glm::dvec3 tint;
};
const SkyKey kSkyKeys[] = {{-0.21, {0.006, 0.010, 0.030}},
                           {-0.07, {0.10, 0.09, 0.16}},
                           {0.02, {0.55, 0.33, 0.29}},
                           {0.15, {0.85, 0.78, 0.72}},
                           {0.45, {1.0, 1.0, 1.0}}};

glm::dvec3 skyTint(double sine) {
  if (sine <= kSkyKeys[0].sine) return kSkyKeys[0].tint;
  for (std::size_t i = 1; i < std::size(kSkyKeys); ++i) {
    const SkyKey &low = kSkyKeys[i - 1], &high = kSkyKeys[i];
    if (sine < high.sine) return glm::mix(low.tint, high.tint, glm::smoothstep(low.sine, high.sine, sine));
  }
  return glm::dvec3(1.0);
}

/// Air on the way to a sun of this height in radians, 1 overhead (Kasten and Young 1989).
double airMass(double height) {
  const double degrees = std::max(height, 0.0) * 180.0 / std::numbers::pi;
  return 1.0 / (std::sin(std::max(height, 0.0)) + 0.50572 * std::pow(degrees + 6.07995, -1.6364));
}

/// Unit vector towards the sun.
glm::dvec3 sunAt(const Lighting& lighting, double hours) {
  const glm::dvec3 up = glm::normalize(glm::dvec3(lighting.up));
  const glm::dvec3 other = std::abs(up.z) < 0.999 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  const glm::dvec3 east = glm::normalize(glm::cross(up, other)), south = glm::cross(east, up);
  const double angle = (hours - 12.0) * std::numbers::pi / 12.0;
  const glm::dvec3 noon = std::cos(kLatitude) * up + std::sin(kLatitude) * south;
  return std::cos(angle) * noon - std::sin(angle) * east;
}

double sineOfHeight(const Lighting& lighting, const glm::dvec3& sun) {
  return std::clamp(glm::dot(sun, glm::normalize(glm::dvec3(lighting.up))), -1.0, 1.0);
}

}  // namespace

glm::vec3 skyTintAt(const Lighting& lighting, double hours) {
  return glm::vec3(skyTint(sineOfHeight(lighting, sunAt(lighting, hours))));
}

Lighting lightingAt(const Lighting& lighting, double hours) {
  const glm::dvec3 direction = sunAt(lighting, hours);
  const double height = std::asin(sineOfHeight(lighting, direction));
  Lighting result = lighting;
  Sun sun = lighting.sun.value_or(Sun{{0, 1, 0}, glm::vec3(3.0f)});
  const double risen = glm::smoothstep(-1.0, 1.0, height / static_cast<double>(sun.angularRadius));
  sun.direction = glm::vec3(direction);
  sun.colour *= glm::vec3(risen * glm::exp(-kAir * airMass(height)));
  result.sun = sun;
  result.skyColour *= skyTintAt(lighting, hours);
  return result;
}

}  // namespace overcast
