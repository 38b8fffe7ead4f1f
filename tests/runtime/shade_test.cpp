// Sky light: formulas against closed forms and brute force in double, then the pass on the device.
#include "runtime/passes/shade/shade_pass.h"

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "runtime/calibrate/sky_readings.h"
#include "tests/reference/sky.h"
#include "tests/runtime/ground.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/shaded_ground.h"
#include "tests/runtime/sky_steps.h"
#include "tests/runtime/support.h"

namespace overcast::test {
namespace {

using reference::Field;

constexpr int kSide = kGroundSide;
constexpr glm::dvec3 kUp{0, 1, 0};

class Shade : public ShadedGround {};

TEST(SkyEstimators, PublishedMeansTheSameAtAnyResolution) {
  for (const auto& [resolution, count] : {std::pair{32, 3}, {64, 4}, {128, 5}, {256, 6}}) {
    const SkyEstimator made = skyEstimator(named("published"), resolution).value();
    ASSERT_EQ(made.taps.size(), static_cast<std::size_t>(count));
    EXPECT_EQ(made.levels, count);
    // A shut point misses d_i at every tap; a wall half of what open ground sees.
    float shut = 0.0f;
    for (const shared::SkyTap& tap : made.taps) shut += tap.weight;
    EXPECT_NEAR(shut, Estimator{}.k, 1e-5f);
    EXPECT_NEAR(shared::skyVisibility(shut * Estimator{}.skyWeight), 0.5f, 1e-3f);
  }
  Estimator eight = named("published");
  eight.taps = 8;
  EXPECT_EQ(skyEstimator(eight, 256).value().taps.size(), 8u);
}

TEST(SkyEstimators, ReachAsFarAtAnyResolution) {
  for (const char* name : kEstimators) {
    if (name == std::string("published")) continue;
    const SkyEstimator coarse = skyEstimator(named(name), 128).value(), fine = skyEstimator(named(name), 256).value();
    ASSERT_EQ(coarse.taps.size(), fine.taps.size()) << name;
    for (std::size_t i = 0; i < coarse.taps.size(); ++i) {
      EXPECT_NEAR(fine.taps[i].distance, 2.0f * coarse.taps[i].distance, 1e-4f) << name;
      EXPECT_EQ(fine.taps[i].weight, coarse.taps[i].weight);
      EXPECT_EQ(fine.taps[i].level, 0);
    }
  }
}

TEST(SkyEstimators, LightScenesAsTheirAperturesAllow) {
  EXPECT_EQ(Estimator{}.name, "traced");
  EXPECT_EQ(usedEstimator("published", false), "published");
  EXPECT_EQ(usedEstimator("published", true), "hybrid-traced");
  EXPECT_EQ(usedEstimator("hybrid-cones", true), "hybrid-cones");
  EXPECT_EQ(usedEstimator("hybrid-cones", false), "cones");
  EXPECT_EQ(usedEstimator("hybrid", false), "calibrated");
  for (const char* name : kEstimators) {
    const SkyEstimator made = skyEstimator(named(name), 128).value();
    EXPECT_EQ(readsTaps(name), made.traced == 0) << name;
    EXPECT_EQ(ownDirections(name), made.traced + static_cast<int>(made.directions.size())) << name;
    for (const bool apertures : {false, true}) EXPECT_EQ(isHybrid(usedEstimator(name, apertures)), apertures);
  }
  for (const bool apertures : {false, true}) {
    EXPECT_TRUE(readsTaps(tapsEstimator(apertures)));
    EXPECT_EQ(usedEstimator(tapsEstimator(apertures), apertures), tapsEstimator(apertures));
  }
}

TEST(SkyEstimators, KeepConstantsOfTheSameFormula) {
  Estimator fitted = named("calibrated");
  fitted.taps = 2;
  fitted.steps = {{{1.0f, 2.0f}, {0.5f}, -1.0f, 0.0f, 1.0f}};
  fitted.skyWeight = 0.25f;
  const Estimator hybrid = withName(fitted, "hybrid"), traced = withName(fitted, "traced");
  EXPECT_EQ(hybrid.name, "hybrid");
  ASSERT_EQ(hybrid.steps.size(), 1u);
  EXPECT_EQ(hybrid.steps[0].weights, fitted.steps[0].weights);
  EXPECT_EQ(hybrid.skyWeight, 0.25f);
  EXPECT_EQ(traced.name, "traced");
  EXPECT_EQ(traced.taps, 2) << "for whoever asks for taps later";
  EXPECT_TRUE(traced.steps.empty());
  EXPECT_EQ(traced.skyWeight, Estimator{}.skyWeight);
}

TEST(SkyEstimators, UnknownNamesAndWeightsAreRefused) {
  const Result<SkyEstimator> refused = skyEstimator(named("magic"), 128);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(message(refused.error()).find("'magic'"), std::string::npos);
  for (const char* name : kEstimators) EXPECT_NE(message(refused.error()).find(name), std::string::npos) << "lists what there is";
}

TEST(SkyEstimators, StepsGoWithTaps) {
  Estimator calibrated = named("calibrated");
  calibrated.taps = 2;
  calibrated.steps = {{{0.5f, 0.25f}, {0.125f}, -1.0f, 0.5f, 2.0f}};
  const SkyEstimator made = skyEstimator(calibrated, 128).value();
  ASSERT_EQ(made.steps.size(), 1u);
  ASSERT_EQ(made.taps.size(), 2u);
  EXPECT_EQ(made.taps[0].weight, 0.0f);
  EXPECT_EQ(made.taps[1].weight, 1.0f) << "the last is where a ray leaves the volume";
  EXPECT_TRUE(takesTurns(made));
  EXPECT_TRUE(withTaps(calibrated, 4).steps.empty()) << "fitted to other taps";
  calibrated.steps[0].gaps.push_back(1.0f);
  EXPECT_FALSE(skyEstimator(calibrated, 128).ok()) << "one gap too many";
  calibrated.steps[0].gaps.pop_back();
  calibrated.taps = 3;
  EXPECT_FALSE(skyEstimator(calibrated, 128).ok()) << "one weight too few";
  calibrated.taps = 2;
  calibrated.steps.assign(kMostSkySteps + 1, calibrated.steps[0]);
  EXPECT_FALSE(skyEstimator(calibrated, 128).ok()) << "one step too many";
}

TEST(SkyEstimators, OwnConstantsAreMonotoneAndOpenGroundIsOpen) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> chance(0.0f, 1.0f);
  for (const int taps : {4, 5, 6}) {
    Estimator estimator = named("calibrated");
    estimator.taps = taps;
    const SkyEstimator made = skyEstimator(estimator, 128).value();
    ASSERT_EQ(made.taps.size(), static_cast<std::size_t>(taps));
    const std::size_t each = 2 * made.taps.size() - 1;
    // What the pattern makes of the same share of open ground at each tap, in every direction.
    const auto sky = [&](const std::vector<float>& shares) {
      std::vector<float> readings;
      for (int n = 0; n < shared::kPointPlaces; ++n) {
        const int place = shared::pointPlace(n);
        const float u = shared::tracedDirection(0, 1, place).z;
        std::vector<float> d, phi;
        for (std::size_t i = 0; i < shares.size(); ++i) {
          d.push_back(shared::calibratedDistance(made.taps[i], place, 90.0f));
          phi.push_back(u * d[i] * shares[i]);
        }
        for (std::size_t i = 0; i < d.size(); ++i) readings.push_back(shared::shareMissing(phi[i], d[i], u));
        for (std::size_t i = 0; i + 1 < d.size(); ++i) readings.push_back(shared::gapMissing(phi[i], d[i], phi[i + 1], d[i + 1], u));
      }
      EXPECT_EQ(readings.size(), shared::kPointPlaces * each);
      return visibilityOf(made, readings);
    };
    EXPECT_NEAR(sky(std::vector<float>(made.taps.size(), 1.0f)), 1.0f, 1e-5f);
    EXPECT_LT(sky(std::vector<float>(made.taps.size(), 0.0f)), 0.05f) << "shut";
    for (int n = 0; n < 500; ++n) {
      std::vector<float> shares;
      for (std::size_t i = 0; i < made.taps.size(); ++i) shares.push_back(1.5f * chance(random) - 0.25f);
      const float before = sky(shares);
      EXPECT_TRUE(before >= 0.0f && before <= 1.0f);
      shares[static_cast<std::size_t>(n) % shares.size()] -= chance(random);
      EXPECT_LE(sky(shares), before + 1e-6f) << taps;
    }
  }
}

TEST(SkyEstimators, CalibratedTapsEndWhereTheRayLeaves) {
  Estimator estimator = named("calibrated");
  estimator.taps = 4;
  const SkyEstimator made = skyEstimator(estimator, 128).value();
  for (const float end : {30.0f, 64.0f, 200.0f}) {
    double starts = 0.0;
    for (int place = 0; place < shared::kWidePatternSize; ++place) {
      std::vector<float> d;
      for (const shared::SkyTap& tap : made.taps) d.push_back(shared::calibratedDistance(tap, place, end));
      EXPECT_NEAR(d[3], end, 1e-4f * end);
      EXPECT_NEAR(d[1] / d[0], d[3] / d[2], 1e-3f * d[1] / d[0]) << "equal ratios";
      starts += std::log2(d[0]) / shared::kWidePatternSize;
    }
    EXPECT_NEAR(starts, std::log2(made.taps[0].distance), 1e-4);
  }
  for (const shared::SkyTap& tap : made.taps) EXPECT_LE(shared::calibratedDistance(tap, 5, 2.5f), 2.5f) << "and never beyond";
}

TEST(SkyEstimators, ConesStandForEqualSharesOfTheCosine) {
  for (const int count : {1, 4, 7, 16, 64}) {
    Estimator cones = named("cones");
    cones.cones.emplace().directions = count;
    glm::vec3 sum(0.0f);
    const SkyEstimator made = skyEstimator(cones, 128).value();
    for (const glm::vec3& direction : made.directions) {
      EXPECT_NEAR(glm::length(direction), 1.0f, 1e-5f);
      sum += direction / static_cast<float>(count);
    }
    EXPECT_NEAR(sum.z, 2.0f / 3.0f, count == 1 ? 0.05f : 0.012f) << "the mean of z under a cosine";
    EXPECT_LT(glm::length(glm::vec2(sum.x, sum.y)), count == 1 ? 0.75f : 0.25f) << count;
  }
}

TEST(ShadeFormulas, DegenerateNormalsCountAsNone) {
  const glm::vec3 skew(0.0f, 0.5f, 0.0f);
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const glm::vec3& normal : {glm::vec3(0.0f), glm::vec3(nan, 0, 1), glm::vec3(inf, 0, 0), glm::vec3(1e-30f, 0, 0)})
    EXPECT_EQ(shared::skewedNormal(normal, skew), skew);
  EXPECT_EQ(shared::skewedNormal({0.0f, 0.0f, 3.0f}, skew), glm::vec3(0.0f, 0.5f, 1.0f));
}

