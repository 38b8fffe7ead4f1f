// Techniques to compare with: formulas against closed forms, then their passes on the device against rays in double and analytic scenes.
#include "runtime/baseline.h"

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "runtime/passes/cone_tracing/cone_tracing.h"
#include "runtime/passes/denoise/denoise.h"
#include "runtime/passes/denoise/denoise_pass.h"
#include "runtime/passes/rays/rays.h"
#include "tests/runtime/ground.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

using test::groundOnly;
using test::kGround;
using test::kGroundSide;
using test::kSphereRadius;
using test::Pixel;

constexpr double kSize = kGroundSide;

/// Cosine-weighted visibility above a point whose normal is +y, by 4,000 rays in double; `clear` says whether a ray leaves the scene.
template <class Clear>
double tracedSky(const glm::dvec3& from, const Clear& clear) {
  int open = 0;
  constexpr int kAround = 80, kOut = 50;
  for (int i = 0; i < kOut; ++i)
    for (int j = 0; j < kAround; ++j) {
      const double radius = std::sqrt((i + 0.5) / kOut), angle = 2.0 * std::numbers::pi * (j + 0.5 * (i % 2)) / kAround;
      const glm::dvec3 way(radius * std::cos(angle), std::sqrt(1.0 - radius * radius), radius * std::sin(angle));
      open += clear(from, way) ? 1 : 0;
    }
  return static_cast<double>(open) / (kAround * kOut);
}

/// What a sphere on the ground leaves of its sky at `distance` from where it touches: its form factor is exact as it stands clear of the
/// horizon.
double skyBesideSphere(double distance) {
  const double squared = distance * distance + kSphereRadius * kSphereRadius;
  return 1.0 - kSphereRadius * kSphereRadius * kSphereRadius / (squared * std::sqrt(squared));
}

/// Whether a ray passes the wall x < 16, which ends with the volume.
bool passesWall(const glm::dvec3& from, const glm::dvec3& way) {
  if (way.x >= 0.0) return true;
  const glm::dvec3 hit = from + way * ((from.x - 16.0) / -way.x);
  return hit.y > kSize || hit.z < 0.0 || hit.z > kSize;
}

double wallAndGround(const glm::dvec3& p) {
  return std::min(p.y - kGround, p.x - 16.0);
}

class Baselines : public test::DeviceTest {
 protected:
  std::vector<Pixel> light(Technique technique, const reference::Field& field, float constant = 0.0f) {
    const test::GroundView from;
    const ScreenView view{test::clipFromRelative(from), from.eye, {0.5f, 0.25f, 1.0f}};
    GpuImage volume = test::uploadField(device, field);
    GeometryImages images = test::uploadGround(device, groundOnly, from);
    GpuImage out = makeLightImage(device, images).value();
    DenoisePass denoise = makeDenoisePass(device, images, out).value();
    const GpuImage& raw = denoises(technique) ? denoise.raw : out;
    Baseline baseline = makeBaseline(device, TechniqueSettings{technique, constant}, {images, raw, volume}).value();
    const Result<Done> done = runCommands(device, [&](VkCommandBuffer commands) {
      recordBaseline(commands, baseline, from.grid, view);
      if (denoises(technique)) recordDenoise(commands, denoise, view);
    });
    EXPECT_TRUE(done.ok());
    std::vector<Pixel> pixels = test::readPixels(device, out);
    destroyBaseline(device, baseline);
    destroyDenoisePass(device, denoise);
    destroyImage(device, out);
    destroyGeometryImages(device, images);
    destroyImage(device, volume);
    return pixels;
  }

  /// Root mean square difference to `sky` at ground points for which it is not negative.
  template <class Sky>
  static double errorTo(const std::vector<Pixel>& pixels, const Sky& sky) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t n = 0; n < pixels.size(); ++n) {
      const glm::dvec2 at = test::column(n, {});
      const double expected = sky(glm::dvec3(at.x, kGround, at.y));
      if (expected < 0.0) continue;
      sum += (pixels[n].sky - expected) * (pixels[n].sky - expected);
      ++count;
    }
    return std::sqrt(sum / std::max(count, 1));
  }

  /// Sky at a point of the ground, -1 nearer than `nearest` to where the sphere touches.
  template <int nearest>
  static double besideSphere(const glm::dvec3& p) {
    const double distance = glm::length(glm::dvec2(p.x - 32.0, p.z - 32.0));
    return distance > nearest ? skyBesideSphere(distance) : -1.0;
  }
  static double besideWall(const glm::dvec3& p) { return p.x > 17.0 ? tracedSky(p, passesWall) : -1.0; }
};

