#include "runtime/orbit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace overcast {
namespace {

constexpr double kMaxPitch = 1.55;

glm::dvec3 backwards(const Orbit& orbit) {
  return {std::sin(orbit.yaw) * std::cos(orbit.pitch), std::sin(orbit.pitch), std::cos(orbit.yaw) * std::cos(orbit.pitch)};
}

}  // namespace

Orbit orbitLike(const View& view, const glm::dvec3& centre, double size) {
  const glm::dvec3 back(view.worldFromView[2]);
  Orbit orbit;
  orbit.distance = std::max({glm::dot(eye(view) - centre, back), 0.01 * size, 1e-6});
  orbit.target = eye(view) - orbit.distance * back;
  orbit.pitch = std::clamp(std::asin(std::clamp(back.y, -1.0, 1.0)), -kMaxPitch, kMaxPitch);
  orbit.yaw = std::atan2(back.x, back.z);
  orbit.verticalFieldOfView = view.verticalFieldOfView;
  return orbit;
}

View viewOf(const Orbit& orbit) {
  const glm::dvec3 from = orbit.target + orbit.distance * backwards(orbit);
  return lookAt(from, orbit.target, {0.0, 1.0, 0.0}, orbit.verticalFieldOfView);
}

void turn(Orbit& orbit, const glm::dvec2& pixels, double height) {
  const double perPixel = std::numbers::pi / height;
  orbit.yaw = std::remainder(orbit.yaw - perPixel * pixels.x, 2.0 * std::numbers::pi);
  orbit.pitch = std::clamp(orbit.pitch + perPixel * pixels.y, -kMaxPitch, kMaxPitch);
}

void pan(Orbit& orbit, const glm::dvec2& pixels, double height) {
  const glm::dmat4 axes = viewOf(orbit).worldFromView;
  const double perPixel = 2.0 * orbit.distance * std::tan(0.5 * orbit.verticalFieldOfView) / height;
  orbit.target += perPixel * (pixels.y * glm::dvec3(axes[1]) - pixels.x * glm::dvec3(axes[0]));
}

void zoom(Orbit& orbit, double steps) {
  orbit.distance *= std::pow(0.9, steps);
}

}  // namespace overcast