TEST(ShadeFormulas, VisibilityIsBetweenZeroAndOne) {
  EXPECT_EQ(shared::skyVisibility(-65504.0f), 1.0f);
  EXPECT_EQ(shared::skyVisibility(65504.0f), 0.0f);
  EXPECT_EQ(shared::skyVisibility(std::numeric_limits<float>::infinity()), 0.0f);
  for (int step = -100; step < 500; ++step)
    EXPECT_LE(shared::skyVisibility(0.01f * static_cast<float>(step + 1)), shared::skyVisibility(0.01f * static_cast<float>(step)));
  EXPECT_NEAR(shared::skyVisibility(0.001f), 1.0f, 2e-5f) << "no kink at open ground";
  EXPECT_NEAR(shared::skyVisibility(3.0f) / std::exp(-3.0f + 0.0625f), 1.0f, 0.002f);
}

TEST(ShadeFormulas, InsideLevelIsTheNearestPointHalfATexelIn) {
  const glm::vec3 size(64, 16, 8);
  EXPECT_EQ(shared::insideLevel({-5, 70, 3}, size, 0), glm::vec3(0.5f, 15.5f, 3));
  EXPECT_EQ(shared::insideLevel({-5, 8, 3}, size, 4), glm::vec3(8, 8, 4)) << "a level coarser than a side is sampled in its middle";
}

