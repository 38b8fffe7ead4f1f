// Caps: areas, centroids and cosine integrals against numerical integration and closed forms, then the same on the device.
#include "runtime/passes/aperture/caps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/bench/cap_pairs.h"
#include "tests/reference/caps.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

using shared::CapPair;

constexpr std::array kKinds{PairKind::generic,       PairKind::small,  PairKind::sun,  PairKind::tangent,
                            PairKind::hemispherical, PairKind::nested, PairKind::apart};
constexpr float kPi = std::numbers::pi_v<float>;

float smaller(const CapPair& pair) {
  return std::min(pair.first.w, pair.second.w);
}

double truth(const CapPair& pair) {
  return static_cast<double>(reference::capIntersection(pair.first.w, pair.second.w, pair.normal.w));
}

/// Error of a value relative to the smaller cap; not a number where the value is none.
double errorOf(float value, double expected, const CapPair& pair) {
  return std::abs(static_cast<double>(value) - expected) / static_cast<double>(reference::capArea(smaller(pair)));
}

TEST(CapReference, AgreesWithTheClosedFormsOfSpecialCaps) {
  // Of two hemispheres a lune of angle pi - d is left; half of a cap whose axis lies on a great circle.
  for (const long double d : {0.1L, 1.0L, 2.0L, 3.0L})
    EXPECT_NEAR(
        static_cast<double>(reference::capIntersection(std::numbers::pi_v<long double> / 2, std::numbers::pi_v<long double> / 2, d)),
        static_cast<double>(2 * (std::numbers::pi_v<long double> - d)), 1e-12);
  for (const long double r : {1e-4L, 0.3L, 1.5L}) {
    const long double right = std::numbers::pi_v<long double> / 2;
    EXPECT_NEAR(static_cast<double>(reference::capIntersection(right, r, right) / reference::capArea(r)), 0.5, 1e-12);
  }
  EXPECT_NEAR(static_cast<double>(reference::capIntersection(0.5L, 0.4L, 0.6L)), 0.1394, 1e-4) << "Monte Carlo says 0.1396 (DESIGN 6)";
}

TEST(CapReference, AreaAgreesWithCountingDirections) {
  for (const CapPair& pair : makePairs(PairKind::generic, 20, 5)) {
    const reference::CapMoments moments =
        reference::capMoments(glm::dvec3(pair.normal), glm::dvec3(pair.first), pair.first.w, glm::dvec3(pair.second), pair.second.w, 500);
    EXPECT_LT(errorOf(static_cast<float>(moments.area), truth(pair), pair), 1e-3);
  }
}

TEST(Caps, IntersectWithinTheStatedError) {
  for (const PairKind kind : kKinds) {
    double worst = 0.0;
    for (const CapPair& pair : makePairs(kind, 2000, 1)) {
      const float area = shared::capIntersection(pair.first.w, pair.second.w, pair.normal.w);
      ASSERT_TRUE(std::isfinite(area)) << pair.first.w << " " << pair.second.w << " " << pair.normal.w;
      worst = std::max(worst, errorOf(area, truth(pair), pair));
      worst = std::max(worst, errorOf(shared::capIntersection(pair.second.w, pair.first.w, pair.normal.w), truth(pair), pair));
    }
    EXPECT_LT(worst, 1e-5) << "kind " << static_cast<int>(kind);
  }
}

TEST(Caps, StayFiniteAtEveryBorder) {
  const std::array radii{0.0f, 1e-30f, 1e-10f, 1e-4f, 0.00465f, 0.5f, 1.0f, 1.5707962f, shared::kCapRightAngle};
  std::vector<float> distances{0.0f, 1e-30f, 1e-7f, kPi, 3.1415925f};
  for (const float a : radii)
    for (const float b : radii)
      for (const float d : {a + b, std::abs(a - b), std::nextafter(a + b, 0.0f), std::nextafter(std::abs(a - b), 4.0f)})
        distances.push_back(std::min(d, kPi));
  for (const float a : radii)
    for (const float b : radii)
      for (const float d : distances) {
        const double most = static_cast<double>(reference::capArea(std::min(a, b))) * (1.0 + 1e-6);
        for (const int method : {shared::kMethodStable, shared::kMethodOurs}) {
          const float area = shared::evaluatePair(method, {{0, 0, 1, d}, {0, 0, 1, a}, {0, 0, 1, b}});
          ASSERT_GE(area, 0.0f) << a << " " << b << " " << d;
          ASSERT_LE(static_cast<double>(area), most * (method == shared::kMethodOurs ? 1.0001 : 1.0)) << a << " " << b << " " << d;
        }
      }
}

