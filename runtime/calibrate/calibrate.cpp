#include "runtime/calibrate/calibrate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include <glm/vector_relational.hpp>

#include "formats/result.h"
#include "runtime/calibrate/robust_fit.h"
#include "runtime/passes/shade/calibrated_constants.h"

namespace overcast {
namespace {

constexpr double kMost = 20.0;
constexpr double kSteepest = 12.0;  // of steps: steeper ones draw lines where surfaces cross them
constexpr double kLowest = 0.02;    // of their heights: nothing tells where one of none should lie, so it would stay at none
constexpr double kFurthest = 12.0;  // of where open ground lies on one
constexpr std::size_t kSteps = 4;   // more predict no better what was left out
constexpr int kFolds = 5;
constexpr std::array kPulls{1e-2, 1e-3, 1e-4};  // of one scene

using Parameters = std::vector<double>;

bool isCalibrated(std::string_view name) {
  return name == "calibrated" || name == "hybrid";
}

/// What is fitted of an estimator: visits its constants in a fixed order, with their bounds.
template <class Constants, class Visit>
void visitConstants(Constants& estimator, FittedSteps fitted, const Visit& visit) {
  if (estimator.name == "published") return visit(estimator.k, 0.0, kMost);
  if (estimator.name == "cones") {
    visit(estimator.cones->spread, 0.02, 10.0);
    visit(estimator.cones->bias, 0.0, 1.0);
    return visit(estimator.cones->power, 0.05, 10.0);
  }
  for (auto& step : estimator.steps) {
    visit(step.start, -kFurthest, kFurthest);
    visit(step.height, kLowest, kMost);
    if (fitted == FittedSteps::placed) continue;
    for (auto& weight : step.weights) visit(weight, 0.0, kSteepest);
    for (auto& gap : step.gaps) visit(gap, 0.0, kSteepest);
    visit(step.slant, -kSteepest, kSteepest);
  }
}

Estimator withParameters(Estimator estimator, FittedSteps fitted, std::span<const double> parameters) {
  std::size_t next = 0;
  visitConstants(estimator, fitted, [&](float& constant, double, double) { constant = static_cast<float>(parameters[next++]); });
  return estimator;
}

/// Rows of the samples, all of one skyWeight.
struct Rows {
  const CalibrationSamples& samples;
  std::size_t skyWeight = 0;  ///< index
  std::vector<std::size_t> rows;
};

void predict(const Rows& rows, const Estimator& estimator, std::span<float> predicted) {
  const CalibrationSamples& samples = rows.samples;
  const SkyEstimator ready = skyEstimator(estimator, samples.resolution).value();
  const std::size_t each = readingsOf(ready);
  const std::span<const float> readings = samples.readings[rows.skyWeight];
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const std::size_t row = rows.rows[i];
    predicted[i] = visibilityOf(ready, readings.subspan(row * each, each));
  }
}

std::vector<float> truthOf(const Rows& rows) {
  std::vector<float> truth;
  for (const std::size_t row : rows.rows) truth.push_back(rows.samples.sky[row]);
  return truth;
}

Estimator fit(const Rows& rows, Estimator start, const FitSettings& settings) {
  start.skyWeight = rows.samples.skyWeights[rows.skyWeight];
  const std::vector<float> truth = truthOf(rows);
  FitProblem problem{.truth = truth, .low = {}, .high = {}, .predict = {}, .pull = settings.pull};
  Parameters parameters;
  visitConstants(start, settings.steps, [&](float constant, double low, double high) {
    parameters.push_back(double{constant});
    problem.low.push_back(low);
    problem.high.push_back(high);
  });
  problem.predict = [&](std::span<const double> tried, std::span<float> predicted) {
    predict(rows, withParameters(start, settings.steps, tried), predicted);
  };
  return withParameters(start, settings.steps, fitRobustly(problem, std::move(parameters)));
}

/// Root mean square of a fit's error on rows.
double errorOn(const Rows& rows, const Estimator& estimator) {
  std::vector<float> predicted(rows.rows.size());
  predict(rows, estimator, predicted);
  return rootMeanSquare(predicted, truthOf(rows));
}

std::size_t indexOf(const CalibrationSamples& samples, float skyWeight) {
  const auto found = std::find(samples.skyWeights.begin(), samples.skyWeights.end(), skyWeight);
  OVERCAST_REQUIRE(found != samples.skyWeights.end(), "a sky weight of {} was not read", skyWeight);
  return static_cast<std::size_t>(found - samples.skyWeights.begin());
}

std::vector<std::size_t> allRows(const CalibrationSamples& samples) {
  std::vector<std::size_t> rows(samples.sky.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  return rows;
}

/// A fold for each row: groups, the largest first, each to the smallest fold so far. Empty where there is one group only.
std::vector<int> foldsOf(const std::vector<int>& groups) {
  std::map<int, std::size_t> sizes;
  for (const int group : groups) ++sizes[group];
  if (sizes.size() < 2) return {};
  std::vector<std::pair<std::size_t, int>> order;
  for (const auto& [group, size] : sizes) order.emplace_back(size, group);
  std::sort(order.begin(), order.end(),
            [](const auto& a, const auto& b) { return a.first != b.first ? a.first > b.first : a.second < b.second; });
  std::vector<std::size_t> filled(std::min<std::size_t>(kFolds, order.size()));
  std::map<int, int> foldOf;
  for (const auto& [size, group] : order) {
    const auto least = std::min_element(filled.begin(), filled.end());
    foldOf[group] = static_cast<int>(least - filled.begin());
    *least += size;
  }
  std::vector<int> folds;
  for (const int group : groups) folds.push_back(foldOf[group]);
  return folds;
}

/// Error on what was left out, over all folds; negative without folds.
double heldOutError(const CalibrationSamples& samples, const std::vector<int>& groups, const Estimator& start,
                    const FitSettings& settings) {
  const std::vector<int> folds = foldsOf(groups);
  if (folds.empty()) return -1.0;
  const std::size_t skyWeight = indexOf(samples, start.skyWeight);
  double squares = 0.0;
  for (int fold = 0; fold <= *std::max_element(folds.begin(), folds.end()); ++fold) {
    Rows kept{samples, skyWeight, {}}, leftOut{samples, skyWeight, {}};
    for (std::size_t row = 0; row < folds.size(); ++row) (folds[row] == fold ? leftOut : kept).rows.push_back(row);
    const double error = errorOn(leftOut, fit(kept, start, settings));
    squares += error * error * static_cast<double>(leftOut.rows.size());
  }
  return std::sqrt(squares / static_cast<double>(folds.size()));
}

int idAfter(const std::vector<int>& ids) {
  return ids.empty() ? 0 : 1 + *std::max_element(ids.begin(), ids.end());
}

void addPoint(const SkyField& field, const Estimator& estimator, const glm::vec3& up, const SurfacePoint& point,
              CalibrationSamples& samples) {
  samples.sky.push_back(point.sky);
  for (std::size_t i = 0; i < samples.skyWeights.size(); ++i) {
    Estimator skewed = estimator;
    skewed.skyWeight = samples.skyWeights[i];
    readTaps(field, skyEstimator(skewed, samples.resolution).value(), up, point, samples.readings[i]);
  }
}

/// An id for the object of each point. Objects of more than a fold are taken apart into octants about their middle: without all of the
/// ground, nothing would tell what ground looks like.
std::vector<int> objectsOf(const std::vector<SurfacePoint>& points) {
  struct Sum {
    std::size_t count = 0;
    glm::dvec3 position{0.0};
  };
  std::map<int, Sum> sums;
  for (const SurfacePoint& point : points) {
    ++sums[point.object].count;
    sums[point.object].position += point.position;
  }
  std::vector<int> objects;
  for (const SurfacePoint& point : points) {
    const Sum& sum = sums[point.object];
    const glm::dvec3 middle = sum.position / static_cast<double>(sum.count);
    const glm::bvec3 beyond = glm::greaterThan(point.position, middle);
    const int octant = (beyond.x ? 1 : 0) + (beyond.y ? 2 : 0) + (beyond.z ? 4 : 0);
    objects.push_back(8 * point.object + (kFolds * sum.count > points.size() ? octant : 0));
  }
  return objects;
}

void judge(Calibration& made) {
  made.better = made.estimator.heldOutError >= 0.0 && made.estimator.heldOutError < made.startError;
}

/// Single floats that are the same on every machine.
float chance(std::mt19937& engine, float low, float high) {
  return low + (high - low) * static_cast<float>(engine() >> 8) * 0x1p-24f;
}

}  // namespace

Result<Done> addSamples(const Device& device, const RuntimeScene& scene, std::span<const Reference> references, const Estimator& estimator,
                        std::size_t most, CalibrationSamples& samples) {
  auto made = makeFieldMaker(device, scene, samples.resolution);
  if (!made) return made.error();
  FieldMaker& maker = made.value();
  samples.readings.resize(samples.skyWeights.size());
  std::map<double, std::vector<const Reference*>> byTime;
  for (const Reference& reference : references) byTime[reference.info.time].push_back(&reference);
  Result<Done> done = Done{};
  std::vector<SurfacePoint> added;
  int frame = idAfter(samples.frames);
  for (const auto& [time, those] : byTime) {
    const auto field = readField(device, maker, scene, time);
    if (!field) done = field.error();
    if (!field) break;
    for (const Reference* reference : those) {
      for (const SurfacePoint& point : surfacePoints(*reference, std::max<std::size_t>(1, most / references.size()))) {
        addPoint(field.value(), estimator, scene.lighting.up, point, samples);
        samples.frames.push_back(frame);
        added.push_back(point);
      }
    }
    ++frame;
  }
  const int firstObject = idAfter(samples.objects);
  for (const int object : objectsOf(added)) samples.objects.push_back(firstObject + object);
  destroyFieldMaker(device, maker);
  return done;
}

bool canCalibrate(std::string_view name) {
  return name == "published" || name == "cones" || isCalibrated(name);
}

Estimator withOwnConstants(Estimator estimator) {
  if (estimator.name == "cones" && !estimator.cones) estimator.cones.emplace();
  if (!isCalibrated(estimator.name) || !estimator.steps.empty()) return estimator;
  std::vector<SkyStep> own = ownSteps(estimator.taps);
  if (own.front().weights.size() != static_cast<std::size_t>(estimator.taps)) return neutralStart(std::move(estimator), 1);
  estimator.steps = std::move(own);
  return estimator;
}

Estimator neutralStart(Estimator estimator, std::uint64_t seed) {
  if (!isCalibrated(estimator.name)) return withOwnConstants(std::move(estimator));
  std::mt19937 engine(static_cast<std::mt19937::result_type>(seed));
  const auto count = static_cast<std::size_t>(estimator.taps);
  const auto weight = [&] { return 4.0f * std::pow(chance(engine, 0.0f, 1.0f), 2.0f); };
  estimator.steps.clear();
  for (std::size_t i = 0; i < kSteps; ++i) {
    SkyStep& step = estimator.steps.emplace_back();
    for (std::size_t tap = 0; tap < count; ++tap) step.weights.push_back(weight());
    for (std::size_t tap = 1; tap < count; ++tap) step.gaps.push_back(weight());
    step.start = chance(engine, -4.0f, 0.0f);
    step.slant = chance(engine, -1.0f, 1.0f);
    step.height = chance(engine, 0.3f, 1.5f);
  }
  return estimator;
}

double errorOn(const CalibrationSamples& samples, const Estimator& estimator) {
  return errorOn(Rows{samples, indexOf(samples, estimator.skyWeight), allRows(samples)}, estimator);
}

Calibration calibrate(const CalibrationSamples& samples, const Estimator& start, const FitSettings& settings) {
  OVERCAST_REQUIRE(canCalibrate(start.name), "{} has no constants", start.name);
  Calibration made;
  made.startError = errorOn(samples, start);
  for (std::size_t i = 0; i < samples.skyWeights.size(); ++i) {
    Estimator fitted = fit(Rows{samples, i, allRows(samples)}, start, settings);
    fitted.fitError = errorOn(samples, fitted);
    if (i == 0 || fitted.fitError < made.estimator.fitError) made.estimator = std::move(fitted);
  }
  return made;
}

void crossValidate(const CalibrationSamples& samples, const Estimator& start, const FitSettings& settings, Calibration& made) {
  Estimator from = start;
  from.skyWeight = made.estimator.skyWeight;
  made.framesError = heldOutError(samples, samples.frames, from, settings);
  made.objectsError = heldOutError(samples, samples.objects, from, settings);
  made.estimator.heldOutError = std::max(made.framesError, made.objectsError);
  judge(made);
}

Calibration calibrateScene(const CalibrationSamples& samples, const Estimator& start, const Estimator& present) {
  std::optional<Calibration> best;
  for (const double pull : kPulls) {
    const FitSettings settings{pull, FittedSteps::placed};
    Calibration made = calibrate(samples, start, settings);
    crossValidate(samples, start, settings, made);
    if (!best || made.estimator.heldOutError < best->estimator.heldOutError) best = std::move(made);
  }
  best->startError = errorOn(samples, present);
  judge(*best);
  return *best;
}

}  // namespace overcast