TEST(ScreenFormulas, FramesAreOrthonormal) {
  std::mt19937 random(1);
  std::normal_distribution<float> any;
  for (int i = 0; i < 1000; ++i) {
    glm::vec3 normal = glm::normalize(glm::vec3(any(random), any(random), any(random)));
    if (i < 3) normal = glm::normalize(glm::vec3(0.015f * static_cast<float>(i), -1.0f, 0.0f));
    const glm::mat3 frame = shared::frameAbout(normal);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) ASSERT_NEAR(glm::dot(frame[a], frame[b]), a == b ? 1.0f : 0.0f, 2e-3f) << i;
    ASSERT_EQ(frame[2], normal);
  }
}

TEST(RayFormulas, DirectionsAreSpreadByTheCosine) {
  for (const int count : {16, 64}) {
    glm::dvec3 mean(0.0), square(0.0);
    double xy = 0.0;
    for (int place = 0; place < shared::kPatternSize; ++place)
      for (int ray = 0; ray < count; ++ray) {
        const glm::dvec3 way = shared::rayDirection(ray, count, place);
        ASSERT_NEAR(glm::length(way), 1.0, 1e-6);
        ASSERT_GT(way.z, 0.0);
        mean += way / (16.0 * count);
        square += way * way / (16.0 * count);
        xy += way.x * way.y / (16.0 * count);
      }
    // Moments of the density cos / pi over the hemisphere.
    EXPECT_NEAR(glm::length(mean - glm::dvec3(0, 0, 2.0 / 3.0)), 0.0, 2e-3);
    EXPECT_NEAR(glm::length(square - glm::dvec3(0.25, 0.25, 0.5)), 0.0, 2e-3);
    EXPECT_NEAR(xy, 0.0, 2e-3);
  }
}

TEST(RayFormulas, ReachIsWhereTheVolumeEnds) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(-10.0, 50.0), way(-1.0, 1.0);
  const glm::dvec3 size(40, 24, 16);
  const auto inside = [&](const glm::dvec3& p) {
    return glm::all(glm::greaterThanEqual(p, glm::dvec3(0.0))) && glm::all(glm::lessThanEqual(p, size));
  };
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 p(place(random), place(random), place(random));
    const glm::dvec3 d = i < 6 ? glm::dvec3(i % 3 == 0, i % 3 == 1, i % 3 == 2) * (i < 3 ? 1.0 : -1.0)
                               : glm::normalize(glm::dvec3(way(random), way(random), way(random)));
    const double reach = shared::reachInVolume(p, d, size);
    for (double t = reach + 0.01; t < reach + 100.0; t += 0.5) ASSERT_FALSE(inside(p + t * d)) << i << " at " << t;
    if (inside(p) && reach > 0.02) {
      ASSERT_TRUE(inside(p + (reach - 0.01) * d)) << i;
    }
  }
}

TEST(ConeTracingFormulas, ConesShareTheHemisphereByTheCosine) {
  EXPECT_NEAR(1.0 - 1.0 / std::sqrt(1.0 + std::pow(shared::kTracedConeTangent, 2.0)), 1.0 / 9.0, 1e-6) << "solid angle 2 pi / 9";
  double whole = 0.0;
  for (int cone = 0; cone < shared::kTracedCones; ++cone) {
    const glm::dvec3 axis = shared::tracedConeAxis(cone);
    EXPECT_NEAR(glm::length(axis), 1.0, 1e-6);
    const bool upper = axis.z > 2.0 / 3.0;
    EXPECT_NEAR(shared::tracedConeWeight(cone), upper ? (1.0 - 4.0 / 9.0) / 3.0 : 4.0 / 9.0 / 6.0, 1e-6);
    whole += shared::tracedConeWeight(cone);
    for (int other = 0; other < cone; ++other)
      EXPECT_LT(glm::dot(axis, glm::dvec3(shared::tracedConeAxis(other))), 0.8) << "cones " << cone << " and " << other;
  }
  EXPECT_NEAR(whole, 1.0, 1e-6);
  EXPECT_NEAR(shared::kTracedConeFirst * std::pow(shared::tracedConeRatio(100.0f), shared::kTracedConeSteps - 1), 100.0, 1e-3);
}