TEST(Caps, FastBeatsSmoothstepOnEveryKind) {
  for (const PairKind kind : {PairKind::generic, PairKind::small, PairKind::sun, PairKind::tangent, PairKind::hemispherical}) {
    double ours = 0.0, ourSquares = 0.0, theirs = 0.0, theirSquares = 0.0;
    for (const CapPair& pair : makePairs(kind, 1500, 2)) {
      const double fast = errorOf(shared::capIntersectionFast(pair.first.w, pair.second.w, pair.normal.w), truth(pair), pair);
      const double smooth = errorOf(shared::capIntersectionSmoothstep(pair.first.w, pair.second.w, pair.normal.w), truth(pair), pair);
      ours = std::max(ours, fast);
      theirs = std::max(theirs, smooth);
      ourSquares += fast * fast;
      theirSquares += smooth * smooth;
    }
    EXPECT_LT(ours, 0.014) << "kind " << static_cast<int>(kind);
    EXPECT_LT(ours, 0.5 * theirs) << "kind " << static_cast<int>(kind);
    EXPECT_LT(ourSquares, 0.25 * theirSquares) << "kind " << static_cast<int>(kind);
  }
}

TEST(Caps, FastFallsWithDistanceAndHasBothEnds) {
  for (const float a : {0.001f, 0.2f, 0.9f, 1.57f})
    for (const float b : {0.001f, 0.25f, 1.0f, 1.57f}) {
      float before = shared::capIntersectionFast(a, b, std::abs(a - b));
      EXPECT_NEAR(before / shared::capArea(std::min(a, b)), 1.0f, 1e-4f);
      for (int step = 1; step <= 1000; ++step) {
        const float d = std::abs(a - b) + (a + b - std::abs(a - b)) * 0.001f * static_cast<float>(step);
        const float area = shared::capIntersectionFast(a, b, d);
        ASSERT_LE(area, before * (1.0f + 1e-6f)) << a << " " << b << " " << d;
        before = area;
      }
      EXPECT_EQ(shared::capIntersectionFast(a, b, a + b + 1e-3f), 0.0f);
    }
}

TEST(Caps, SmoothstepIsThePapers) {
  EXPECT_NEAR(shared::capIntersectionSmoothstep(0.5f, 0.4f, 0.6f), 0.1569f, 5e-5f) << "DESIGN 6";
  EXPECT_EQ(shared::capIntersectionSmoothstep(0.5f, 0.4f, 0.91f), 0.0f);
}

TEST(Caps, CentroidIsCloserThanTheMeanOfTheAxes) {
  double worst = 0.0, ours = 0.0, theirs = 0.0;
  for (const PairKind kind : {PairKind::generic, PairKind::sun, PairKind::nested, PairKind::hemispherical})
    for (const CapPair& pair : makePairs(kind, 40, 3)) {
      const glm::dvec3 a(pair.first), b(pair.second);
      const reference::CapMoments moments = reference::capMoments(glm::dvec3(pair.normal), a, pair.first.w, b, pair.second.w, 200);
      if (moments.area < 0.01 * static_cast<double>(reference::capArea(smaller(pair)))) continue;
      const glm::dvec3 centre = glm::normalize(moments.moment);
      const double off =
          glm::length(glm::dvec3(shared::capCentroid(glm::vec3(a), pair.first.w, glm::vec3(b), pair.second.w, pair.normal.w)) - centre);
      worst = std::max(worst, off / static_cast<double>(smaller(pair)));
      ours += off * off;
      theirs += glm::dot(glm::normalize(a + b) - centre, glm::normalize(a + b) - centre);
    }
  EXPECT_LT(worst, 0.09) << "of the smaller radius";
  EXPECT_LT(ours, 0.003 * theirs);
}

