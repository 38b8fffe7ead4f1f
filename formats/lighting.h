// Lighting: what the glTF scene extension OVERCAST_lighting says (DESIGN 4). Schema: formats/schema/OVERCAST_lighting.schema.json
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast {

struct Sun {
  glm::vec3 direction{0.0f, 1.0f, 0.0f};  ///< unit vector towards the sun
  glm::vec3 colour{0.0f};                 ///< linear radiance times solid angle
  float angularRadius = 0.00465f;         ///< radians
};

/// A spherical area light.
struct AreaLight {
  glm::vec3 position{0.0f};  ///< world space, or that of `node`
  float radius = 0.1f;       ///< metres
  glm::vec3 colour{1.0f};    ///< linear radiance
  int node = -1;             ///< index into Scene::nodes: the light moves with it; -1: it stays where it is
};

/// Cones of the estimators `cones` and `traced` (DESIGN 5.4). Of `cones` each is as open as the least of clamp(phi / (d spread) + bias)
/// over its taps. `traced` has `directions` only: so many in each pixel, of 256 times as many that neighbours share.
struct SkyCones {
  int directions = 7;   ///< 1 to 64 for each pixel, over the hemisphere about the normal, each for the same share of the cosine
  float spread = 0.5f;  ///< above 0: width of a cone per distance
  float bias = 0.0f;    ///< 0 to 1: what is left of a cone whose axis just touches
  float power = 0.7f;   ///< above 0: of their mean
};

/// A soft step in the exponent of `calibrated` (runtime/passes/shade/shade.h).
struct SkyStep {
  std::vector<float> weights;  ///< of what the taps miss, at least 0, as many as there are, the nearest first
  std::vector<float> gaps;     ///< of what is not known to be free between them, at least 0, one fewer
  float start = 0.0f;          ///< where open ground lies on it, along the normal
  float slant = 0.0f;          ///< how far along it directions at a right angle to the normal lie beyond that
  float height = 0.0f;         ///< half of what it adds from end to end, at least 0
};
inline constexpr std::size_t kMostSkySteps = 8;

/// A sky estimator and its constants (DESIGN 5.4), of which `traced` reads none but the directions of its cones. They mean the same at any
/// resolution of the global volume and at any scale of the scene.
struct Estimator {
  std::string name = "traced";  ///< one of kEstimators (runtime/passes/shade/sky_estimator.h); taps alone do not reach the walls of a room
  int taps = 5;    ///< 1 to 8, at 128 voxels along the longest side; of `published` at 1, 2, 4, ... voxels, and one more per doubling
  float k = 1.5f;  ///< at least 0: darkening; a point that all taps find shut gets about exp(-k (1 + alpha)), open ground 1
  float skyWeight = 0.5f;  ///< alpha in N' = N + alpha U, 0 to 1 (Evans 2006, 9.6); an open wall gets 1/2 where k alpha = 0.75
  /// Of `calibrated`, up to kMostSkySteps; none: the program's own, fitted to generated scenes for 4 to 6 taps.
  std::vector<SkyStep> steps;
  std::optional<SkyCones> cones;  ///< none: the program's own; 8 directions for `traced`
  double fitError = -1.0;         ///< RMSE against the reference they were fitted to; negative: not fitted
  double heldOutError = -1.0;     ///< RMSE on frames and objects that were left out of the fit (cross validation); negative: not known
};

/// The one distance volume that all objects are composited into.
struct GlobalVolume {
  std::optional<Box> bounds;  ///< world space; none: the animated bounds of the scene, padded
  int resolution = 128;       ///< voxels along the longest side, a multiple of 8 from 32 to 256
};

inline constexpr int kLightingVersion = 1;

struct Lighting {
  glm::vec3 skyColour{0.80f, 0.90f, 1.0f};  ///< linear radiance of the sky dome; with an image: for readers that take no images
  std::string skyImage;                     ///< an EXR beside the scene (relative path) that is the sky (formats/sky.h); empty: uniform
  glm::vec3 up{0.0f, 1.0f, 0.0f};           ///< unit vector U
  std::optional<Sun> sun;
  std::vector<AreaLight> areaLights;
  GlobalVolume globalVolume;
  Estimator estimator;
  float exposure = 1.0f;  ///< linear factor before the tone curve
};

}  // namespace overcast
