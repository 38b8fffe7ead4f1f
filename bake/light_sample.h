// Light samples: spherical lights and the sun as a point sees them. Private to bake.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "bake/traced_scene.h"

namespace overcast {

/// A light as the cap of directions that it covers.
struct SeenLight {
  glm::dvec3 axis{0.0, 0.0, 1.0};  ///< unit
  double height = 0.0;             ///< 1 minus the cosine of the cap's radius; the solid angle is 2 pi times this
  double distance = 0.0;           ///< metres to the centre; 0: the sun
  double radius = 0.0;             ///< metres
  glm::dvec3 radiance{0.0};
};

/// The lights of `scene` around a point in world space; without those it lies in.
std::vector<SeenLight> lightsAround(const TracedScene& scene, const glm::dvec3& point);

struct LightSample {
  glm::dvec3 direction{0.0};  ///< unit
  double far = 0.0;           ///< metres to the light's surface, infinite for the sun
};

/// The direction that belongs to (u, v) of the unit square: even over the cap.
LightSample sampleLight(const SeenLight& light, double u, double v);

/// Whether any light covers a unit direction.
bool coversLight(const std::vector<SeenLight>& lights, const glm::dvec3& direction);

}  // namespace overcast
