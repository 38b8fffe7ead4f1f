#include "formats/camera.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace overcast {
namespace {

/// Rows and columns of a rigid frame that looks along `forward`.
glm::dmat3 axesLooking(const glm::dvec3& forward, const glm::dvec3& up) {
  glm::dvec3 right = glm::cross(forward, up);
  if (glm::length(right) < 1e-6 * glm::length(up)) right = glm::cross(forward, glm::dvec3(up.y, up.z, up.x));
  if (glm::length(right) < 1e-6 * glm::length(up)) right = glm::cross(forward, glm::dvec3(up.y, -up.x, up.z));
  right = glm::normalize(right);
  return {right, glm::cross(right, forward), -forward};
}

glm::dmat4 rigid(const glm::dmat3& axes, const glm::dvec3& origin) {
  return {glm::dvec4(axes[0], 0.0), glm::dvec4(axes[1], 0.0), glm::dvec4(axes[2], 0.0), glm::dvec4(origin, 1.0)};
}

/// Any horizontal direction, the same for the same up.
glm::dmat3 horizontalAxes(const glm::dvec3& up) {
  const glm::dvec3 start = std::abs(up.x) < 0.9 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 0.0, 1.0);
  const glm::dvec3 side = glm::normalize(start - up * glm::dot(start, up));
  return {side, up, glm::cross(side, up)};
}

}  // namespace

View lookAt(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up, double verticalFieldOfView) {
  View view;
  view.worldFromView = rigid(axesLooking(glm::normalize(target - eye), up), eye);
  view.verticalFieldOfView = verticalFieldOfView;
  view.nearPlane = 1e-3 * glm::length(target - eye);
  return view;
}

View frameBox(const Box& box, const glm::dvec3& up, double aspect) {
  constexpr double kAzimuth = 0.61;    // 35 degrees beside the front
  constexpr double kElevation = 0.42;  // 24 degrees above the horizon
  constexpr double kFieldOfView = 0.56;
  constexpr double kMargin = 1.06;
  const Box shown = isEmpty(box) ? Box{glm::dvec3(-0.5), glm::dvec3(0.5)} : box;
  const glm::dmat3 ground = horizontalAxes(glm::normalize(up));
  const glm::dvec3 away =
      std::cos(kElevation) * (std::sin(kAzimuth) * ground[0] + std::cos(kAzimuth) * ground[2]) + std::sin(kElevation) * ground[1];
  const glm::dmat3 axes = axesLooking(-away, up);
  const double tangentY = std::tan(0.5 * kFieldOfView) / kMargin;
  const double tangentX = tangentY * aspect;
  // Each corner c (view axes about the box's centre, depth forward) is inside when |c.x - e.x| <= tangentX (depth - e.depth), and y alike:
  // half planes in (e.x, e.depth), whose foremost common point is the nearest eye.
  double right = -1e300, left = -1e300, top = -1e300, bottom = -1e300;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 half = 0.5 * extent(shown) * glm::dvec3((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
    const glm::dvec3 c = glm::transpose(axes) * half;
    right = std::max(right, c.x + tangentX * c.z);
    left = std::max(left, -c.x + tangentX * c.z);
    top = std::max(top, c.y + tangentY * c.z);
    bottom = std::max(bottom, -c.y + tangentY * c.z);
  }
  const double back = std::max({(right + left) / (2.0 * tangentX), (top + bottom) / (2.0 * tangentY), 1e-3 * diagonal(shown), 1e-6});
  View view;
  view.worldFromView = rigid(axes, centre(shown) + axes * glm::dvec3(0.5 * (right - left), 0.5 * (top - bottom), back));
  view.verticalFieldOfView = kFieldOfView;
  view.nearPlane = 1e-3 * back;
  return view;
}

std::optional<View> sceneView(const Scene& scene, const std::vector<glm::dmat4>& worldFromLocal) {
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].camera < 0) continue;
    const Camera& camera = scene.cameras[static_cast<std::size_t>(scene.nodes[i].camera)];
    const glm::dmat4& node = worldFromLocal[i];
    View view;
    view.worldFromView = rigid(axesLooking(glm::normalize(-glm::dvec3(node[2])), glm::dvec3(node[1])), glm::dvec3(node[3]));
    view.verticalFieldOfView = camera.verticalFieldOfView;
    view.nearPlane = camera.nearPlane;
    return view;
  }
  return std::nullopt;
}

glm::dmat4 clipFromRelative(const View& view, double aspect) {
  const double focal = 1.0 / std::tan(0.5 * view.verticalFieldOfView);
  glm::dmat4 clipFromView(0.0);
  clipFromView[0][0] = focal / aspect;
  clipFromView[1][1] = -focal;
  clipFromView[3][2] = view.nearPlane;
  clipFromView[2][3] = -1.0;
  return clipFromView * glm::dmat4(glm::transpose(glm::dmat3(view.worldFromView)));
}

glm::dvec3 eye(const View& view) {
  return glm::dvec3(view.worldFromView[3]);
}

}  // namespace overcast
