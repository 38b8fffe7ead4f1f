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

/// Where taps start and how far the last one reaches, in voxels at kTapResolution, and how many levels above the one whose blur is that of
/// `published` at this distance they read.
struct Reach {
  double first;
  double last;
  double coarser;
};
constexpr int kSharp = -shared::kMaxPyramidLevels;

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

/// Taps without weights.
std::vector<SkyTap> tapsWithin(int count, const Reach& reach, int resolution) {
  std::vector<SkyTap> taps;
  const double ratio = count > 1 ? std::pow(reach.last / reach.first, 1.0 / (count - 1)) : 1.0;
  for (int tap = 0; tap < count; ++tap) {
    const double voxels = reach.first * std::pow(ratio, tap) * resolution / kTapResolution;
    const auto distance = std::max(static_cast<float>(voxels), kNearestTap);
    const int level = static_cast<int>(std::lround(std::log2(distance) + reach.coarser));
    taps.push_back({distance, 0.0f, std::clamp(level, 0, shared::kMaxPyramidLevels - 1), 0});
  }
  return taps;
}

shared::SkyStep sharedStep(const SkyStep& step) {
  shared::SkyStep made{};
  for (int tap = 0; tap < static_cast<int>(step.weights.size()); ++tap)
    (tap < 4 ? made.nearWeights[tap] : made.farWeights[tap - 4]) = step.weights[static_cast<std::size_t>(tap)];
  made.shape = glm::vec4(step.start, step.facing, step.height, 0.0f);
  return made;
}

void addCalibratedTaps(const Estimator& estimator, int resolution, SkyEstimator& made) {
  CalibratedConstants constants{estimator.weights, estimator.steps};
  if (constants.weights.empty()) constants = ownConstants(estimator.taps);
  const auto count = static_cast<int>(constants.weights.size());
  made.taps = tapsWithin(count, count <= 5 ? Reach{1.8, count <= 4 ? 44.0 : 45.0, 0.3} : Reach{1.7, 55.0, 0.6}, resolution);
  for (std::size_t tap = 0; tap < constants.weights.size(); ++tap) made.taps[tap].weight = constants.weights[tap];
  for (const SkyStep& step : constants.steps) made.steps.push_back(sharedStep(step));
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
  made.taps = tapsWithin(estimator.taps, {2.0, estimator.taps <= 4 ? 35.0 : 56.0, kSharp}, resolution);
}

/// SkyEstimator::error: of `traced` between 0.01 and 0.08, of taps between 0.1 and 0.3.
constexpr double kTracedError = 0.03, kTapsError = 0.2;

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

Result<SkyEstimator> skyEstimator(const Estimator& estimator, int resolution) {
  const std::string& name = estimator.name;
  if (std::find(kEstimators.begin(), kEstimators.end(), name) == kEstimators.end())
    return Error{"", "estimator", fmt::format("unknown estimator '{}' (known: {})", name, fmt::join(kEstimators, ", "))};
  if (!estimator.weights.empty() && estimator.weights.size() != static_cast<std::size_t>(estimator.taps))
    return Error{"", "estimator", fmt::format("{} weights for {} taps", estimator.weights.size(), estimator.taps)};
  for (const SkyStep& step : estimator.steps)
    if (step.weights.size() != estimator.weights.size() || estimator.steps.size() > kMostSkySteps)
      return Error{"", "estimator",
                   fmt::format("{} steps, one of {} weights, beside {} weights", estimator.steps.size(), step.weights.size(),
                               estimator.weights.size())};
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
  made.error = base == kTraced ? kTracedError : kTapsError;
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
  estimator.weights.clear();
  estimator.steps.clear();
  estimator.fitError = estimator.heldOutError = -1.0;
  return estimator;
}

}  // namespace overcast