/// The nine cones in double over a field in closed form.
double conesInDouble(const glm::dvec3& ground, const std::function<double(const glm::dvec3&)>& phi) {
  const double tangent = std::tan(std::acos(8.0 / 9.0));
  double sky = 0.0;
  for (int cone = 0; cone < 9; ++cone) {
    const double height = cone < 3 ? 5.0 / 6.0 : 1.0 / 3.0, flat = std::sqrt(1.0 - height * height);
    const double angle = std::numbers::pi * (cone < 3 ? 2.0 * cone / 3.0 + 1.0 / 6.0 : cone / 3.0);
    // Over ground the frame's axes are those of the world, its third being y.
    const glm::dvec3 axis(flat * std::cos(angle), height, flat * std::sin(angle));
    double clear = 1.0;
    for (int step = 0; step < 10; ++step) {
      const double t = std::pow(kSize, step / 9.0);
      const glm::dvec3 at = ground + glm::dvec3(0, 0.5, 0) + t * axis;
      const glm::dvec3 inside = glm::clamp(at, 0.5, kSize - 0.5);
      clear = std::min(clear, std::clamp((phi(inside) + glm::distance(at, inside)) / (t * std::min(tangent, height)), 0.0, 1.0));
    }
    sky += clear * (cone < 3 ? 5.0 / 27.0 : 2.0 / 27.0);
  }
  return sky;
}

TEST(DenoiseFormulas, EveryWindowHoldsEachPlaceOfThePatternOnce) {
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      std::array<float, shared::kPatternSize> sums{};
      for (int dy = -shared::kDenoiseReach; dy <= shared::kDenoiseReach; ++dy)
        for (int dx = -shared::kDenoiseReach; dx <= shared::kDenoiseReach; ++dx)
          sums.at(static_cast<std::size_t>(shared::patternPlace({x + dx + 8, y + dy + 8}))) += shared::windowWeight(dx, dy);
      for (const float sum : sums) EXPECT_EQ(sum, 1.0f);
    }
}

TEST(DenoiseFormulas, ThreadsOfAGroupTakeAllItsPixelsPlaceByPlace) {
  std::array<int, 64> taken{};
  for (int index = 0; index < 64; ++index) {
    const glm::ivec2 pixel = shared::pixelInTurn(index);
    ASSERT_TRUE(pixel.x >= 0 && pixel.x < 8 && pixel.y >= 0 && pixel.y < 8) << index;
    EXPECT_EQ(shared::patternPlace(pixel), index / 4);
    ++taken.at(static_cast<std::size_t>(8 * pixel.y + pixel.x));
  }
  for (const int count : taken) EXPECT_EQ(count, 1);
}

/// How often the window about a pixel holds each place of the wide pattern, as wide as steps `reach` and all before leave it.
std::array<float, shared::kWidePatternSize> placesWithin(const glm::ivec2& pixel, int reach) {
  std::array<float, shared::kWidePatternSize> sums{};
  if (reach == 1) {
    for (int dy = -shared::kDenoiseReach; dy <= shared::kDenoiseReach; ++dy)
      for (int dx = -shared::kDenoiseReach; dx <= shared::kDenoiseReach; ++dx)
        sums.at(static_cast<std::size_t>(shared::widePatternPlace(pixel + glm::ivec2(dx, dy)))) += shared::windowWeight(dx, dy);
    return sums;
  }
  for (int corner = 0; corner < 4; ++corner) {
    const auto part = placesWithin(pixel + reach * (2 * glm::ivec2(corner & 1, corner >> 1) - 1), reach / 2);
    for (std::size_t place = 0; place < sums.size(); ++place) sums.at(place) += part.at(place);
  }
  return sums;
}

TEST(DenoiseFormulas, WidenedWindowsHoldEachPlaceOfTheWidePatternOnce) {
  for (const glm::ivec2 pixel : {glm::ivec2(16, 16), glm::ivec2(21, 18), glm::ivec2(27, 31)}) {
    for (const float sum : placesWithin(pixel, 4)) EXPECT_EQ(sum, 1.0f);
    for (const float sum : placesWithin(pixel, 2)) EXPECT_LE(sum, 1.0f) << "none twice";
  }
}

