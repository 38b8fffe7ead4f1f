// SkyEstimator: a scene's sky estimator made ready for one volume (shade.h has the formulas).
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "formats/lighting.h"
#include "runtime/passes/shade/shade.h"

namespace overcast {

/// Names of Estimator::name.
inline constexpr std::array kEstimators{"published", "calibrated", "cones", "traced", "hybrid", "hybrid-cones", "hybrid-traced"};

/// Of these, the one that scenes with apertures get that name no hybrid.
inline constexpr std::string_view kBestHybrid = "hybrid-traced";

/// Whether the estimator of that name takes baked apertures, and of the estimator it is made over (`hybrid`: `calibrated`) what has changed
/// since their bake (rest.h).
bool isHybrid(std::string_view name);

struct SkyEstimator {
  std::vector<shared::SkyTap> taps;    ///< 1 to shared::kMaxTaps
  std::vector<shared::SkyStep> steps;  ///< of `calibrated`
  std::vector<glm::vec3> directions;   ///< of cones; empty: along the skewed normal
  glm::vec3 cone{0.0f};                ///< spread, bias, power
  int traced = 0;                      ///< rays of a pixel: recordDenoise must follow; 0: taps are read
  float skyWeight = 0.0f;              ///< alpha
  int levels = 1;                      ///< of the pyramid that taps read
  double error = 0.0;                  ///< root mean square of sky visibility, about, as measured on scenes of the project
};

/// The estimator at `resolution` voxels along the longest side; for a hybrid, what scenes without apertures get of it. Taps reach as far in
/// the world at any resolution; of `published`, which starts one voxel away, each doubling above 128 adds one and each halving leaves one
/// out. Of `calibrated` without weights of the scene there are 4 to 6. An Error lists the estimators we have, or says that there is not one
/// weight for each tap.
Result<SkyEstimator> skyEstimator(const Estimator& estimator, int resolution);

/// The same with all taps at level 0: what it would make of a pyramid that filters nothing.
SkyEstimator unfiltered(SkyEstimator estimator);

/// `taps` in place of the estimator's own: weights that were fitted to another number of taps give way to the program's.
Estimator withTaps(Estimator estimator, int taps);

}  // namespace overcast
