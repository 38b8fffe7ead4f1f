// Calibrate: fits the constants of a sky estimator to ray-traced truth.
//
// Only results that the formulas of shade.h keep within [0, 1] and monotone are tried: weights and heights are not negative, so that no
// surface is brighter for a tap that misses more.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "formats/lighting.h"
#include "runtime/calibrate/sky_readings.h"

namespace overcast {

/// Surface points of one or more scenes with what an estimator reads there.
struct CalibrationSamples {
  int resolution = 128;                      ///< voxels along the longest side of the volumes that were read, the same for all
  std::vector<float> skyWeights;             ///< for each: what is read with this Estimator::skyWeight
  std::vector<std::vector<float>> readings;  ///< for each of them readingsOf values per point
  std::vector<float> sky;                    ///< the truth
  std::vector<int> frames;                   ///< equal where points are of the same scene and time
  std::vector<int> objects;                  ///< equal where points are of the same object, or of the same part of a large one
};

/// Adds at most `most` points of the references of `scene` (readReferences), as many from each, read as `estimator` reads with each of
/// samples.skyWeights at samples.resolution. An Error when the device has no room.
Result<Done> addSamples(const Device& device, const RuntimeScene& scene, std::span<const Reference> references, const Estimator& estimator,
                        std::size_t most, CalibrationSamples& samples);

/// Whether the estimator of this name can be fitted: `published`, `calibrated`, `cones` and `hybrid`.
bool canCalibrate(std::string_view name);

/// `estimator` with the program's own constants written out where it leaves them to it, ready to be fitted; of `calibrated` with a number
/// of taps that the program has none for, the neutral start.
Estimator withOwnConstants(Estimator estimator);

/// Constants to start from that say nothing yet, for fits that shall not depend on what the program has. Of `calibrated`: four steps
/// by chance; of others the program's.
Estimator neutralStart(Estimator estimator, std::uint64_t seed);

/// What is fitted of the steps of `calibrated`.
enum class FittedSteps {
  whole,
  placed,  ///< where open ground lies on them and how high they are: as much as a single scene tells
};

struct FitSettings {
  double pull = 0.0;  ///< robust_fit.h
  FittedSteps steps = FittedSteps::whole;
};

/// What came of a fit. Errors are RMSE of sky visibility over the points; negative: there was nothing to leave out.
struct Calibration {
  Estimator estimator;        ///< fitted, with fitError and heldOutError
  double startError = 0.0;    ///< of the constants to be replaced: the start's
  double framesError = -1.0;  ///< on frames, each fold of them predicted by a fit to the others
  double objectsError = -1.0;
  bool better = false;  ///< heldOutError, the larger of these two, is below startError
};

/// RMSE of an estimator on the samples; its skyWeight is one of theirs.
double errorOn(const CalibrationSamples& samples, const Estimator& estimator);

/// Fits from `start`, once with each of samples.skyWeights, and keeps the one of the least error. `start` is complete (withOwnConstants)
/// and its skyWeight one of the samples'.
Calibration calibrate(const CalibrationSamples& samples, const Estimator& start, const FitSettings& settings);

/// Fits again from `start` with what `made` found best, in up to five folds without frames and without objects, and fills in the errors on
/// what was left out.
void crossValidate(const CalibrationSamples& samples, const Estimator& start, const FitSettings& settings, Calibration& made);

/// Both for one scene, with FittedSteps::placed; its points may still tell little about some constants: with weaker and stronger pulls
/// towards `start`, of which that is kept that predicts best what was left out (where nothing can be left out, the strongest). `startError`
/// and `better` are beside `present`, what the scene has now: started from something else than that, a second calibration finds the same
/// and nothing better.
Calibration calibrateScene(const CalibrationSamples& samples, const Estimator& start, const Estimator& present);

}  // namespace overcast
