// Calibration: fits with known answers, what is left out, and samples of a scene on the device.
#include "runtime/calibrate/calibrate.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <span>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "runtime/calibrate/robust_fit.h"
#include "tests/reference/sky.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/sky_steps.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

constexpr glm::vec3 kUp{0.0f, 1.0f, 0.0f};

/// y = a + b x at x = 0, 0.1, 0.2, ... with y given.
FitProblem line(std::span<const float> y) {
  FitProblem problem{.truth = y, .low = {-10.0, -10.0}, .high = {10.0, 10.0}, .predict = {}};
  problem.predict = [](std::span<const double> p, std::span<float> predicted) {
    for (std::size_t i = 0; i < predicted.size(); ++i) predicted[i] = static_cast<float>(p[0] + p[1] * 0.1 * static_cast<double>(i));
  };
  return problem;
}

TEST(RobustFit, FindsALineInSpiteOfOutliers) {
  std::vector<float> y;
  for (int i = 0; i < 50; ++i) y.push_back(2.0f - 0.7f * 0.1f * static_cast<float>(i));
  const std::vector<double> clean = fitRobustly(line(y), {0.0, 0.0});
  EXPECT_NEAR(clean[0], 2.0, 1e-4);
  EXPECT_NEAR(clean[1], -0.7, 1e-4);
  for (std::size_t i = 0; i < 50; i += 10) y[i] += 8.0f;
  FitProblem problem = line(y);
  const std::vector<double> robust = fitRobustly(problem, {0.0, 0.0});
  problem.outlier = 1e6;
  const std::vector<double> squares = fitRobustly(problem, {0.0, 0.0});
  EXPECT_GT(std::abs(squares[0] - 2.0), 0.5) << "the outliers matter";
  EXPECT_LT(std::abs(robust[0] - 2.0), 0.1);
  EXPECT_LT(std::abs(robust[1] + 0.7), 0.05);
}

TEST(RobustFit, OthersMakeUpForWhatABoundHoldsBack) {
  std::vector<float> y;
  for (int i = 0; i < 11; ++i) y.push_back(0.1f - 0.02f * static_cast<float>(i));
  FitProblem problem = line(y);
  problem.low[1] = 0.0;
  const std::vector<double> fitted = fitRobustly(problem, {1.0, -3.0});
  EXPECT_EQ(fitted[1], 0.0);
  EXPECT_NEAR(fitted[0], 0.0, 1e-5) << "their mean";
}

TEST(RobustFit, PullsBackWhatRowsDoNotTell) {
  const std::vector<float> y(20, 1.0f);
  FitProblem problem{.truth = y, .low = {-10.0, -10.0}, .high = {10.0, 10.0}, .predict = {}, .pull = 1e-6};
  problem.predict = [](std::span<const double> p, std::span<float> predicted) {
    for (float& value : predicted) value = static_cast<float>(p[0] + p[1]);
  };
  const std::vector<double> fitted = fitRobustly(problem, {3.0, -1.0});
  EXPECT_NEAR(fitted[0], 2.5, 0.01) << "both give way alike";
  EXPECT_NEAR(fitted[1], -1.5, 0.01);
  problem.truth = {};
  EXPECT_EQ(fitRobustly(problem, {3.0, -1.0}), (std::vector<double>{3.0, -1.0})) << "nothing to go by";
}

Estimator named(const char* name, int taps) {
  Estimator estimator;
  estimator.name = name;
  estimator.taps = taps;
  return estimator;
}

/// Readings by chance, from 0.2 below open ground to shut; of `calibrated` for each point about a mean of its own.
std::vector<float> readingsBy(std::mt19937& random, const SkyEstimator& ready) {
  std::uniform_real_distribution<float> chance(0.0f, 1.0f);
  std::vector<float> readings;
  const float shut = chance(random);
  for (std::size_t n = 0; n < readingsOf(ready); ++n)
    readings.push_back(ready.steps.empty() ? ready.taps[n % ready.taps.size()].distance * (1.7f - 1.7f * chance(random))
                                           : 1.5f * shut + chance(random) - 0.75f);
  return readings;
}