TEST_F(Shade, OpenSurfacesHaveTheirClosedForm) {
  // Level 3 of a linear field is linear: the pass must give the exponentials of shade.h wherever the ground turns.
  const double k = Estimator{}.k, alpha = Estimator{}.skyWeight;
  const auto eased = [](double e) { return std::exp(-e * e / (e + 1.0 / 16.0)); };
  const std::vector<std::pair<glm::dvec3, double>> cases{
      {{0, 1, 0}, 1.0}, {{1, 0, 0}, eased(k * alpha)}, {{0, -1, 0}, eased(k * 2.0 * alpha)}, {{0.6, 0.8, 0}, eased(k * alpha * 0.2)}};
  for (const auto& [normal, expected] : cases) {
    const Field half = groundCube([&n = normal](const glm::dvec3& p) { return glm::dot(p - glm::dvec3(32), n); });
    Setting setting;
    setting.left = 31;
    setting.right = 33;
    const auto on = [&n = normal](double x, double z) {
      // The height at which the column meets the plane through the middle; for walls any height is on the plane only at x = 32.
      const double y = std::abs(n.y) > 0.1 ? 32.0 - (n.x * (x - 32.0) + n.z * (z - 32.0)) / n.y : 32.0;
      return Surface{y, glm::vec3(n)};
    };
    const std::vector<Pixel> pixels = shade(half, on, setting);
    const std::size_t middle = 32 * kSide + 32;
    EXPECT_NEAR(pixels[middle].sky, expected, 0.01) << normal.x << " " << normal.y;
    EXPECT_NEAR(pixels[middle].light.x, 0.5 * expected, 0.01);
    EXPECT_NEAR(pixels[middle].light.z, 1.0 * expected, 0.01);
  }
}

