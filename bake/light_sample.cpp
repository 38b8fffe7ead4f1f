#include "bake/light_sample.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

namespace overcast {

std::vector<SeenLight> lightsAround(const TracedScene& scene, const glm::dvec3& point) {
  const auto heightOf = [](double radius) { return 2.0 * std::sin(0.5 * radius) * std::sin(0.5 * radius); };
  std::vector<SeenLight> seen;
  for (const TracedLight& light : scene.lights) {
    if (light.sun) {
      seen.push_back({light.place, heightOf(light.radius), 0.0, 0.0, light.radiance});
      continue;
    }
    const double distance = glm::length(light.place - point);
    if (distance <= light.radius) continue;
    seen.push_back(
        {(light.place - point) / distance, heightOf(std::asin(light.radius / distance)), distance, light.radius, light.radiance});
  }
  return seen;
}

LightSample sampleLight(const SeenLight& light, double u, double v) {
  const double height = light.height * u, squaredSine = height * (2.0 - height), sine = std::sqrt(squaredSine);
  const auto frame = frameOf(light.axis, 2.0 * std::numbers::pi * v);
  LightSample sample{(1.0 - height) * frame[2] + sine * frame[0], std::numeric_limits<double>::infinity()};
  if (light.distance > 0.0) {
    const double inside = light.radius * light.radius - light.distance * light.distance * squaredSine;
    sample.far = light.distance * (1.0 - height) - std::sqrt(std::max(inside, 0.0));
  }
  return sample;
}

bool coversLight(const std::vector<SeenLight>& lights, const glm::dvec3& direction) {
  return std::any_of(lights.begin(), lights.end(),
                     [&](const SeenLight& light) { return glm::dot(direction, light.axis) > 1.0 - light.height; });
}

}  // namespace overcast
