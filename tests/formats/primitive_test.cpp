// Primitives: distances against closed forms and brute force, and their numbers in JSON, well meant and hostile.
#include "formats/primitive.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "formats/extension_json.h"
#include "tests/reference/primitive.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using testing::HasSubstr;

rc::Gen<double> number(double low, double high) {
  return rc::gen::map(rc::gen::inRange(0, 1 << 20), [=](int n) { return low + (high - low) * n / (1 << 20); });
}

glm::dvec3 point(double reach) {
  const auto coordinate = number(-reach, reach);
  return {*coordinate, *coordinate, *coordinate};
}

Primitive anyPrimitive(PrimitiveShape shape) {
  const auto exponent = number(-2.0, 0.5);
  return {shape, point(3.0), glm::normalize(glm::dquat(*number(0.1, 1.0), *number(-1, 1), *number(-1, 1), *number(-1, 1))),
          glm::dvec3(std::pow(10.0, *exponent), std::pow(10.0, *exponent), std::pow(10.0, *exponent))};
}

glm::dmat4 worldFromUnit(const Primitive& p) {
  return glm::scale(glm::translate(glm::dmat4(1.0), p.centre) * glm::mat4_cast(p.rotation), p.halfExtents);
}

TEST(Primitive, CuboidsHaveTheirClosedForm) {
  const glm::dvec3 half(0.7, 0.2, 0.4);
  const Primitive cuboid{PrimitiveShape::cuboid, glm::dvec3(0.0), {1.0, 0.0, 0.0, 0.0}, half};
  for (const glm::dvec3& p : reference::randomPoints({glm::dvec3(-1.5), glm::dvec3(1.5)}, 2000, 1))
    EXPECT_NEAR(samplePrimitive(cuboid, p), reference::boxDistance(p, half), 1e-15);
}

TEST(Primitive, EqualHalfExtentsAreASphere) {
  const Primitive sphere{PrimitiveShape::ellipsoid, {1.0, 2.0, 3.0}, glm::normalize(glm::dquat(1.0, 2.0, 3.0, 4.0)), glm::dvec3(0.6)};
  for (const glm::dvec3& p : reference::randomPoints({glm::dvec3(-1.0), glm::dvec3(5.0)}, 2000, 2))
    EXPECT_NEAR(samplePrimitive(sphere, p), glm::distance(p, sphere.centre) - 0.6, 1e-14);
  EXPECT_NEAR(samplePrimitive(sphere, sphere.centre), -0.6, 1e-14);
}

TEST(Primitive, EllipsoidsHaveClosedFormsOnTheirLongestAxis) {
  const double a = 2.0, b = 0.5;
  const Primitive e{PrimitiveShape::ellipsoid, glm::dvec3(0.0), {1.0, 0.0, 0.0, 0.0}, {a, 1.2, b}};
  for (const double x : {2.0, 2.5, 1e3, 1e9}) EXPECT_NEAR(samplePrimitive(e, {x, 0, 0}), x - a, 1e-14 * x);
  // Within the focal ellipse two closest points lie off the axis, on both sides of the thinnest direction.
  for (const double x : {0.0, 0.3, 1.0, 1.7, 1.87499})
    EXPECT_NEAR(samplePrimitive(e, {x, 0, 0}), -b * std::sqrt(1 - x * x / (a * a - b * b)), 1e-12);
  for (const double x : {1.876, 1.9, 1.999}) EXPECT_NEAR(samplePrimitive(e, {-x, 0, 0}), x - a, 1e-12);
}

RC_GTEST_PROP(Primitive, APointAlongTheNormalIsAsFarAsItWent, ()) {
  const Primitive e = anyPrimitive(PrimitiveShape::ellipsoid);
  const glm::dvec3 raw = point(1.0);
  RC_PRE(glm::length(raw) > 0.1);
  const glm::dvec3 u = glm::normalize(raw);
  const glm::dvec3 surface = e.centre + e.rotation * (e.halfExtents * u);
  const glm::dvec3 normal = e.rotation * glm::normalize(u / e.halfExtents);
  const double far = *number(0.0, 10.0);
  RC_ASSERT(std::abs(samplePrimitive(e, surface + far * normal) - far) < 1e-12 * (10.0 + far));
}

RC_GTEST_PROP(Primitive, AgreesWithBruteForce, (bool cuboid)) {
  const Primitive p = anyPrimitive(cuboid ? PrimitiveShape::cuboid : PrimitiveShape::ellipsoid);
  glm::dvec3 own = point(1.5) * p.halfExtents;
  const int plane = *rc::gen::inRange(0, 9);  // often on planes of symmetry, where the closest point leaps
  if (plane < 3) own[plane] = 0.0;
  if (plane == 3) own.x = own.y = 0.0;
  const glm::dvec3 at = p.centre + p.rotation * own;
  const double expected = cuboid ? reference::cuboidDistance(at, worldFromUnit(p)) : reference::ellipsoidDistance(at, worldFromUnit(p));
  const double largest = std::max({p.halfExtents.x, p.halfExtents.y, p.halfExtents.z});
  RC_ASSERT(std::abs(samplePrimitive(p, at) - expected) < 1e-7 * largest);
}