TEST(DenoiseFormulas, WindowsWidenWhereLightChangesSlowlyAndByNoMoreThanNoise) {
  for (const int reach : {2, 4}) {
    const float near = 1.0f / (3.0f * static_cast<float>(reach * reach));  // and half of the rays meet something
    EXPECT_EQ(shared::wideShare(0.5f, 0.5f, 0.5f * near, reach, 8.0f, shared::kManySamples), 0.0f) << "what stands near";
    EXPECT_EQ(shared::wideShare(0.5f, 0.5f, 0.25f * near, reach, 8.0f, shared::kManySamples), 1.0f);
    EXPECT_EQ(shared::wideShare(0.5f, 0.5f, 0.0f, reach, 8.0f, shared::kManySamples), 1.0f);
    EXPECT_EQ(shared::wideShare(1.0f, 1.0f, 0.0f, reach, 8.0f, shared::kManySamples), 0.0f) << "nothing is hidden, nothing to find out";
    EXPECT_EQ(shared::wideShare(0.5f, 0.4f, 0.0f, reach, 8.0f, shared::kManySamples), 0.0f) << "an edge";
    EXPECT_GT(shared::wideShare(0.5f, 0.48f, 0.0f, 4, 4.0f, shared::kManySamples),
              shared::wideShare(0.5f, 0.48f, 0.0f, 4, 8.0f, shared::kManySamples))
        << "fewer rays err more";
    EXPECT_EQ(shared::wideShare(0.0f, 0.0f, 0.0f, reach, 8.0f, shared::kManySamples), 1.0f) << "in the dark";
    EXPECT_EQ(shared::wideShare(0.025f, 0.025f, 2.0f * near, reach, 8.0f, shared::kManySamples), 1.0f) << "little light in a corner";
    EXPECT_EQ(shared::wideShare(0.0f, 0.0f, 5.0f * near, reach, 8.0f, shared::kManySamples), 0.0f) << "a contact shadow";
  }
}

TEST(DenoiseFormulas, NeighboursCountInThePixelsPlaneOnly) {
  const glm::vec3 up(0, 1, 0);
  const glm::vec4 level = shared::kManySamples;
  EXPECT_NEAR(shared::surfaceWeight({1e-4f, 0, 0}, up, up, level), 1.0f, 1e-6f);
  EXPECT_NEAR(shared::surfaceWeight({1e4f, 0, 0}, up, up, level), 1.0f, 1e-6f) << "at any scale";
  EXPECT_EQ(shared::surfaceWeight({1, 0.25f, 0}, up, up, level), 0.0f);
  EXPECT_EQ(shared::surfaceWeight({1, -0.25f, 0}, up, up, level), 0.0f);
  EXPECT_EQ(shared::surfaceWeight({1, 0, 0}, up, {1, 0, 0}, level), 0.0f);
  // A bend of 30 degrees; an edge, and what stands before or behind.
  const glm::vec3 bent(0.5f, 0.8660254f, 0);
  EXPECT_EQ(shared::surfaceWeight({1, -0.25f, 0}, up, bent, level), 0.0f);
  EXPECT_GT(shared::surfaceWeight({1, -0.25f, 0}, up, bent, shared::kFewSamples), 0.5f);
  EXPECT_EQ(shared::surfaceWeight({1, 0, 0}, up, {1, 0, 0}, shared::kFewSamples), 0.0f);
  EXPECT_EQ(shared::surfaceWeight({1, 0.6f, 0}, up, up, shared::kFewSamples), 0.0f);
}

TEST(RayFormulas, RaysLeaveCreasesAndAreStoppedByWalls) {
  EXPECT_FALSE(shared::rayHits(1.0f, 2.0f, 0.1f, 0.05f)) << "it leads away";
  EXPECT_TRUE(shared::rayHits(1.0f, 2.0f, 0.1f, 0.2f));
  EXPECT_TRUE(shared::rayHits(3.0f, 2.0f, 0.1f, 0.05f)) << "further off all is a wall";
  EXPECT_FALSE(shared::rayHits(3.0f, 0.15f, 0.15f, 0.2f)) << "its own ground";
  EXPECT_EQ(shared::rayLift(1.0f, 0.5f), 0.0f) << "nothing covers it";
  EXPECT_GT(shared::rayLift(0.25f, -1.0f), 1.0f);
}