/// Points whose truth is what `known` makes of such readings, of 10 objects in 5 frames.
CalibrationSamples samplesOf(const Estimator& known, std::size_t count) {
  std::mt19937 random(5);
  const SkyEstimator ready = skyEstimator(known, 128).value();
  CalibrationSamples samples;
  samples.skyWeights = {known.skyWeight};
  samples.readings.emplace_back();
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<float> readings = readingsBy(random, ready);
    samples.readings[0].insert(samples.readings[0].end(), readings.begin(), readings.end());
    samples.sky.push_back(visibilityOf(ready, readings));
    samples.frames.push_back(static_cast<int>(i * 5 / count));
    samples.objects.push_back(static_cast<int>(random() % 10));
  }
  return samples;
}

/// Every 20th point's truth turned upside down.
void spoil(CalibrationSamples& samples) {
  for (std::size_t i = 0; i < samples.sky.size(); i += 20) samples.sky[i] = samples.sky[i] > 0.5f ? 0.0f : 1.0f;
}

TEST(Calibrate, RecoversPublishedConstants) {
  Estimator known = named("published", 4);
  known.k = 2.25f;
  CalibrationSamples samples = samplesOf(known, 2000);
  const Calibration made = calibrate(samples, named("published", 4), {});
  EXPECT_NEAR(made.estimator.k, 2.25f, 1e-3f);
  EXPECT_LT(made.estimator.fitError, 1e-4);
  EXPECT_GT(made.startError, 0.05);
  spoil(samples);
  EXPECT_NEAR(calibrate(samples, named("published", 4), {}).estimator.k, 2.25f, 0.15f) << "outliers do not move it";
}

/// One step of four taps.
Estimator oneStep(float start, float height) {
  Estimator estimator = named("calibrated", 4);
  estimator.steps = {{{1.0f, 0.0f, 0.5f, 1.5f}, {0.5f, 0.25f, 0.0f}, start, 0.5f, height}};
  return estimator;
}

TEST(Calibrate, RecoversAStep) {
  const Estimator known = oneStep(-1.5f, 1.2f);
  Estimator start = oneStep(-1.0f, 0.8f);
  CalibrationSamples samples = samplesOf(known, 400);
  const FitSettings placed{0.0, FittedSteps::placed};
  const SkyStep found = calibrate(samples, start, placed).estimator.steps[0];
  EXPECT_NEAR(found.start, -1.5f, 2e-3f);
  EXPECT_NEAR(found.height, 1.2f, 2e-3f);
  EXPECT_EQ(found.weights, start.steps[0].weights) << "only placed";
  spoil(samples);
  const SkyStep spoilt = calibrate(samples, start, placed).estimator.steps[0];
  EXPECT_NEAR(spoilt.start, -1.5f, 0.1f);
  EXPECT_NEAR(spoilt.height, 1.2f, 0.15f);
}

TEST(Calibrate, FindsStepsThatPredictAsTheKnownOnesDo) {
  Estimator known = named("calibrated", 4);
  known.steps = {{{0.5f, 0.0f, 1.5f, 1.0f}, {0.0f, 0.5f, 0.0f}, -1.0f, 0.5f, 0.8f},
                 {{0.0f, 2.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 1.0f}, -2.0f, -0.5f, 0.6f}};
  const CalibrationSamples samples = samplesOf(known, 300);
  const Calibration made = calibrate(samples, neutralStart(named("calibrated", 4), 3), {1e-9});
  EXPECT_GT(made.startError, 0.05);
  EXPECT_LT(made.estimator.fitError, 0.01);
  for (const SkyStep& step : made.estimator.steps) {
    EXPECT_GE(step.height, 0.0f);
    EXPECT_GE(*std::min_element(step.weights.begin(), step.weights.end()), 0.0f);
    EXPECT_GE(*std::min_element(step.gaps.begin(), step.gaps.end()), 0.0f);
  }
}

TEST(Calibrate, RecoversConesPredictions) {
  Estimator known = named("cones", 3);
  known.cones = SkyCones{5, 0.8f, 0.1f, 1.3f};
  Estimator start = withOwnConstants(named("cones", 3));
  start.cones->directions = 5;
  const Calibration made = calibrate(samplesOf(known, 1500), start, {});
  EXPECT_NEAR(made.estimator.cones->spread, 0.8f, 0.01f);
  EXPECT_NEAR(made.estimator.cones->bias, 0.1f, 0.01f);
  EXPECT_NEAR(made.estimator.cones->power, 1.3f, 0.02f);
}