/// Sky of open ground points by the reference, for an estimator made ready.
double referenceSky(const std::string& name, const std::vector<Field>& levels, const glm::dvec3& point, const SkyEstimator& made) {
  std::vector<reference::Tap> taps;
  for (const shared::SkyTap& tap : made.taps) taps.push_back({tap.distance, tap.weight, tap.level});
  if (name == "published") return reference::publishedSky(levels, point, kUp, kUp, Estimator{}.k, Estimator{}.skyWeight);
  std::vector<glm::dvec3> axes;
  for (const glm::vec3& axis : made.directions) axes.emplace_back(axis.x, axis.z, axis.y);  // about +y, side x and front z
  return reference::conesSky(levels, point, axes, taps, glm::dvec3(made.cone));
}

TEST_F(Shade, AgreesWithBruteForceInDouble) {
  const auto corner = [](const glm::dvec3& p) { return std::min(p.y - kGround, p.x - 16.0); };
  const Field scenes[] = {groundCube(sphereOnGround), groundCube(corner)};
  for (const std::string name : {"published", "cones"}) {
    Setting setting;
    setting.estimator = named(name.c_str());
    const SkyEstimator made = skyEstimator(setting.estimator, kSide).value();
    for (const Field& field : scenes) {
      const std::vector<Pixel> pixels = shade(field, groundOnly, setting);
      const std::vector<Field> levels = reference::pyramid(field, made.levels);
      double worst = 0.0, darkest = 1.0;
      for (std::size_t n = 0; n < pixels.size(); n += 3) {
        const glm::dvec2 at = column(n, setting);
        const double expected = referenceSky(name, levels, {at.x, kGround, at.y}, made);
        worst = std::max(worst, std::abs(pixels[n].sky - expected));
        darkest = std::min(darkest, expected);
      }
      // Half floats of up to 64 voxels step by 1/32 at the most, seen through weights that sum to k / 15 per tap; 8-bit filter weights and
      // the result's own half float are smaller.
      EXPECT_LT(worst, 0.01) << name;
      EXPECT_LT(darkest, 0.6) << name << " has something to agree on";
    }
  }
}

TEST_F(Shade, APatternOfPixelsMakesTheMeanOverItsDirections) {
  const auto corner = [](const glm::dvec3& p) { return std::min(p.y - kGround, p.x - 16.0); };
  for (const int taps : {4, 6}) {
    Setting setting;
    setting.left = 24.0;
    setting.right = 24.5;  // the whole pattern within an eighth of a voxel
    setting.estimator = named("calibrated");
    setting.estimator.taps = taps;
    const SkyEstimator made = skyEstimator(setting.estimator, kSide).value();
    for (const Field& field : {groundCube(sphereOnGround), groundCube(corner)}) {
      const std::vector<Pixel> pixels = shade(field, groundOnly, setting);
      for (std::size_t n = 12 * kSide + 12; n < 52 * kSide; n += 97) {
        if (n % kSide < 12 || n % kSide >= 52) continue;  // the picture ends within the window
        const glm::dvec2 at = column(n, setting);
        const double expected = reference::calibratedSky(field, {at.x, kGround, at.y}, kUp, made.taps[0].distance, stepsOf(made), 1);
        EXPECT_NEAR(pixels[n].sky, expected, 0.01) << n;
        EXPECT_LT(expected, 0.9) << "something to agree on";
      }
    }
  }
}

TEST_F(Shade, CalibratedLeavesOpenGroundOpen) {
  Setting setting;
  setting.estimator = named("calibrated");
  for (const Pixel& pixel : shade(groundCube([](const glm::dvec3& p) { return p.y - kGround; }), groundOnly, setting))
    EXPECT_NEAR(pixel.sky, 1.0f, 0.005f);
}

