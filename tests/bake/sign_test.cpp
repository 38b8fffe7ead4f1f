#include "bake/sign.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include "bake/repair.h"
#include "tests/bake/test_meshes.h"
#include "tests/reference/distance.h"
#include "tests/reference/shapes.h"
#include "tests/reference/winding_number.h"

namespace overcast {
namespace {

using namespace test;
using reference::insideOut;
using reference::joined;
using reference::torusMesh;
using reference::triangleSoup;
using reference::windingNumber;

double largest(const glm::dvec3& v) {
  return std::max({v.x, v.y, v.z});
}

std::vector<glm::dvec3> samplePoints(const Grid& grid) {
  std::vector<glm::dvec3> points;
  for (std::uint64_t i = 0; i < sampleCount(grid); ++i) points.push_back(samplePoint(grid, i));
  return points;
}

/// Samples that brute force decides (|w| not within `margin` of one half) and the sign field decides otherwise. On the surface itself both
/// answers are right.
int wrongSamples(const Mesh& mesh, const Grid& grid, double margin = 2e-3) {
  const SignField field = signField(mesh, grid);
  const std::vector<glm::dvec3> points = samplePoints(grid);
  const std::vector<double> winding = windingNumber(mesh, points), distance = reference::distance(mesh, points);
  int wrong = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = std::abs(winding[i]);
    if (distance[i] > 1e-5 * grid.voxelSize && std::abs(w - 0.5) > margin && (field.inside[i] != 0) != (w > 0.5)) ++wrong;
  }
  return wrong;
}

TEST(Sign, SphereMatchesItsFormula) {
  const Mesh mesh = sphereMesh(glm::dvec3(0.1, 0.2, 0.3), 1.0, 64, 128);
  const Grid grid = cubeGrid(40, -1.5, 1.5);
  const SignField field = signField(mesh, grid);
  EXPECT_EQ(field.method, "signed-crossings");
  EXPECT_EQ(field.ambiguous, 0.0);
  for (std::uint64_t i = 0; i < sampleCount(grid); ++i) {
    const double phi = glm::distance(samplePoint(grid, i), glm::dvec3(0.1, 0.2, 0.3)) - 1.0;
    if (std::abs(phi) > 0.002) {
      ASSERT_EQ(field.inside[i] != 0, phi < 0.0) << "sample " << i << " phi " << phi;
    }
  }
}

// Every vertex, edge and face of the box lies on rows of the grid: only symbolic perturbation decides.
TEST(Sign, GridAlignedBoxIsSolidWithoutStreaks) {
  const Mesh mesh = boxBetween(glm::dvec3(2.0), glm::dvec3(6.0));
  const Grid grid = cubeGrid(9, 0.0, 8.0);
  const SignField field = signField(mesh, grid);
  for (std::uint64_t i = 0; i < sampleCount(grid); ++i) {
    const glm::dvec3 p = samplePoint(grid, i);
    const double distance = largest(glm::abs(p - 4.0)) - 2.0;
    if (distance != 0.0) {
      ASSERT_EQ(field.inside[i] != 0, distance < 0.0) << p.x << " " << p.y << " " << p.z;
    }
  }
}

// Two boxes that share a grid-aligned wall: whichever box gets the samples on the wall, none may be lost.
TEST(Sign, SharedWallBelongsToExactlyOneSide) {
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 middleHigh(6.0), middleLow(2.0);
    middleHigh[axis] = middleLow[axis] = 4.0;
    const Mesh mesh = joined(boxBetween(glm::dvec3(2.0), middleHigh), boxBetween(middleLow, glm::dvec3(6.0)));
    const Grid grid = cubeGrid(9, 0.0, 8.0);
    const SignField field = signField(mesh, grid);
    for (int a = 3; a <= 5; ++a)
      for (int b = 3; b <= 5; ++b) {
        glm::ivec3 s(a, b, 0);
        s = axis == 0 ? glm::ivec3(4, a, b) : axis == 1 ? glm::ivec3(a, 4, b) : glm::ivec3(a, b, 4);
        EXPECT_TRUE(field.inside[static_cast<std::size_t>(s.x + 9 * (s.y + 9 * s.z))]) << axis << ": " << a << " " << b;
      }
  }
}

TEST(Sign, ClosedButDifficultMeshesMatchBruteForce) {
  const Mesh ball = sphereMesh(glm::dvec3(-0.3, 0.0, 0.0), 0.8, 16, 24);
  const Mesh torus = torusMesh(0.8, 0.3, 24, 12);
  const Mesh overlapping = joined(ball, sphereMesh(glm::dvec3(0.3, 0.1, 0.0), 0.8, 16, 24));
  const Mesh twice = joined(torus, torus);
  const Mesh hollow = joined(sphereMesh(glm::dvec3(0.0), 1.0, 16, 24), insideOut(sphereMesh(glm::dvec3(0.0), 0.6, 16, 24)));
  const Mesh inverted = insideOut(torus);
  Mesh crossing = torusMesh(0.8, 0.5, 24, 12);
  for (glm::dvec3& p : crossing.positions) p.x = p.x > 0.5 ? 1.0 - p.x : p.x;
  const Grid grid = cubeGrid(23, -1.3, 1.3);
  for (const Mesh* mesh : std::initializer_list<const Mesh*>{&overlapping, &twice, &hollow, &inverted, &crossing}) {
    EXPECT_EQ(signField(*mesh, grid).method, "signed-crossings");
    EXPECT_EQ(wrongSamples(*mesh, grid), 0);
  }
}

