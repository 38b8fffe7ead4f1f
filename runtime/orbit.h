// Orbit: a camera that circles a point, steered by a mouse.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "formats/camera.h"

namespace overcast {

struct Orbit {
  glm::dvec3 target{0.0};
  double yaw = 0.0;    ///< radians about +y; 0 looks along -z
  double pitch = 0.0;  ///< radians; positive looks down; kept short of straight up and down
  double distance = 1.0;
  double verticalFieldOfView = 0.6;  ///< radians
};

/// The orbit whose view looks like `view`, about the point of its line of sight that is nearest to `centre` (but before the eye by at least
/// a hundredth of `size`, the scene's diagonal). A rolled view is set upright.
Orbit orbitLike(const View& view, const glm::dvec3& centre, double size);

View viewOf(const Orbit& orbit);

/// Mouse moved by `pixels` (y down) in a window `height` pixels high: the whole height is half a turn.
void turn(Orbit& orbit, const glm::dvec2& pixels, double height);
/// The target follows the mouse.
void pan(Orbit& orbit, const glm::dvec2& pixels, double height);
/// Positive comes nearer.
void zoom(Orbit& orbit, double steps);

}  // namespace overcast
