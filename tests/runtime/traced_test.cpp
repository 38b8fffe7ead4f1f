// The traced estimator: rays through fields whose form factors are known, and what becomes of them over the pixels.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "runtime/passes/shade/shade.h"
#include "tests/runtime/shaded_ground.h"

namespace overcast::test {
namespace {

using reference::Field;

constexpr int kSide = kGroundSide;
constexpr glm::dvec3 kUp{0, 1, 0};

class Traced : public ShadedGround {};

TEST_F(Traced, RaysFindTheFormFactorOfASphere) {
  // A sphere of radius R about c takes (R / |c - p|)^2 of the sky of a point p, times the cosine, where all of it is above the horizon.
  // Rays meet it where the field is kRayHit and start kRayStart above the ground.
  Setting setting;
  setting.left = 0.5 * kSide;  // two pixels for each voxel: the mean over a pattern of them is half as wide
  setting.right = kSide;
  setting.estimator = named("traced");
  const std::vector<Pixel> pixels = shade(groundCube(sphereOnGround), groundOnly, setting);
  double squares = 0.0, worst = 0.0;
  int count = 0;
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    const glm::dvec2 at = column(n, setting) - glm::dvec2(0.5 * kSide);
    if (glm::length(at) < 4.0 || glm::length(at) > 30.0) continue;  // nearer, the horizon cuts it
    const double height = kSphereRadius - shared::kRayStart, distance = std::hypot(glm::length(at), height);
    const double expected = 1.0 - std::pow((kSphereRadius + shared::kRayHit) / distance, 2.0) * height / distance;
    worst = std::max(worst, std::abs(pixels[n].sky - expected));
    squares += std::pow(pixels[n].sky - expected, 2.0);
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / count), 0.02);
  EXPECT_LT(worst, 0.08);
}

TEST_F(Traced, RaysAreStoppedByThinSheets) {
  const auto sheet = [](const glm::dvec3& p) { return std::min(p.y - kGround, std::abs(p.x - 40.0) - 0.3); };
  const auto block = [](const glm::dvec3& p) { return std::min(p.y - kGround, std::abs(p.x - 52.0) - 12.3); };
  Setting setting;
  setting.right = 38.0;
  setting.estimator = named("traced");
  const std::vector<Pixel> thin = shade(groundCube(sheet), groundOnly, setting), thick = shade(groundCube(block), groundOnly, setting);
  double byThin = 0.0, byThick = 0.0;
  for (std::size_t n = 0; n < thin.size(); ++n) {
    byThin += (1.0 - thin[n].sky) / static_cast<double>(thin.size());
    byThick += (1.0 - thick[n].sky) / static_cast<double>(thick.size());
  }
  EXPECT_GT(byThick, 0.15);
  EXPECT_GT(byThin, 0.8 * byThick) << "0.6 voxels hold back what 24 do, but for cones along them: " << byThin << " of " << byThick;
}

TEST_F(Traced, RaysFindTheSkyBesideALowStep) {
  // A step of height h at a distance x hides (1 - cos b) / 2 of the sky, tan b = h / x. The voxels round its edge off, which
  // for a step that is no higher than a voxel leaves 0.05; rays that start half a voxel above the ground err by 0.08 there.
  constexpr double kEdge = 40.0;
  for (const auto& [height, error] : {std::pair{1.0, 0.06}, {2.0, 0.03}}) {
    const auto step = [&](const glm::dvec3& p) { return std::min(p.y - kGround, std::max(kEdge - p.x, p.y - kGround - height)); };
    Setting setting;
    setting.left = 32.0;
    setting.right = kEdge;
    setting.estimator = named("traced");
    const std::vector<Pixel> pixels = shade(groundCube(step), groundOnly, setting);
    double squares = 0.0;
    for (std::size_t n = 0; n < pixels.size(); ++n) {
      const double away = kEdge - column(n, setting).x;
      squares += std::pow(pixels[n].sky - 0.5 * (1.0 + std::cos(std::atan(height / away))), 2.0);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(pixels.size())), error) << height;
  }
}

TEST_F(Traced, ContactShadowsAreNotWashedOut) {
  // As above, of a step of four voxels, with pixels as large as they are: what it hides changes within fewer than a window of pixels.
  // Their mean alone errs by 0.06.
  constexpr double kEdge = 32.0, kHeight = 4.0;
  const auto step = [](const glm::dvec3& p) { return std::min(p.y - kGround, std::max(kEdge - p.x, p.y - kGround - kHeight)); };
  const auto ground = [](double x, double) { return Surface{x < kEdge ? kGround : 0.0, {0.0f, 1.0f, 0.0f}}; };
  Setting setting;
  setting.estimator = named("traced");
  const std::vector<Pixel> pixels = shade(groundCube(step), ground, setting);
  double squares = 0.0;
  int count = 0;
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    const double away = kEdge - column(n, setting).x;
    if (away < 0.0 || away > 3.0) continue;
    squares += std::pow(pixels[n].sky - 0.5 * (1.0 + std::cos(std::atan(kHeight / away))), 2.0);
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / count), 0.04);
}