TEST(Sign, OpenMeshesMatchBruteForce) {
  Mesh bowl = sphereMesh(glm::dvec3(0.0), 1.0, 24, 32);
  bowl.triangles.erase(bowl.triangles.begin(), bowl.triangles.begin() + 500);
  Mesh holes = torusMesh(0.8, 0.35, 32, 16);
  std::erase_if(holes.triangles, [i = 0](const glm::uvec3&) mutable { return ++i % 7 == 0; });
  const Mesh parts = joined(joined(sphereMesh(glm::dvec3(0.4, 0.4, 0.4), 0.7, 12, 16), bowl), insideOut(holes));
  const Grid grid = cubeGrid(25, -1.3, 1.3);
  for (const Mesh* mesh : std::initializer_list<const Mesh*>{&bowl, &holes, &parts}) {
    EXPECT_EQ(signField(*mesh, grid).method, "winding-number");
    EXPECT_EQ(wrongSamples(*mesh, grid), 0);
  }
}

// Boundary edges on rows and in grid planes: the sheets and fills that close the mesh hold samples exactly.
TEST(Sign, GridAlignedOpenBoxesMatchBruteForce) {
  const Mesh box = boxBetween(glm::dvec3(2.0), glm::dvec3(8.0));
  const Grid grid = cubeGrid(12, -0.5, 10.5);
  const Grid aligned{glm::ivec3(11), glm::dvec3(0.0), 1.0};
  for (std::size_t face = 0; face < 6; ++face) {
    Mesh open = box;
    open.triangles.erase(open.triangles.begin() + static_cast<std::ptrdiff_t>(2 * face),
                         open.triangles.begin() + static_cast<std::ptrdiff_t>(2 * face + 2));
    EXPECT_EQ(wrongSamples(open, grid), 0) << "face " << face;
    EXPECT_EQ(wrongSamples(open, aligned), 0) << "face " << face;
  }
}

TEST(Sign, SoupMatchesBruteForceWhereItDecides) {
  const Mesh soup = triangleSoup(5, 300, 1.0);
  EXPECT_EQ(wrongSamples(soup, cubeGrid(20, -1.2, 1.2)), 0);
  EXPECT_GT(signField(soup, cubeGrid(20, -1.0, 1.0)).ambiguous, 0.2);
}

RC_GTEST_PROP(Sign, AnyClosedChainOfLatticePointsIsAnInteger, ()) {
  // A closed fan over few integer points: coincident, collinear and coplanar with the grid most of the time.
  const auto coordinates = *rc::gen::container<std::vector<int>>(24, rc::gen::inRange(0, 5));
  Mesh mesh;
  for (std::size_t i = 0; i < 8; ++i) mesh.positions.emplace_back(coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]);
  mesh.triangles = boxBetween(glm::dvec3(0.0), glm::dvec3(1.0)).triangles;
  const Grid grid{glm::ivec3(15), glm::dvec3(-0.25), 0.37};
  RC_ASSERT(signField(mesh, grid).method == "signed-crossings");
  RC_ASSERT(wrongSamples(mesh, grid) == 0);
}

RC_GTEST_PROP(Sign, AnyChainOfLatticePointsMatchesBruteForce, ()) {
  const auto coordinates = *rc::gen::container<std::vector<int>>(24, rc::gen::inRange(0, 5));
  const auto corners = *rc::gen::container<std::vector<std::uint32_t>>(18, rc::gen::inRange(0u, 8u));
  Mesh mesh;
  for (std::size_t i = 0; i < 8; ++i) mesh.positions.emplace_back(coordinates[3 * i], coordinates[3 * i + 1], coordinates[3 * i + 2]);
  for (std::size_t i = 0; i < 6; ++i) mesh.triangles.emplace_back(corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]);
  RC_ASSERT(wrongSamples(mesh, Grid{glm::ivec3(12), glm::dvec3(-0.25), 0.47}) == 0);
}

// The samples (i, i, i) lie on the chord from (0, 0, 0) to (2, 2, 2), an inner edge of the surface that closes this mesh.
TEST(Sign, SamplesOnAChordOfTheFillMatchBruteForce) {
  Mesh mesh;
  mesh.positions = {{1, 0, 0}, {0, 0, 0}, {2, 2, 2}, {0, 0, 1}};
  mesh.triangles = {{2, 3, 0}, {3, 1, 0}, {3, 1, 0}};
  EXPECT_EQ(wrongSamples(mesh, Grid{glm::ivec3(12), glm::dvec3(-0.25), 0.47}), 0);
  for (glm::dvec3& p : mesh.positions) p = glm::dvec3(p.z, p.x, p.y);
  EXPECT_EQ(wrongSamples(mesh, Grid{glm::ivec3(12), glm::dvec3(-0.25), 0.47}), 0);
}

TEST(Sign, SameForAnyThreadCount) {
  Mesh mesh = torusMesh(0.8, 0.35, 64, 32);
  std::erase_if(mesh.triangles, [i = 0](const glm::uvec3&) mutable { return ++i % 5 == 0; });
  const Grid grid = cubeGrid(40, -1.3, 1.3);
  std::vector<SignField> fields;
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    fields.push_back(signField(mesh, grid));
  }
  EXPECT_EQ(fields[0].inside, fields[1].inside);
  EXPECT_EQ(fields[0].inside, fields[2].inside);
  EXPECT_EQ(fields[0].ambiguous, fields[2].ambiguous);
}

TEST(Sign, StopsWhenAsked) {
  const SignField field = signField(torusMesh(0.8, 0.35, 16, 8), cubeGrid(16, -1.3, 1.3), [](double) { return false; });
  EXPECT_TRUE(field.inside.empty());
}

}  // namespace
}  // namespace overcast
