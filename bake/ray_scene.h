// Ray scene: what visibility's rays meet, as Embree holds it. Private to bake.
#pragma once

#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "bake/visibility.h"

struct RTCDeviceTy;
struct RTCSceneTy;

namespace overcast {

/// One mesh in units of its own: position p of the mesh is (p - centre) * scale there.
struct RayScene {
  RTCDeviceTy* device = nullptr;
  RTCSceneTy* scene = nullptr;
  glm::dvec3 centre{0.0};
  double scale = 1.0;
};

/// Instances of other ray scenes in the units of one.
struct Surroundings {
  RTCSceneTy* scene = nullptr;
  /// Per instance: a direction here as one in the instance's own space, where it meets its normals. A mirrored instance keeps its outside
  /// (glTF 2.0, 3.7.4).
  std::vector<glm::mat3> thereFromHere;
};

}  // namespace overcast