/// Unit normals within reach of caps: half of them such that the horizon cuts the smaller cap.
glm::vec3 lowNormal(const CapPair& pair, std::mt19937& random) {
  const glm::dvec3 axis(pair.first.w < pair.second.w ? pair.first : pair.second);
  const glm::dvec3 side = glm::normalize(glm::cross(axis, glm::dvec3(pair.normal)));
  const double angle =
      0.5 * std::numbers::pi + static_cast<double>(smaller(pair)) * (2.0 * (static_cast<double>(random()) / 4294967296.0) - 1.2);
  return glm::vec3(std::cos(angle) * axis + std::sin(angle) * side);
}

TEST(Caps, CosineIntegralIsWithinTheStatedError) {
  std::mt19937 random(4);
  double worst = 0.0;
  for (const PairKind kind : kKinds)
    for (CapPair pair : makePairs(kind, 40, 6)) {
      if (random() % 2) pair.normal = glm::vec4(lowNormal(pair, random), pair.normal.w);
      const float d = shared::capDistance(glm::vec3(pair.first), glm::vec3(pair.second));
      pair.normal.w = d;
      const float cosine = shared::evaluatePair(shared::kMethodCosine, pair);
      ASSERT_TRUE(std::isfinite(cosine));
      const reference::CapMoments moments =
          reference::capMoments(glm::normalize(glm::dvec3(pair.normal)), glm::normalize(glm::dvec3(pair.first)), pair.first.w,
                                glm::normalize(glm::dvec3(pair.second)), pair.second.w, 500);
      worst = std::max(worst, errorOf(cosine, moments.cosine, pair));
    }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, 2e-3);
}

TEST(Caps, CosineIntegralsHaveTheirClosedForms) {
  const glm::vec3 up(0, 0, 1);
  EXPECT_NEAR(shared::capCosine(up, up, shared::kCapRightAngle), kPi, 1e-5f);
  EXPECT_EQ(shared::capCosine(up, -up, 1.0f), 0.0f);
  for (const float r : {0.01f, 0.4f, 1.2f})
    for (const float angle : {0.0f, 0.3f}) {
      const glm::vec3 axis(std::sin(angle), 0, std::cos(angle));
      const float expected = kPi * std::sin(r) * std::sin(r) * std::cos(angle);
      EXPECT_NEAR(shared::capCosine(up, axis, r) / expected, 1.0f, 1e-4f) << "the light lies above the horizon";
      // Half of the cap is cut away by the plane x = 0 or by the horizon itself: an aperture that is the whole hemisphere changes nothing.
      EXPECT_NEAR(shared::capIntersectionCosine(up, up, shared::kCapRightAngle, axis, r, angle, shared::capArea(r)) / expected, 1.0f,
                  1e-4f);
    }
  // A hemisphere on its side: half of the cosine lobe.
  EXPECT_NEAR(shared::capCosine(up, {1, 0, 0}, shared::kCapRightAngle), 0.5f * kPi, 1e-5f);
  // Two hemispheres on their sides, at right angles: a quarter.
  EXPECT_NEAR(
      shared::capIntersectionCosine(up, {1, 0, 0}, shared::kCapRightAngle, {0, 1, 0}, shared::kCapRightAngle, shared::kCapRightAngle, kPi),
      0.25f * kPi, 1e-5f);
}

class CapsOnDevice : public test::DeviceTest {};

TEST_F(CapsOnDevice, IntersectAsInCpp) {
  if (!device.device) return;
  for (const PairKind kind : kKinds) {
    const std::vector<CapPair> pairs = makePairs(kind, 2000, 7);
    for (const int method : {shared::kMethodStable, shared::kMethodOurs, shared::kMethodCosine}) {
      const Result<DeviceRun> run = evaluateOnDevice(device, pairs, method);
      ASSERT_TRUE(run.ok()) << message(run.error());
      double worst = 0.0;
      for (std::size_t i = 0; i < pairs.size(); ++i)
        worst = std::max(worst, errorOf(run.value().results[i], static_cast<double>(shared::evaluatePair(method, pairs[i])), pairs[i]));
      // The device may divide and take roots a unit in the last place off; borders of caps cancel more of it than areas do.
      EXPECT_LT(worst, method == shared::kMethodCosine ? 5e-4 : 1e-5) << "kind " << static_cast<int>(kind) << " method " << method;
    }
  }
}

}  // namespace
}  // namespace overcast
