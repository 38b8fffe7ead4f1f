// The truth itself against closed forms and against its own definition, written out plainly.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/reference/distance.h"
#include "tests/reference/shapes.h"
#include "tests/reference/winding_number.h"

namespace overcast {
namespace {

const Box kCube{glm::dvec3(-2.0), glm::dvec3(2.0)};

TEST(ReferenceDistance, boxIsExact) {
  const glm::dvec3 half{0.7, 0.9, 1.1};
  const auto points = reference::randomPoints(kCube, 5000, 1);
  const auto distances = reference::distance(reference::boxMesh(half), points);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(distances[i], std::abs(reference::boxDistance(points[i], half)), 4e-15);
}

TEST(ReferenceDistance, fineSphereAndTorusAgreeWithinTheirSag) {
  const auto points = reference::randomPoints(kCube, 500, 2);
  const double sag = reference::icosphereSag(1.0, 4);
  ASSERT_LT(sag, 4e-3);
  const auto sphere = reference::distance(reference::icosphere(1.0, 4), points);
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(sphere[i], std::abs(reference::sphereDistance(points[i], 1.0)), sag);
  const auto torus = reference::distance(reference::torusMesh(1.0, 0.4, 200, 80), points);
  // Chords of 200 steps on the outer ring and of 80 on the tube.
  const double torusSag = 1.4 * (1.0 - std::cos(std::numbers::pi / 200)) + 0.4 * (1.0 - std::cos(std::numbers::pi / 80));
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(torus[i], std::abs(reference::torusDistance(points[i], 1.0, 0.4)), torusSag);
}

TEST(ReferenceDistance, degenerateTrianglesAreTheirSegments) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {3, 0, 0}, {0, 0, 5}};
  mesh.triangles = {{0, 1, 2}, {3, 3, 3}};
  const std::vector<glm::dvec3> points{{2, 1, 0}, {-1, 0, 0}, {0, 0, 4.5}, {3, 4, 0}};
  const std::vector<double> expected{1.0, 1.0, 0.5, 4.0};
  EXPECT_EQ(reference::distance(mesh, points), expected);
  EXPECT_TRUE(std::isinf(reference::distance(Mesh{}, points).front()));
}

/// The definition, triangle by triangle.
double plainWinding(const Mesh& mesh, const glm::dvec3& p) {
  double sum = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x] - p;
    const glm::dvec3 b = mesh.positions[t.y] - p;
    const glm::dvec3 c = mesh.positions[t.z] - p;
    const double la = glm::length(a);
    const double lb = glm::length(b);
    const double lc = glm::length(c);
    sum += 2.0 * std::atan2(glm::dot(a, glm::cross(b, c)), la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return sum / (4.0 * std::numbers::pi);
}

TEST(ReferenceWinding, equalsTheSumOfSolidAngles) {
  const Mesh soup = reference::triangleSoup(7, 300, 1.5);
  const Mesh open = reference::withFlips(reference::withHoles(reference::icosphere(1.0, 2), 0.3, 3), 0.3, 4);
  const auto points = reference::randomPoints(kCube, 2000, 5);
  for (const Mesh& mesh : {soup, open, reference::joined(soup, reference::insideOut(reference::icosphere(1.4, 2)))}) {
    const auto w = reference::windingNumber(mesh, points);
    for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(w[i], plainWinding(mesh, points[i]), 1e-12);
  }
}

TEST(ReferenceWinding, countsNestedAndReversedShells) {
  const Mesh outer = reference::icosphere(1.5, 3);
  const Mesh inner = reference::icosphere(0.5, 3);
  const Mesh doubled = reference::joined(outer, inner);
  const Mesh cavity = reference::joined(outer, reference::insideOut(inner));
  const std::vector<glm::dvec3> points{{0.1, 0.05, 0.02}, {0.9, 0.1, 0.2}, {1.9, 0.3, 0.1}};
  const auto expect = [&](const Mesh& mesh, std::vector<double> values) {
    const auto w = reference::windingNumber(mesh, points);
    for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(w[i], values[i], 1e-12);
  };
  expect(doubled, {2, 1, 0});
  expect(cavity, {0, 1, 0});
  expect(reference::insideOut(doubled), {-2, -1, 0});
  expect(reference::withDuplicates(outer, 1.0, 1), {2, 2, 0});
}

TEST(ReferenceWinding, isOneInsideEveryShape) {
  const auto points = reference::randomPoints(kCube, 1000, 9);
  const glm::dvec3 half{0.7, 0.9, 1.1};
  const auto box = reference::windingNumber(reference::boxMesh(half), points);
  const auto torus = reference::windingNumber(reference::unwelded(reference::torusMesh(1.0, 0.4, 64, 32)), points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(box[i], reference::boxDistance(points[i], half) < 0.0 ? 1.0 : 0.0, 1e-12);
    const double phi = reference::torusDistance(points[i], 1.0, 0.4);
    if (std::abs(phi) > 0.01) {
      EXPECT_NEAR(torus[i], phi < 0.0 ? 1.0 : 0.0, 1e-12);
    }
  }
}

TEST(ReferenceShapes, defectsAreWhatTheySay) {
  const Mesh sphere = reference::icosphere(1.0, 2);
  EXPECT_EQ(sphere.triangles.size(), 320u);
  EXPECT_EQ(sphere.positions.size(), 162u);
  EXPECT_EQ(reference::withHoles(sphere, 1.0, 1).triangles.size(), 0u);
  EXPECT_NEAR(static_cast<double>(reference::withHoles(sphere, 0.25, 1).triangles.size()), 240.0, 30.0);
  EXPECT_EQ(reference::withDuplicates(sphere, 1.0, 1).triangles.size(), 640u);
  EXPECT_EQ(reference::unwelded(sphere).positions.size(), 960u);
  EXPECT_EQ(reference::insideOut(reference::insideOut(sphere)).triangles, sphere.triangles);
  EXPECT_EQ(reference::withHoles(sphere, 0.25, 1).triangles, reference::withHoles(sphere, 0.25, 1).triangles);
  EXPECT_NE(reference::withHoles(sphere, 0.25, 1).triangles, reference::withHoles(sphere, 0.25, 2).triangles);
}

}  // namespace
}  // namespace overcast
