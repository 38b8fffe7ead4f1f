// Ray-traced pictures of a scene lit by its sun, spherical lights and sky: what the aperture pass is measured against. One bounce: base
// colour over pi times the light that arrives, light that nothing of the scene blocks.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/camera.h"
#include "formats/scene.h"
#include "formats/sky.h"

namespace overcast::bench {

struct RayTracedPixel {
  bool surface = false;    ///< of an object, and not within a lamp, which would hide it
  glm::vec3 lights{0.0f};  ///< linear radiance by sun and spheres
  glm::vec3 sky{0.0f};     ///< by the sky that no light covers
  double visible = 0.0;    ///< cosine-weighted share of the hemisphere that nothing blocks and no light covers
};

struct RayTracedSettings {
  int width = 320;
  int height = 180;
  int lightRays = 64;  ///< for each light and pixel
  int skyRays = 256;
};

/// The picture through the middles of all pixels, row by row. Normals are interpolated and turned to the eye as in the geometry pass.
/// The sky is `sky`, not the lighting's.
std::vector<RayTracedPixel> rayTrace(const Scene& scene, const Lighting& lighting, const SkyHarmonics& sky, double time, const View& view,
                                     const RayTracedSettings& settings);

}  // namespace overcast::bench
