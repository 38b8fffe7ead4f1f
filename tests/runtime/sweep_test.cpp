// The settings that a report compares: their names, and what they make of a scene's lighting.
#include "runtime/report/sweep.h"

#include <algorithm>

#include <gmock/gmock.h>

#include "runtime/passes/shade/sky_estimator.h"

namespace overcast {
namespace {

using testing::HasSubstr;

TEST(ReportSweep, NamesEverySettingOnceAndTheScenesOwnFirst) {
  for (const bool apertures : {false, true}) {
    Lighting own;
    own.estimator.name = "hybrid-cones";
    own.estimator.taps = 7;
    own.globalVolume.resolution = 96;
    const auto settings = sweepSettings(own, apertures, SweepSize::full);
    EXPECT_LT(sweepSettings(own, apertures, SweepSize::quick).size(), settings.size());
    EXPECT_LT(sweepSettings(own, apertures, SweepSize::variant).size(), sweepSettings(own, apertures, SweepSize::quick).size());
    EXPECT_EQ(settings[0].taps, 7);
    EXPECT_EQ(settings[0].resolution, 96);
    EXPECT_TRUE(settings[0].storable);
    std::vector<std::string> names;
    for (const SweepSetting& setting : settings) {
      names.push_back(setting.name);
      EXPECT_TRUE(!setting.storable || setting.technique == Technique::overcast);
      EXPECT_TRUE(!setting.storable || setting.apertures == apertures) << "a scene cannot say that its apertures do not count";
      EXPECT_EQ(setting.resolution == 0, !readsVolume(setting.technique)) << setting.name;
    }
    for (const NamedTechnique& technique : kTechniques)
      EXPECT_TRUE(std::any_of(settings.begin(), settings.end(), [&](const auto& one) { return one.technique == technique.technique; }))
          << technique.name;
    for (const char* estimator : kEstimators)
      EXPECT_TRUE(std::any_of(settings.begin(), settings.end(), [&](const auto& one) { return one.estimator == estimator; }) ||
                  (isHybrid(estimator) && !apertures))
          << estimator;
    for (const int resolution : {32, 64, 96, 128, 192, 256})
      EXPECT_TRUE(std::any_of(settings.begin(), settings.end(), [&](const auto& one) { return one.resolution == resolution; }))
          << resolution;
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
  }
}

TEST(ReportSweep, NamesWhatLightsTheScene) {
  Lighting own;
  const auto first = [&](bool apertures) { return sweepSettings(own, apertures, SweepSize::quick).at(0).name; };
  EXPECT_EQ(first(false), "traced, 128^3") << "the default";
  EXPECT_EQ(first(true), "hybrid-traced, 128^3, apertures");
  own.estimator.name = "calibrated";
  EXPECT_EQ(first(false), "calibrated, 5 taps, 128^3");
  EXPECT_EQ(first(true), "hybrid-traced, 128^3, apertures") << "whatever estimator without apertures the scene names";
  own.estimator.name = "hybrid";
  own.estimator.taps = 4;
  EXPECT_EQ(first(false), "calibrated, 4 taps, 128^3") << "what it is made over";
  EXPECT_EQ(first(true), "hybrid, 4 taps, 128^3, apertures");
  own.estimator.name = "traced";
  own.estimator.cones.emplace().directions = 8;
  EXPECT_EQ(first(false), "traced, 128^3") << "as many as without a word";
  own.estimator.cones->directions = 16;
  EXPECT_EQ(first(false), "traced, 16 rays, 128^3");
  EXPECT_EQ(first(true), "hybrid-traced, 16 rays, 128^3, apertures");
  own.estimator.name = "published";
  EXPECT_EQ(first(false), "published, 4 taps, 128^3") << "has no cones to count";
}

TEST(ReportSweep, TakesSettingsAsTheyAreNamed) {
  Lighting own;
  own.estimator.taps = 4;
  own.estimator.steps = {{{1.0f, 2.0f, 3.0f, 4.0f}, {0.5f, 0.25f, 0.0f}, -1.0f, 0.0f, 1.0f}};
  own.estimator.cones.emplace().directions = 16;
  for (const char* name : {"traced", "cones", "hybrid"}) {
    own.estimator.name = name;
    for (const SweepSetting& setting : sweepSettings(own, true, SweepSize::full)) {
      if (setting.technique != Technique::overcast) continue;
      const Estimator& made = lightingWith(own, setting).estimator;
      const SkyEstimator ready = skyEstimator(made, setting.resolution).value();
      const int directions = ready.traced > 0 ? ready.traced : static_cast<int>(ready.directions.size());
      EXPECT_EQ(directions, setting.cones > 0 ? setting.cones : ownDirections(setting.estimator)) << name << ": " << setting.name;
      if (readsTaps(setting.estimator)) {
        EXPECT_EQ(made.taps, setting.taps);
      } else {
        EXPECT_EQ(made.taps, 4) << "for whoever names another estimator later";
      }
    }
  }
  EXPECT_EQ(lightingWith(own, {.estimator = "calibrated", .taps = 4, .resolution = 128}).estimator.steps.size(), 1u)
      << "fitted for what a hybrid is made over";
  EXPECT_TRUE(lightingWith(own, {.estimator = "published", .taps = 4, .resolution = 128}).estimator.steps.empty());
}

TEST(ReportSweep, SaysWhatASmallerOneLeavesOut) {
  EXPECT_EQ(leftOutOf(SweepSize::full), "");
  EXPECT_THAT(leftOutOf(SweepSize::quick), HasSubstr("32, 96 and 192 voxels"));
  for (const SweepSetting& setting : sweepSettings({}, true, SweepSize::quick))
    EXPECT_THAT((std::vector<int>{0, 64, 128, 256}), testing::Contains(setting.resolution)) << setting.name;
}

TEST(ReportSweep, WritesConesIntoTheLighting) {
  Lighting own;
  own.estimator.name = "traced";
  EXPECT_FALSE(lightingWith(own, {.estimator = "traced", .resolution = 128}).estimator.cones) << "its own number";
  const Lighting changed = lightingWith(own, {.estimator = "traced", .cones = 16, .resolution = 64});
  ASSERT_TRUE(changed.estimator.cones);
  EXPECT_EQ(changed.estimator.cones->directions, 16);
  EXPECT_EQ(changed.globalVolume.resolution, 64);
}

}  // namespace
}  // namespace overcast
