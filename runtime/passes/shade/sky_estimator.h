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

/// What lights a scene that names an estimator: kBestHybrid where the scene has apertures and names no hybrid; where it has none, what a
/// hybrid is made over.
std::string_view usedEstimator(std::string_view name, bool apertures);

/// Whether the estimator of that name, or the one that a hybrid is made over, reads taps: all but `traced`.
bool readsTaps(std::string_view name);

/// What answers where taps are asked for, of a scene lit by an estimator that reads none.
std::string_view tapsEstimator(bool apertures);

/// Directions of a pixel by the estimator of that name where the scene does not say how many; 0: it has none.
int ownDirections(std::string_view name);

struct SkyEstimator {
  std::vector<shared::SkyTap> taps;    ///< 1 to shared::kMaxTaps
  std::vector<shared::SkyStep> steps;  ///< of `calibrated`; otherwise none
  std::vector<glm::vec3> directions;   ///< of cones; empty: along the skewed normal
  glm::vec3 cone{0.0f};                ///< spread, bias, power
  int traced = 0;                      ///< rays of a pixel; 0: taps are read
  float skyWeight = 0.0f;              ///< alpha
  int levels = 1;                      ///< of the pyramid that taps read
  double error = 0.0;                  ///< root mean square of sky visibility, about, as measured on scenes of the project
};

/// Whether each pixel has only its share of what is to be seen: recordDenoise must follow.
bool takesTurns(const SkyEstimator& estimator);

/// The estimator at `resolution` voxels along the longest side; for a hybrid, what scenes without apertures get of it. Taps reach as far in
/// the world at any resolution; of `published`, which starts one voxel away, each doubling above 128 adds one and each halving leaves one
/// out. Of `calibrated` without steps of the scene there are 4 to 6. An Error lists the estimators we have, or says that a step has not one
/// weight for each tap.
Result<SkyEstimator> skyEstimator(const Estimator& estimator, int resolution);

/// The same with all taps at level 0: what it would make of a pyramid that filters nothing.
SkyEstimator unfiltered(SkyEstimator estimator);

/// The estimator of another name: with the same constants where both are made over the same estimator, else with the program's own and as
/// many taps.
Estimator withName(Estimator estimator, std::string_view name);

/// `taps` in place of the estimator's own: steps that were fitted to another number of taps give way to the program's.
Estimator withTaps(Estimator estimator, int taps);

}  // namespace overcast