TEST_F(Traced, RaysDoNotStartBeyondWhatStandsOverTheGround) {
  // A plate over the ground: lower than the rays could start, and not to be left behind.
  for (const double gap : {0.05, 0.2, 0.4}) {
    const auto plate = [&](const glm::dvec3& p) { return std::min(p.y - kGround, std::abs(p.y - kGround - gap - 1.0) - 1.0); };
    Setting setting;
    setting.left = 8.0;
    setting.right = 56.0;
    setting.estimator = named("traced");
    for (const Pixel& pixel : shade(groundCube(plate), groundOnly, setting)) ASSERT_LT(pixel.sky, 0.05f) << gap;
  }
}

TEST_F(Traced, RaysStartAboveAFieldThatCoversTheMesh) {
  Setting setting;
  setting.estimator = named("traced");
  for (const double above : {0.3, 0.9, 1.5})
    for (const Pixel& pixel : shade(groundCube([&](const glm::dvec3& p) { return p.y - kGround - above; }), groundOnly, setting))
      ASSERT_NEAR(pixel.sky, 1.0f, 0.02f) << above;
}

TEST_F(Traced, PixelsWithoutNeighboursTakeMoreRays) {
  // Over a plane a surface tilted by t sees (1 + cos t) / 2 of the sky, whichever way it is turned: here every pixel another.
  Setting setting;
  setting.left = 28.0;
  setting.right = 36.0;
  setting.estimator = named("traced");
  std::mt19937 random(3);
  std::uniform_real_distribution<double> turn(0.0, 6.28318530717958648);
  const double tilt = 0.9;
  const auto turned = [&](double, double) {
    const double angle = turn(random);
    return Surface{kGround + 1.5, glm::vec3(std::sin(tilt) * std::cos(angle), std::cos(tilt), std::sin(tilt) * std::sin(angle))};
  };
  const std::vector<Pixel> pixels = shade(groundCube([](const glm::dvec3& p) { return p.y - kGround; }), turned, setting);
  double squares = 0.0;
  for (const Pixel& pixel : pixels) squares += std::pow(pixel.sky - 0.5 * (1.0 + std::cos(tilt)), 2.0);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(pixels.size())), 0.03);
}

TEST_F(Traced, RaysFindNoWayOutOfAClosedRoom) {
  // Along the crease of floor and wall rays creep, in more steps than they have.
  const auto room = [](const glm::dvec3& p) {
    const glm::dvec3 half(28.0, 14.0, 28.0), away = half - glm::abs(p - glm::dvec3(32.0, kGround + half.y, 32.0));
    return std::min({away.x, away.y, away.z});
  };
  Setting setting;
  setting.left = 3.0;  // beyond the wall, whose face is at 4
  setting.right = 11.0;
  setting.estimator = named("traced");
  const auto floor = [](double x, double z) { return Surface{x > 4.0 && z > 4.0 ? kGround : 0.0, {0.0f, 1.0f, 0.0f}}; };
  const std::vector<Pixel> pixels = shade(groundCube(room), floor, setting);
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    const glm::dvec2 at = column(n, setting);
    if (at.x <= 4.0 || at.y <= 4.0) continue;
    EXPECT_EQ(pixels[n].sky, 0.0f) << at.x << " " << at.y;
  }
}

TEST(TracedFormulas, RaysPassThroughBallsAndNoFurther) {
  // Against small steps along the ray: what is clear ends where they leave the ball, or where it ended before if that is outside.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  int passed = 0;
  for (int n = 0; n < 500; ++n) {
    const double height = std::exp2(1.0 + 4.0 * chance(random)), radius = 1.5 * height * chance(random), rise = chance(random);
    const double start = 2.0 * height * chance(random);
    const auto inside = [&](double t) { return std::hypot(t * std::sqrt(1.0 - rise * rise), t * rise - height) < radius; };
    double expected = start;
    while (inside(expected)) expected += 1e-3 * height;
    passed += expected > start;
    const auto at = [](double value) { return static_cast<float>(value); };
    EXPECT_NEAR(shared::throughBall(at(start), at(rise), at(height), at(radius)), expected, 2e-3 * height) << start << " " << rise;
  }
  EXPECT_GT(passed, 100);
}

TEST_F(Traced, RaysLeaveOpenGroundOpen) {
  Setting setting;
  setting.estimator = named("traced");
  for (const Pixel& pixel : shade(groundCube([](const glm::dvec3& p) { return p.y - kGround; }), groundOnly, setting))
    EXPECT_NEAR(pixel.sky, 1.0f, 0.005f);
}

}  // namespace
}  // namespace overcast::test
