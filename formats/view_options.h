// View options: which pictures a command line asks for, in the same words for overcast-player and overcast-bake.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include <glm/vec3.hpp>

#include "formats/camera.h"
#include "formats/result.h"
#include "formats/scene.h"

namespace overcast {

/// --camera "px,py,pz,tx,ty,tz[,fovdeg]"
struct CameraOption {
  glm::dvec3 eye{0.0};
  glm::dvec3 target{0.0};
  double verticalFieldOfView = 0.6;  ///< radians
};

/// "first:last" or one number, both at least 0, first <= last.
Result<std::pair<int, int>> parseFrames(const std::string& text);
/// "WxH", each from 1 to 16384.
Result<std::pair<int, int>> parseSize(const std::string& text);
Result<CameraOption> parseCamera(const std::string& text);

/// The view at `time` seconds: `camera`, else the scene's first camera, else one that shows all of `bounds` (worldBounds of the scene).
/// `aspect` is width over height.
View chooseView(const Scene& scene, const Box& bounds, const std::optional<CameraOption>& camera, double time, double aspect);

}  // namespace overcast