TEST(Calibrate, WhatIsLeftOutIsPredictedNoBetterAndFramesThatDifferWorse) {
  const Estimator known = oneStep(-1.0f, 1.0f);
  CalibrationSamples samples = samplesOf(known, 500);
  std::mt19937 random(9);
  for (float& sky : samples.sky) sky += 0.05f * (static_cast<float>(random() % 1000) / 500.0f - 1.0f);
  const Estimator start = withOwnConstants(known);
  const FitSettings placed{0.0, FittedSteps::placed};
  Calibration made = calibrate(samples, start, placed);
  crossValidate(samples, start, placed, made);
  EXPECT_GE(made.framesError, made.estimator.fitError);
  EXPECT_GE(made.objectsError, made.estimator.fitError);
  EXPECT_LT(made.framesError, 1.02 * made.estimator.fitError) << "frames are alike";
  EXPECT_FALSE(made.better) << "it started from the truth";
  for (std::size_t i = 0; i < samples.sky.size(); ++i)
    if (samples.frames[i] == 2) samples.sky[i] *= 0.5f;
  crossValidate(samples, start, placed, made);
  EXPECT_GT(made.framesError, 1.05 * made.objectsError) << "one frame is unlike the others, each object is in all";
  samples.frames.assign(samples.frames.size(), 0);
  samples.objects.assign(samples.objects.size(), 3);
  crossValidate(samples, start, placed, made);
  EXPECT_LT(made.framesError, 0.0);
  EXPECT_LT(made.estimator.heldOutError, 0.0) << "nothing to leave out";
  EXPECT_FALSE(made.better);
}

TEST(Calibrate, OwnConstantsAreWrittenOutForAnyNumberOfTaps) {
  for (int taps = 1; taps <= shared::kMaxTaps; ++taps) {
    const Estimator complete = withOwnConstants(named("calibrated", taps));
    ASSERT_FALSE(complete.steps.empty());
    const SkyEstimator ready = skyEstimator(complete, 128).value();
    EXPECT_EQ(ready.taps.size(), static_cast<std::size_t>(taps));
    if (taps < 4 || taps > 6) continue;
    const SkyEstimator own = skyEstimator(named("calibrated", taps), 128).value();
    std::mt19937 random(7);
    const std::vector<float> readings = readingsBy(random, ready);
    EXPECT_EQ(visibilityOf(ready, readings), visibilityOf(own, readings));
  }
  EXPECT_TRUE(withOwnConstants(named("cones", 4)).cones.has_value());
}

TEST(Calibrate, OfOneSceneItKeepsWhatPredictsBest) {
  const Estimator known = oneStep(-1.5f, 1.2f), start = oneStep(-1.0f, 0.8f);
  const CalibrationSamples samples = samplesOf(known, 300);
  const Calibration made = calibrateScene(samples, start, start);
  EXPECT_TRUE(made.better);
  EXPECT_LT(made.estimator.heldOutError, 0.2 * made.startError) << "the weakest pull leads nearest to the truth";
  EXPECT_FALSE(calibrateScene(samples, start, made.estimator).better) << "the same again";
}

TEST(Calibrate, ReadsOfAFieldWhatTheReferenceReads) {
  const auto corner = [](const glm::dvec3& p) { return std::min({p.y - 11.3, p.x - 5.1, 3.0 + 0.5 * std::sin(p.z)}); };
  const reference::Field finest = reference::fieldOf({40, 32, 24}, corner);
  SkyField field{GlobalGrid{{1, 2, 3}, 0.25, finest.size}, {{finest.size, {finest.values.begin(), finest.values.end()}}}};
  Estimator estimator = named("calibrated", 5);
  estimator.steps = {{{0.5f, 0.0f, 0.25f, 0.0f, 2.5f}, {0.0f, 0.5f, 0.5f, 1.0f}, -2.5f, 1.0f, 1.5f},
                     {{0.0f, 1.0f, 0.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}, -2.0f, -0.5f, 1.0f}};
  const SkyEstimator ready = skyEstimator(estimator, 40).value();
  std::mt19937 random(2);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  double darkest = 1.0;
  for (int i = 0; i < 100; ++i) {
    const glm::dvec3 at(40 * chance(random), 32 * chance(random), 24 * chance(random));
    const glm::dvec3 normal = glm::normalize(glm::dvec3(chance(random) - 0.5, chance(random) - 0.3, chance(random) - 0.5));
    const SurfacePoint point{field.grid.origin + 0.25 * at, glm::vec3(normal)};
    std::vector<float> readings;
    readTaps(field, ready, kUp, point, readings);
    const double expected = reference::calibratedSky(finest, at, glm::dvec3(point.normal), ready.taps[0].distance, test::stepsOf(ready), 4);
    EXPECT_NEAR(visibilityOf(ready, readings), expected, 5e-4);
    darkest = std::min(darkest, expected);
  }
  EXPECT_LT(darkest, 0.6);
}