TEST(DenoiseFormulas, PixelsFollowTheirGuideAsFarAsTheirWindowDoes) {
  EXPECT_NEAR(shared::guidedShare(0.05f, 0.1f), 0.5f, 0.01f);
  EXPECT_NEAR(shared::guidedShare(0.1f, 0.1f), 1.0f, 0.01f);
  EXPECT_EQ(shared::guidedShare(0.3f, 0.1f), 1.0f) << "no further";
  EXPECT_EQ(shared::guidedShare(-0.1f, 0.1f), 0.0f) << "nor against it";
  EXPECT_EQ(shared::guidedShare(0.0f, 0.0f), 0.0f);
}

TEST(DenoiseFormulas, PixelsTakeTheSetsThatTheirNeighboursCannotGive) {
  EXPECT_EQ(shared::setsOfPixel(16.0f), 1) << "all share its surface";
  EXPECT_EQ(shared::setsOfPixel(8.0f), 2);
  EXPECT_EQ(shared::setsOfPixel(1.0f), shared::kMostSets) << "none does";
}

TEST_F(Baselines, ConstantIsTheSameEverywhere) {
  for (const Pixel& pixel : light(Technique::constant, test::groundCube(test::sphereOnGround), 0.25f)) {
    EXPECT_EQ(pixel.sky, 0.25f);
    EXPECT_EQ(pixel.light, 0.25f * glm::vec3(0.5f, 0.25f, 1.0f));
  }
}

TEST_F(Baselines, OpenGroundSeesTheWholeSky) {
  const reference::Field open = test::groundCube([](const glm::dvec3& p) { return p.y - kGround; });
  for (const Technique technique : {Technique::coneTracing, Technique::rays16, Technique::rays64})
    for (const Pixel& pixel : light(technique, open)) {
      ASSERT_EQ(pixel.sky, 1.0f) << nameOf(technique);
      ASSERT_EQ(pixel.light, glm::vec3(0.5f, 0.25f, 1.0f));
    }
}

TEST_F(Baselines, RaysFindTheFormFactorOfASphere) {
  const reference::Field field = test::groundCube(test::sphereOnGround);
  for (const Technique technique : {Technique::rays16, Technique::rays64}) {
    const std::vector<Pixel> pixels = light(technique, field);
    // The sphere a quarter of a voxel larger, kRayHit, hides up to 0.05 more of the sky where it touches, and little far from there.
    EXPECT_LT(errorTo(pixels, besideSphere<4>), 0.020) << nameOf(technique);
    EXPECT_LT(errorTo(pixels, besideSphere<14>), 0.010) << nameOf(technique);
  }
}

TEST_F(Baselines, ConesAreThoseInDouble) {
  const auto sphere = [](const glm::dvec3& p) { return conesInDouble(p, test::sphereOnGround); };
  EXPECT_LT(errorTo(light(Technique::coneTracing, test::groundCube(test::sphereOnGround)), sphere), 0.01);
  const auto wall = [](const glm::dvec3& p) { return conesInDouble(p, wallAndGround); };
  EXPECT_LT(errorTo(light(Technique::coneTracing, test::groundCube(wallAndGround)), wall), 0.01);
}

TEST_F(Baselines, ConesDarkenTheGroundUnderASphere) {
  const std::vector<Pixel> pixels = light(Technique::coneTracing, test::groundCube(test::sphereOnGround));
  for (std::size_t step = 1; step < 31; ++step) EXPECT_GE(pixels[32 * 64 + 32 + step].sky, pixels[32 * 64 + 31 + step].sky - 0.03f) << step;
  EXPECT_LT(pixels[32 * 64 + 32].sky, 0.05f);
  EXPECT_GT(pixels[0].sky, 0.9f);
}

TEST_F(Baselines, RaysFindTheSkyBesideAWall) {
  const reference::Field field = test::groundCube(wallAndGround);
  EXPECT_LT(errorTo(light(Technique::rays16, field), besideWall), 0.015);
  EXPECT_LT(errorTo(light(Technique::rays64, field), besideWall), 0.010);
}

}  // namespace
}  // namespace overcast
