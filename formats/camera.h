// Camera: from where a picture is taken. Perspective, reversed and infinite depth, computed in double.
#pragma once

#include <optional>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/scene.h"

namespace overcast {

/// Looks along -z of its own axes, y up (glTF 2.0, 3.10).
struct View {
  glm::dmat4 worldFromView{1.0};     ///< rigid
  double verticalFieldOfView = 0.6;  ///< radians
  double nearPlane = 0.01;           ///< metres
};

/// From `eye` towards `target`, `up` upwards in the picture (any other direction is taken when it is along the line of sight). The near
/// plane is a thousandth of their distance. `eye` and `target` differ.
View lookAt(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up, double verticalFieldOfView);

/// The nearest view in a three-quarter direction from above from which a picture of aspect `width / height` shows the whole box with a
/// small margin.
View frameBox(const Box& box, const glm::dvec3& up, double aspect);

/// The scene's first camera (in node order) where it is in `worldFromLocal` (one matrix for each node), or none. Scale in the
/// node's transform is taken out.
std::optional<View> sceneView(const Scene& scene, const std::vector<glm::dmat4>& worldFromLocal);

/// Clip space (Vulkan: y down, depth 1 at the near plane, 0 at infinity) from positions relative to the eye, in world axes.
glm::dmat4 clipFromRelative(const View& view, double aspect);

/// The eye in world space.
glm::dvec3 eye(const View& view);

}  // namespace overcast