/// All of one frame, and the floor taken apart.
void expectPlaces(const CalibrationSamples& samples) {
  EXPECT_EQ(std::set(samples.frames.begin(), samples.frames.end()).size(), 1u);
  EXPECT_EQ(std::set(samples.objects.begin(), samples.objects.end()).size(), 4u) << "the floor is taken apart";
}

class CalibrateScene : public test::DeviceTest {
 protected:
  /// Points on the floor of the baked scene, as a reference says them, with the sky of `sky`.
  static Reference floorPoints(const glm::dvec3& origin, double scale) {
    Reference reference;
    reference.info.kind = ReferenceKind::points;
    reference.info.origin = origin;
    reference.image =
        Image{16, 16, {"depth", "normal.X", "normal.Y", "normal.Z", "object", "sky", "position.X", "position.Y", "position.Z"}, {}};
    for (int z = 0; z < 16; ++z)
      for (int x = 0; x < 16; ++x) {
        const auto at = [&](int i) { return static_cast<float>(scale * (-1.8 + 3.6 * i / 15.0)); };
        for (const float value : {0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.5f, at(x), 0.0f, at(z)}) reference.image.pixels.push_back(value);
      }
    reference.image.pixels[0] = -1.0f;  // one point less
    return reference;
  }

  CalibrationSamples read(const std::filesystem::path& file, const Reference& reference, const Estimator& estimator) {
    CalibrationSamples samples;
    samples.resolution = 64;
    samples.skyWeights = {0.25f, 0.5f};
    Result<RuntimeScene> scene = loadScene(device, file);
    EXPECT_TRUE(scene.ok()) << message(scene.error());
    const auto added = addSamples(device, scene.value(), {&reference, 1}, estimator, 1000, samples);
    EXPECT_TRUE(added.ok());
    destroyScene(device, scene.value());
    return samples;
  }
};

TEST_F(CalibrateScene, ReadsTheSameWhateverTheScaleAndPlaceOfTheScene) {
  const std::filesystem::path folder = test::temporaryFolder();
  Scene scene = test::bakedScene(folder, {});
  ASSERT_TRUE(writeScene(folder / "here.gltf", scene).ok());
  const glm::dvec3 moved(512.0, -64.0, 128.0);
  Node root;
  root.name = "root";
  root.translation = moved;
  root.scale = glm::dvec3(4.0);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    scene.nodes[i].parent = static_cast<int>(scene.nodes.size());
    root.children.push_back(static_cast<int>(i));
  }
  scene.nodes.push_back(root);
  ASSERT_TRUE(writeScene(folder / "there.gltf", scene).ok());
  for (const char* name : {"published", "calibrated"}) {
    const Estimator estimator = named(name, 4);
    const SkyEstimator ready = skyEstimator(estimator, 64).value();
    const CalibrationSamples here = read(folder / "here.gltf", floorPoints({}, 1.0), estimator);
    const CalibrationSamples there = read(folder / "there.gltf", floorPoints(moved, 4.0), estimator);
    ASSERT_EQ(here.sky.size(), 255u);
    ASSERT_EQ(here.readings.size(), 2u);
    for (std::size_t s = 0; s < 2; ++s) {
      ASSERT_EQ(here.readings[s].size(), 255u * readingsOf(ready));
      for (std::size_t i = 0; i < here.readings[s].size(); ++i) {
        // Half floats of up to 64 voxels; shares of what flat directions have feel them more.
        EXPECT_NEAR(there.readings[s][i], here.readings[s][i], 0.05f);
      }
    }
    EXPECT_EQ(here.readings[0] == here.readings[1], ready.steps.size() > 0) << "only skewed normals know the sky";
    const auto seen = [&](std::size_t point) {
      return visibilityOf(ready, std::span(here.readings[1]).subspan(point * readingsOf(ready), readingsOf(ready)));
    };
    float least = 1.0f, most = 0.0f;
    for (std::size_t point = 0; point < 255; ++point) {
      least = std::min(least, seen(point));
      most = std::max(most, seen(point));
    }
    EXPECT_LT(least, 0.5f) << "near the sphere";
    EXPECT_GT(most, 0.85f) << "open";
    expectPlaces(here);
  }
}

}  // namespace
}  // namespace overcast
