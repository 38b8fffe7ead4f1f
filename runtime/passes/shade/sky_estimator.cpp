#include "runtime/passes/shade/sky_estimator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "runtime/passes/pyramid/pyramid.h"
#include "runtime/passes/shade/calibrated_constants.h"

namespace overcast {
namespace {

using shared::SkyTap;

static_assert(kMostSkySteps == std::size_t{shared::kMaxSteps});

/// The resolution at which taps count (formats/lighting.h).
constexpr double kTapResolution = 128.0;
/// Taps are nowhere nearer than so many voxels, which mesh and field agree on.
constexpr float kNearestTap = 0.75f;

/// Where the taps of `calibrated` start, in voxels at kTapResolution.
constexpr double kFirstTap = 2.0;

/// The program's own number of traced rays.
constexpr int kTracedRays = 8;

void addPublishedTaps(const Estimator& estimator, int resolution, SkyEstimator& made) {
  const int added = static_cast<int>(std::lround(std::log2(resolution / kTapResolution)));
  const int count = std::clamp(estimator.taps + added, 1, shared::kMaxTaps);
  float sum = 0.0f;
  for (int tap = 0; tap < count; ++tap) sum += shared::tapDistance(tap);
  for (int tap = 0; tap < count; ++tap) {
    const float d = shared::tapDistance(tap);
    made.taps.push_back({d, estimator.k * d / sum, tap, 0});
  }
}

/// Taps of level 0 from `first` to `last` voxels at kTapResolution.
std::vector<SkyTap> tapsWithin(int count, double first, double last, int resolution) {
  std::vector<SkyTap> taps;
  const double ratio = count > 1 ? std::pow(last / first, 1.0 / (count - 1)) : 1.0;
  for (int tap = 0; tap < count; ++tap) {
    const double voxels = first * std::pow(ratio, tap) * resolution / kTapResolution;
    taps.push_back({std::max(static_cast<float>(voxels), kNearestTap), 0.0f, 0, 0});
  }
  return taps;
}

shared::SkyStep sharedStep(const SkyStep& step) {
  shared::SkyStep made{};
  for (int tap = 0; tap < static_cast<int>(step.weights.size()); ++tap)
    (tap < 4 ? made.nearWeights[tap] : made.farWeights[tap - 4]) = step.weights[static_cast<std::size_t>(tap)];
  for (int gap = 0; gap < static_cast<int>(step.gaps.size()); ++gap)
    (gap < 4 ? made.nearGaps[gap] : made.farGaps[gap - 4]) = step.gaps[static_cast<std::size_t>(gap)];
  made.shape = glm::vec4(step.start, step.slant, step.height, 0.0f);
  return made;
}

void addCalibratedTaps(const Estimator& estimator, int resolution, SkyEstimator& made) {
  const std::vector<SkyStep> steps = estimator.steps.empty() ? ownSteps(estimator.taps) : estimator.steps;
  const std::size_t count = steps.front().weights.size();
  for (std::size_t tap = 0; tap < count; ++tap) {
    const float outward = count > 1 ? static_cast<float>(tap) / static_cast<float>(count - 1) : 0.0f;
    made.taps.push_back({static_cast<float>(kFirstTap * resolution / kTapResolution), outward, 0, 0});
  }
  for (const SkyStep& step : steps) made.steps.push_back(sharedStep(step));
}

/// Directions that stand for equal shares of the cosine over the hemisphere about z: a spherical Fibonacci lattice, cosine-weighted.
std::vector<glm::vec3> coneDirections(int count) {
  std::vector<glm::vec3> directions;
  for (int i = 0; i < count; ++i) {
    const double z = std::sqrt(1.0 - (i + 0.5) / count), side = std::sqrt(1.0 - z * z);
    const double turn = 2.0 * std::numbers::pi * std::fmod(i / std::numbers::phi, 1.0);
    directions.emplace_back(side * std::cos(turn), side * std::sin(turn), z);
  }
  return directions;
}

void addCones(const Estimator& estimator, int resolution, SkyEstimator& made) {
  const SkyCones settings = estimator.cones.value_or(SkyCones{});
  made.directions = coneDirections(settings.directions);
  made.cone = {settings.spread, settings.bias, settings.power};
  made.taps = tapsWithin(estimator.taps, 2.0, estimator.taps <= 4 ? 35.0 : 56.0, resolution);
}

/// SkyEstimator::error: of `traced` between 0.01 and 0.08, of `calibrated` between 0.02 and 0.15, of others between 0.1 and 0.3.
constexpr double kTracedError = 0.03, kCalibratedError = 0.06, kTapsError = 0.2;

constexpr std::string_view kHybrid = "hybrid", kCalibrated = "calibrated", kTraced = "traced", kCones = "cones";

/// Of a hybrid, the estimator that says what has changed.
std::string_view baseOf(std::string_view name) {
  if (!isHybrid(name)) return name;
  return name.size() > kHybrid.size() ? name.substr(kHybrid.size() + 1) : kCalibrated;
}

}  // namespace

bool isHybrid(std::string_view name) {
  return name.starts_with(kHybrid);
}

std::string_view usedEstimator(std::string_view name, bool apertures) {
  if (!apertures) return baseOf(name);
  return isHybrid(name) ? name : kBestHybrid;
}

bool readsTaps(std::string_view name) {
  return baseOf(name) != kTraced;
}

std::string_view tapsEstimator(bool apertures) {
  return apertures ? kHybrid : kCalibrated;
}

int ownDirections(std::string_view name) {
  const std::string_view base = baseOf(name);
  return base == kTraced ? kTracedRays : base == kCones ? SkyCones{}.directions : 0;
}

bool takesTurns(const SkyEstimator& estimator) {
  return estimator.traced > 0 || !estimator.steps.empty();
}

Result<SkyEstimator> skyEstimator(const Estimator& estimator, int resolution) {
  const std::string& name = estimator.name;
  if (std::find(kEstimators.begin(), kEstimators.end(), name) == kEstimators.end())
    return Error{"", "estimator", fmt::format("unknown estimator '{}' (known: {})", name, fmt::join(kEstimators, ", "))};
  if (estimator.steps.size() > kMostSkySteps)
    return Error{"", "estimator", fmt::format("{} steps are more than {}", estimator.steps.size(), kMostSkySteps)};
  for (const SkyStep& step : estimator.steps)
    if (step.weights.size() != static_cast<std::size_t>(estimator.taps) || step.gaps.size() + 1 != step.weights.size())
      return Error{"", "estimator",
                   fmt::format("a step of {} weights and {} gaps for {} taps", step.weights.size(), step.gaps.size(), estimator.taps)};
  const std::string_view base = baseOf(name);
  SkyEstimator made;
  made.skyWeight = estimator.skyWeight;
  if (base == "published") {
    addPublishedTaps(estimator, resolution, made);
  } else if (base == kCones) {
    addCones(estimator, resolution, made);
  } else if (base == kTraced) {
    made.taps.push_back({});
    made.traced = estimator.cones ? estimator.cones->directions : kTracedRays;
  } else {
    addCalibratedTaps(estimator, resolution, made);
  }
  made.error = base == kTraced ? kTracedError : made.steps.empty() ? kTapsError : kCalibratedError;
  for (const SkyTap& tap : made.taps) made.levels = std::max(made.levels, tap.level + 1);
  return made;
}

SkyEstimator unfiltered(SkyEstimator estimator) {
  for (SkyTap& tap : estimator.taps) tap.level = 0;
  estimator.levels = 1;
  return estimator;
}

Estimator withName(Estimator estimator, std::string_view name) {
  if (baseOf(name) != baseOf(estimator.name)) {
    const int taps = estimator.taps;
    estimator = Estimator{};
    estimator.taps = taps;
  }
  estimator.name = name;
  return estimator;
}

Estimator withTaps(Estimator estimator, int taps) {
  if (taps == estimator.taps) return estimator;
  estimator.taps = taps;
  estimator.steps.clear();
  estimator.fitError = estimator.heldOutError = -1.0;
  return estimator;
}

}  // namespace overcast
