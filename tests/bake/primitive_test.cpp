// Primitives from meshes: cuboids and ellipsoids come back, whatever their place, size, orientation and order of triangles.
#include "bake/primitive.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/reference/primitive.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

Mesh transformed(Mesh mesh, const glm::dmat4& matrix) {
  for (glm::dvec3& p : mesh.positions) p = glm::dvec3(matrix * glm::dvec4(p, 1.0));
  return mesh;
}

glm::dmat4 pose(const glm::dvec3& centre, const glm::dquat& rotation, const glm::dvec3& half) {
  return glm::scale(glm::translate(glm::dmat4(1.0), centre) * glm::mat4_cast(glm::normalize(rotation)), half);
}

/// Largest difference in diagonals of the box between the primitive and the truth, in and around the box.
template <class Truth>
double worstError(const Primitive& primitive, const Box& box, const Truth& truth) {
  const Box around{box.min - 0.2 * diagonal(box), box.max + 0.2 * diagonal(box)};
  double worst = 0.0;
  for (const glm::dvec3& p : reference::randomPoints(around, 400, 5))
    worst = std::max(worst, std::abs(samplePrimitive(primitive, p) - truth(p)));
  return worst / diagonal(box);
}

rc::Gen<double> number(double low, double high) {
  return rc::gen::map(rc::gen::inRange(0, 1 << 20), [=](int n) { return low + (high - low) * n / (1 << 20); });
}

TEST(BakePrimitive, RotatedCuboidsComeBack) {
  EXPECT_TRUE(rc::check("cuboids", [] {
    const double scale = std::pow(10.0, *number(-3.0, 3.0));
    const glm::dvec3 half(std::pow(10.0, *number(-2.0, 0.0)), std::pow(10.0, *number(-2.0, 0.0)), 1.0);
    const glm::dvec3 centre = scale * glm::dvec3(*number(-100, 100), *number(-100, 100), *number(-100, 100));
    const glm::dmat4 matrix = pose(centre, glm::dquat(*number(0.05, 1), *number(-1, 1), *number(-1, 1), *number(-1, 1)), scale * half);
    const Mesh mesh = transformed(reference::boxMesh(glm::dvec3(1.0)), matrix);
    const Result<Primitive> baked = bakePrimitive(mesh, PrimitiveShape::cuboid);
    RC_ASSERT(baked.ok());
    RC_ASSERT(worstError(baked.value(), bounds(mesh), [&](const glm::dvec3& p) { return reference::cuboidDistance(p, matrix); }) < 1e-5);
  }));
}

TEST(BakePrimitive, CuboidsSpoiltWithoutHarmComeBack) {
  const glm::dmat4 matrix = pose({1.0, 2.0, 3.0}, glm::dquat(1.0, 0.4, -0.3, 0.2), {0.5, 0.3, 0.9});
  const Mesh mesh = transformed(reference::boxMesh(glm::dvec3(1.0)), matrix);
  const auto exact = [&](const glm::dvec3& p) { return reference::cuboidDistance(p, matrix); };
  for (const Mesh& spoilt : {reference::insideOut(mesh), reference::unwelded(mesh), reference::withDuplicates(mesh, 0.5, 3),
                             reference::withFlips(mesh, 0.3, 2)}) {
    const Result<Primitive> baked = bakePrimitive(spoilt, PrimitiveShape::cuboid);
    ASSERT_TRUE(baked.ok()) << message(baked.error());
    EXPECT_LT(worstError(baked.value(), bounds(mesh), exact), 1e-5);
  }
}

TEST(BakePrimitive, TessellatedEllipsoidsComeBackWithinTheirTessellation) {
  for (const glm::dvec3& half : {glm::dvec3(1.0), glm::dvec3(1.0, 0.6, 0.3), glm::dvec3(0.2, 0.25, 1.0), glm::dvec3(1.0, 0.1, 0.9)}) {
    const glm::dmat4 matrix = pose({0.3, -5.0, 2.0}, glm::dquat(1.0, 0.7, -0.3, 0.2), half);
    const Mesh mesh = transformed(reference::icosphere(1.0, 4), matrix);
    const Result<Primitive> baked = bakePrimitive(mesh, PrimitiveShape::ellipsoid);
    ASSERT_TRUE(baked.ok()) << message(baked.error());
    // The affine map stretches the sphere's sag at most by the longest half extent.
    const double sag = reference::icosphereSag(1.0, 4) * std::max({half.x, half.y, half.z});
    EXPECT_LT(worstError(baked.value(), bounds(mesh), [&](const glm::dvec3& p) { return reference::ellipsoidDistance(p, matrix); }),
              sag / diagonal(bounds(mesh)))
        << half.x << " " << half.y << " " << half.z;
  }
}

TEST(BakePrimitive, AThirdShapeGetsTheBestThereIs) {
  // No cuboid is nearer to a sphere than one of half extents between its inscribed and circumscribed cubes.
  const Mesh sphere = reference::icosphere(1.0, 3);
  const Primitive cuboid = bakePrimitive(sphere, PrimitiveShape::cuboid).value();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GT(cuboid.halfExtents[axis], std::sqrt(1.0 / 3.0));
    EXPECT_LT(cuboid.halfExtents[axis], 1.0);
  }
  EXPECT_LT(glm::length(cuboid.centre), 0.05);
}

TEST(BakePrimitive, NeitherOrderNorThreadsChangeABit) {
  Mesh mesh =
      transformed(reference::torusMesh(0.8, 0.3, 24, 12), pose({4.0, 0.0, 1.0}, glm::dquat(1.0, 0.2, 0.3, 0.4), glm::dvec3(1.0, 0.7, 1.2)));
  const auto numbers = [](const Primitive& p) {
    return std::array{p.centre.x,   p.centre.y,   p.centre.z,      p.rotation.w,    p.rotation.x,
                      p.rotation.y, p.rotation.z, p.halfExtents.x, p.halfExtents.y, p.halfExtents.z};
  };
  for (const PrimitiveShape shape : {PrimitiveShape::cuboid, PrimitiveShape::ellipsoid}) {
    const auto first = numbers(bakePrimitive(mesh, shape).value());
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), std::mt19937(4));
    for (glm::uvec3& t : mesh.triangles) t = {t.y, t.z, t.x};
    EXPECT_EQ(numbers(bakePrimitive(mesh, shape).value()), first);
  }
}

TEST(BakePrimitive, WhatHasNoSurfaceIsRefused) {
  Mesh mesh;
  EXPECT_FALSE(bakePrimitive(mesh, PrimitiveShape::cuboid).ok());
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_FALSE(bakePrimitive(mesh, PrimitiveShape::ellipsoid).ok());
  const Result<Primitive> stopped =
      bakePrimitive(reference::boxMesh(glm::dvec3(1.0)), PrimitiveShape::cuboid, [](double) { return false; });
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().reason, "interrupted");
}

TEST(BakePrimitive, ASheetBecomesAThinCuboid) {
  Mesh sheet;
  sheet.positions = {{0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {0, 0, 1}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Result<Primitive> baked = bakePrimitive(sheet, PrimitiveShape::cuboid);
  ASSERT_TRUE(baked.ok()) << message(baked.error());
  const glm::dvec3 half = baked.value().halfExtents;
  EXPECT_LT(std::min({half.x, half.y, half.z}), 1e-3);
  EXPECT_NEAR(std::max({half.x, half.y, half.z}), 1.0, 1e-3);
}

}  // namespace
}  // namespace overcast