RC_GTEST_PROP(Primitive, BoundsAreTight, (bool cuboid)) {
  const Primitive p = anyPrimitive(cuboid ? PrimitiveShape::cuboid : PrimitiveShape::ellipsoid);
  const Box box = bounds(p);
  for (int axis = 0; axis < 3; ++axis) {
    // The plane of the box's face touches: no point beyond it is inside, and its distance falls to zero on it.
    glm::dvec3 direction(0.0);
    direction[axis] = 1.0;
    const glm::dvec3 own = glm::conjugate(p.rotation) * direction;
    const glm::dvec3 support =
        cuboid ? p.halfExtents * glm::sign(own) : p.halfExtents * p.halfExtents * own / glm::length(p.halfExtents * own);
    const glm::dvec3 touching = p.centre + p.rotation * support;
    RC_ASSERT(std::abs(touching[axis] - box.max[axis]) < 1e-12 * (1.0 + std::abs(box.max[axis])));
    RC_ASSERT(std::abs(2.0 * p.centre[axis] - touching[axis] - box.min[axis]) < 1e-12 * (1.0 + std::abs(box.max[axis])));
  }
}

TEST(Primitive, SurvivesExtremeNumbers) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  Primitive p{PrimitiveShape::ellipsoid, glm::dvec3(0.0), {1.0, 0.0, 0.0, 0.0}, {1.0, 1e-6, 1.0}};
  EXPECT_TRUE(isWhole(p));
  for (const double far : {0.0, 1e-300, 1e-9, 1.0, 1e9, 1e30}) EXPECT_TRUE(std::isfinite(samplePrimitive(p, {far, far, 0.0}))) << far;
  for (const double bad : {0.0, -1.0, nan, inf, 1e-7, 1e31}) {
    p.halfExtents.y = bad;
    EXPECT_FALSE(isWhole(p)) << bad;
  }
  p.halfExtents.y = 1.0;
  p.centre.z = nan;
  EXPECT_FALSE(isWhole(p));
  p.centre.z = 0.0;
  p.rotation.w = 1.001;
  EXPECT_FALSE(isWhole(p));
}

/// An occluder's JSON with these numbers of a primitive.
std::string occluderText(const std::string& primitive) {
  return R"({"version":1,"representation":"primitive","bytes":80,"bounds":{"min":[-1,-1,-1],"max":[1,1,1]},"influenceRadius":1,)"
         R"("lipschitz":1,"signMethod":"","error":{"max":0,"rms":0,"signErrors":0,"samples":0,"seed":0},"source":"","settingsHash":"")" +
         primitive + "}";
}

std::string errorOf(const std::string& primitive) {
  const Result<Occluder> parsed = parseOccluder(occluderText(primitive), "x");
  return parsed ? "" : message(parsed.error());
}

TEST(PrimitiveJson, HandWrittenNumbersLoadAndBecomeUnit) {
  const Result<Occluder> parsed = parseOccluder(
      occluderText(R"(,"primitive":{"shape":"ellipsoid","centre":[1,2,3],"rotation":[0,0.7071067,0,0.7071068],"halfExtents":[1,2,0.5]})"),
      "x");
  ASSERT_TRUE(parsed.ok()) << message(parsed.error());
  EXPECT_TRUE(isWhole(*parsed.value().primitive));
  EXPECT_EQ(parsed.value().primitive->shape, PrimitiveShape::ellipsoid);
  EXPECT_NEAR(parsed.value().primitive->rotation.y, std::sqrt(0.5), 1e-7);
}

TEST(PrimitiveJson, HostileNumbersAreRefusedByName) {
  const std::string shape = R"("shape":"cuboid")", centre = R"("centre":[0,0,0])", turn = R"("rotation":[0,0,0,1])",
                    half = R"("halfExtents":[1,1,1])";
  const auto made = [](const std::string& a, const std::string& b, const std::string& c, const std::string& d) {
    return ",\"primitive\":{" + a + "," + b + "," + c + "," + d + "}";
  };
  EXPECT_EQ(errorOf(made(shape, centre, turn, half)), "");
  EXPECT_THAT(errorOf(""), HasSubstr("x/primitive: is missing"));
  EXPECT_THAT(errorOf(R"(,"primitive":[1])"), HasSubstr("x/primitive: is not an object"));
  EXPECT_THAT(errorOf(made(R"("shape":"cone")", centre, turn, half)), HasSubstr("x/primitive/shape: 'cone'"));
  EXPECT_THAT(errorOf(made(shape, R"("centre":[0,0])", turn, half)), HasSubstr("x/primitive/centre: is not an array of 3"));
  EXPECT_THAT(errorOf(made(shape, R"("centre":[0,1e300,0])", turn, half)), HasSubstr("x/primitive/centre: 1e+300 is outside"));
  EXPECT_THAT(errorOf(made(shape, centre, R"("rotation":[0,0,0,0])", half)), HasSubstr("x/primitive/rotation: is not a unit"));
  EXPECT_THAT(errorOf(made(shape, centre, R"("rotation":[0,0,1])", half)), HasSubstr("x/primitive/rotation: is not an array of 4"));
  EXPECT_THAT(errorOf(made(shape, centre, R"("rotation":["a",0,0,1])", half)), HasSubstr("x/primitive/rotation: is not a number"));
  EXPECT_THAT(errorOf(made(shape, centre, turn, R"("halfExtents":[1,0,1])")), HasSubstr("x/primitive/halfExtents: 0 is outside"));
  EXPECT_THAT(errorOf(made(shape, centre, turn, R"("halfExtents":[1,-1,1])")), HasSubstr("x/primitive/halfExtents: -1 is outside"));
  EXPECT_THAT(errorOf(made(shape, centre, turn, R"("halfExtents":[1,1e-8,1])")), HasSubstr("x/primitive/halfExtents: has a smallest"));
  EXPECT_THAT(errorOf(made(shape, centre, turn, R"("halfExtents":null)")), HasSubstr("x/primitive/halfExtents: is not an array"));
}

}  // namespace
}  // namespace overcast