TEST_F(Shade, ACornerDarkensTowardsTheWall) {
  const Field corner = groundCube([](const glm::dvec3& p) { return std::min(p.y - kGround, p.x - 16.0); });
  const std::vector<Pixel> pixels = shade(corner, groundOnly, {});
  // Ground at least as far from the wall as the taps and their filters reach (8 * 1.5 voxels, level 3's kernel 12 more) is open.
  for (std::size_t i = 17; i < 52; ++i) EXPECT_GE(pixels[32 * kSide + i].sky, pixels[32 * kSide + i - 1].sky - 0.004f) << "column " << i;
  EXPECT_LT(pixels[32 * kSide + 16].sky, 0.45f);
  EXPECT_NEAR(pixels[32 * kSide + 42].sky, 1.0f, 0.01f);
}

/// The picture test of contact shadows: fails when they vanish.
TEST_F(Shade, ASphereShadowsTheGroundDarkestBelowItAndLessOutward) {
  const std::vector<Pixel> pixels = shade(groundCube(sphereOnGround), groundOnly, {});
  const auto along = [&](int dx, int dz) {
    std::vector<float> ray;
    for (int step = 0; step < 31; ++step) ray.push_back(pixels[static_cast<std::size_t>((32 + dz * step) * kSide + 32 + dx * step)].sky);
    return ray;
  };
  for (const std::vector<float>& ray : {along(1, 0), along(-1, 0), along(0, 1), along(1, 1), along(-1, 1)}) {
    EXPECT_LT(ray.front(), 0.2f) << "no contact shadow";
    EXPECT_GT(ray.back(), 0.97f);
    for (std::size_t step = 1; step < ray.size(); ++step) EXPECT_GE(ray[step], ray[step - 1] - 0.005f) << "step " << step;
  }
  float darkest = 1.0f;
  for (const Pixel& pixel : pixels) darkest = std::min(darkest, pixel.sky);
  EXPECT_NEAR(darkest, pixels[32 * kSide + 32].sky, 0.005f) << "darkest where the sphere touches";
}

TEST_F(Shade, DoesNotDependOnScaleOrPlace) {
  const Field field = groundCube(sphereOnGround);
  const std::vector<Pixel> expected = shade(field, groundOnly, {});
  for (const double scale : {1e-4, 1e4})
    for (const double shift : {0.0, 1e5}) {
      Setting setting;
      setting.grid.voxelSize = scale;
      setting.grid.origin = glm::dvec3(shift, -shift, shift) * scale;
      setting.eye = setting.grid.origin + scale * glm::dvec3(30, 90, 20);
      const std::vector<Pixel> pixels = shade(field, groundOnly, setting);
      for (std::size_t n = 0; n < pixels.size(); ++n) ASSERT_NEAR(pixels[n].sky, expected[n].sky, 0.002f) << scale << " " << shift;
    }
}

TEST_F(Shade, NoStreaksBeyondTheVolume) {
  // Ground that goes on for half a volume beyond each border: it must keep brightening outward, as if the volume were larger.
  Setting setting;
  setting.left = -32;
  setting.right = 96;
  const auto nearBorder = [](const glm::dvec3& p) {
    return std::min(p.y - kGround, sphereDistance(p - glm::dvec3(48, kGround + 10, 32), 14.0));
  };
  const std::vector<Pixel> pixels = shade(groundCube(nearBorder), groundOnly, setting);
  for (std::size_t j = 0; j < kSide; j += 7)
    for (std::size_t i = 49; i + 1 < kSide; ++i)
      ASSERT_GE(pixels[j * kSide + i + 1].sky, pixels[j * kSide + i].sky - 0.01f) << i << " " << j;
  for (const std::size_t i : {std::size_t{0}, std::size_t{5}, std::size_t{63}}) EXPECT_GT(pixels[32 * kSide + i].sky, 0.98f);
}

TEST_F(Shade, NothingBadComesOfBadInput) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Field empty = groundCube([](const glm::dvec3&) { return 65504.0; });
  const Field inside = groundCube([](const glm::dvec3&) { return -65504.0; });
  const auto bad = [nan](double x, double z) {
    if (x < 8) return Surface{0.0, {0, 1, 0}};
    return Surface{z < 32 ? 30.0 : 64.0, x < 24 ? glm::vec3(0.0f) : x < 40 ? glm::vec3(nan) : glm::vec3(0, 1, 0)};
  };
  for (const Field& field : {empty, inside}) {
    const std::vector<Pixel> pixels = shade(field, bad, {});
    for (std::size_t n = 0; n < pixels.size(); ++n) {
      const bool surface = n % kSide >= 8;
      ASSERT_EQ(pixels[n].sky, surface ? (field.values[0] > 0.0 ? 1.0f : 0.0f) : shared::kNoSurface) << n;
      ASSERT_TRUE(std::isfinite(pixels[n].light.x + pixels[n].light.y + pixels[n].light.z));
    }
  }
}

}  // namespace
}  // namespace overcast::test
