// Distance against closed forms, brute force in double, and invariances.
#include "bake/distance.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

#include "tests/reference/distance.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

/// Random triangles of very different sizes, some of them degenerate (a segment, a point).
Mesh soup(int triangles, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto point = [&] { return glm::dvec3(unit(random), unit(random), unit(random)); };
  Mesh mesh;
  for (int i = 0; i < triangles; ++i) {
    const glm::dvec3 a = point();
    const double size = std::exp2(-8.0 * std::abs(unit(random)));
    const glm::dvec3 ab = size * point();
    const glm::dvec3 ac = i % 7 == 0 ? 0.5 * ab : i % 11 == 0 ? glm::dvec3(0.0) : size * point();
    for (const glm::dvec3& corner : {a, a + (i % 77 == 0 ? glm::dvec3(0.0) : ab), a + (i % 77 == 0 ? glm::dvec3(0.0) : ac)}) {
      mesh.positions.push_back(corner);
    }
    const auto first = static_cast<unsigned>(3 * i);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

Mesh moved(Mesh mesh, double scale, const glm::dvec3& offset) {
  for (glm::dvec3& position : mesh.positions) position = position * scale + offset;
  return mesh;
}

Grid gridAround(const glm::dvec3& low, const glm::dvec3& high, int longest) {
  const glm::dvec3 size = high - low;
  const double voxel = std::max({size.x, size.y, size.z}) / (longest - 1);
  return {glm::ivec3(glm::floor(size / voxel + 1e-9)) + 1, low, voxel};
}

glm::dvec3 pointOf(const Grid& grid, std::size_t index) {
  const auto nx = static_cast<std::size_t>(grid.size.x);
  const auto ny = static_cast<std::size_t>(grid.size.y);
  return grid.origin + grid.voxelSize * glm::dvec3(index % nx, index / nx % ny, index / (nx * ny));
}

double gridDiagonal(const Grid& grid) {
  return grid.voxelSize * glm::length(glm::dvec3(grid.size - 1));
}

std::vector<glm::dvec3> pointsOf(const Grid& grid) {
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < sampleCount(grid); ++i) points.push_back(pointOf(grid, i));
  return points;
}

/// Largest |distance - truth|, in units of the grid's diagonal.
double worstError(const Grid& grid, const std::vector<float>& distance, const std::vector<double>& truth) {
  EXPECT_EQ(distance.size(), truth.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(distance.size(), truth.size()); ++i) {
    worst = std::max(worst, std::abs(static_cast<double>(distance[i]) - truth[i]));
  }
  return worst / gridDiagonal(grid);
}

/// The same against a closed form.
template <class Truth>
double worstError(const Mesh& mesh, const Grid& grid, const Truth& form) {
  std::vector<double> truth;
  for (const glm::dvec3& point : pointsOf(grid)) truth.push_back(form(point));
  return worstError(grid, unsignedDistance(mesh, grid), truth);
}

/// The same against brute force.
double worstError(const Mesh& mesh, const Grid& grid, Simd simd = Simd::automatic) {
  return worstError(grid, unsignedDistance(mesh, grid, {}, simd), reference::distance(mesh, pointsOf(grid)));
}

// A float of the size of the diagonal is rounded to 6e-8 of it; the header allows a few of these.
constexpr double kFloatUlps = 2e-7;

TEST(Distance, CuboidMatchesItsClosedForm) {
  const glm::dvec3 half(1.0, 0.5, 0.25);
  const Grid grid = gridAround(glm::dvec3(-1.7), glm::dvec3(1.6, 1.5, 1.4), 37);
  EXPECT_LT(worstError(reference::boxMesh(half), grid, [&](const glm::dvec3& p) { return std::abs(reference::boxDistance(p, half)); }),
            kFloatUlps);
}

TEST(Distance, SinglePointSegmentAndTriangleMatchTheirClosedForms) {
  const Grid grid = gridAround(glm::dvec3(-1.0), glm::dvec3(1.0), 17);
  Mesh mesh;
  mesh.positions = {{0.25, 0.5, -0.125}, {0.75, 0.5, -0.125}, {0.5, 0.5, -0.125}};
  mesh.triangles = {{0, 0, 0}};
  EXPECT_LT(worstError(mesh, grid, [&](const glm::dvec3& p) { return glm::distance(p, mesh.positions[0]); }), kFloatUlps);
  mesh.triangles = {{0, 1, 2}};
  const auto segment = [](const glm::dvec3& p) { return glm::distance(p, {std::clamp(p.x, 0.25, 0.75), 0.5, -0.125}); };
  EXPECT_LT(worstError(mesh, grid, segment), kFloatUlps);
  mesh.positions = {{-50.0, 0.1, -50.0}, {50.0, 0.1, -50.0}, {0.0, 0.1, 90.0}};
  EXPECT_LT(worstError(mesh, grid, [](const glm::dvec3& p) { return std::abs(p.y - 0.1); }), kFloatUlps);
}

TEST(Distance, SoupMatchesBruteForce) {
  const Mesh mesh = soup(400, 7);
  const Grid grid = gridAround(glm::dvec3(-1.8), glm::dvec3(2.2, 1.9, 1.7), 29);
  EXPECT_LT(worstError(mesh, grid), kFloatUlps);
}

TEST(Distance, GridInsideAndFarBesideTheMeshMatchesBruteForce) {
  const Mesh mesh = soup(300, 11);
  for (const glm::dvec3& centre : {glm::dvec3(0.1, -0.2, 0.3), glm::dvec3(30.0, 5.0, -9.0), glm::dvec3(0.0, -400.0, 0.0)}) {
    const Grid grid = gridAround(centre - 0.1, centre + glm::dvec3(0.1, 0.15, 0.05), 13);
    const double allowed = kFloatUlps * (1.0 + glm::length(centre) / gridDiagonal(grid));
    EXPECT_LT(worstError(mesh, grid), allowed);
  }
}

TEST(Distance, HoldsAtAnyScaleAndFarFromTheOrigin) {
  for (const double scale : {1e-4, 1.0, 1e4}) {
    for (const double diagonals : {0.0, 1e5}) {
      const glm::dvec3 offset = scale * diagonals * glm::dvec3(2.0, -1.5, 1.0);
      const Mesh mesh = moved(soup(200, 3), scale, offset);
      const Grid grid = gridAround(offset - 1.5 * scale, offset + 1.5 * scale, 15);
      EXPECT_LT(worstError(mesh, grid), kFloatUlps) << "scale " << scale << ", offset by " << diagonals << " diagonals";
    }
  }
}

TEST(Distance, AnyGridShapeIsFilled) {
  const Mesh mesh = soup(50, 5);
  for (const glm::ivec3& size : {glm::ivec3(1), glm::ivec3(1, 9, 2), glm::ivec3(33, 1, 1), glm::ivec3(5, 8, 16), glm::ivec3(2, 3, 41)}) {
    const Grid grid{size, glm::dvec3(-0.9), 0.11};
    const std::vector<float> distance = unsignedDistance(mesh, grid);
    ASSERT_EQ(distance.size(), static_cast<std::size_t>(size.x * size.y * size.z));
    const std::vector<double> truth = reference::distance(mesh, pointsOf(grid));
    for (std::size_t i = 0; i < distance.size(); ++i) EXPECT_NEAR(distance[i], truth[i], 1e-6) << "sample " << i;
  }
}

TEST(Distance, EveryInstructionSetMatchesBruteForce) {
  const Mesh mesh = soup(400, 17);
  const Grid grid = gridAround(glm::dvec3(-1.8), glm::dvec3(1.8), 21);
  for (const Simd simd : {Simd::portable, Simd::avx2, Simd::avx512}) {
    EXPECT_LT(worstError(mesh, grid, simd), kFloatUlps) << "instruction set " << static_cast<int>(simd);
  }
  EXPECT_EQ(unsignedDistance(mesh, grid, {}, Simd::avx2), unsignedDistance(mesh, grid, {}, Simd::avx512));
}

TEST(Distance, TrianglesFarSmallerAndFarLargerThanAVoxelMatchBruteForce) {
  const Mesh fine = reference::icosphere(1.0, 5);
  EXPECT_LT(worstError(fine, gridAround(glm::dvec3(-1.4), glm::dvec3(1.3), 14)), kFloatUlps);
  EXPECT_LT(worstError(reference::unwelded(fine), gridAround(glm::dvec3(-1.3), glm::dvec3(1.4), 10)), kFloatUlps);
  const Mesh coarse = reference::icosphere(1.0, 1);
  EXPECT_LT(worstError(coarse, gridAround(glm::dvec3(-1.4), glm::dvec3(1.3), 60)), kFloatUlps);
  const Mesh torus = reference::torusMesh(1.0, 0.3, 200, 3);  // long thin triangles
  EXPECT_LT(worstError(torus, gridAround(glm::dvec3(-1.4), glm::dvec3(1.4), 40)), kFloatUlps);
}

TEST(Distance, PointsOnTheLineOfADegenerateTriangleSeeBeyondIt) {
  Mesh mesh;  // a segment, and a triangle whose nearest corner lies on the segment's line; grid points lie exactly on it
  mesh.positions = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.25, 0.0, 0.0}, {4.0, 0.0, 0.0}, {4.5, 0.5, 0.0}, {4.5, 0.0, 0.5}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const Grid grid{glm::ivec3(25, 5, 5), glm::dvec3(-1.0, -0.5, -0.5), 0.25};
  EXPECT_LT(worstError(mesh, grid), kFloatUlps);
}

TEST(Distance, InsideOfALargeTriangleWinsOverANearVertex) {
  Mesh mesh;  // the middle of an equilateral triangle is far from its corners; a tiny triangle hovers over it, nearer than these
  mesh.positions = {{60.0, 0.0, 0.0}, {-30.0, 52.0, 0.0}, {-30.0, -52.0, 0.0}, {0.0, 0.0, 4.6}, {0.1, 0.0, 4.6}, {0.0, 0.1, 4.6}};
  for (int i = 0; i < 40; ++i) {
    const auto first = static_cast<unsigned>(mesh.positions.size());
    const double side = 0.5 * i - 10.0;
    for (const glm::dvec3& corner : {glm::dvec3(0.0), glm::dvec3(0.1, 0.0, 0.0), glm::dvec3(0.0, 0.1, 0.0)}) {
      mesh.positions.push_back(glm::dvec3(side, 0.3 * side, 4.6) + corner);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  mesh.triangles.push_back({0, 1, 2});
  mesh.triangles.push_back({3, 4, 5});
  EXPECT_LT(worstError(mesh, {glm::ivec3(41, 41, 12), glm::dvec3(-20.0, -20.0, -3.0), 1.0}), kFloatUlps);
}

TEST(Distance, TrianglesThatMakeADeepTreeMatchBruteForce) {
  Mesh mesh;
  for (unsigned i = 0; i < 900; ++i) {  // each a bit smaller and nearer to the origin: splits by area would peel off one by one
    const double size = std::pow(0.97, i);
    for (const glm::dvec3& corner : {glm::dvec3(1.0, 0.0, 0.0), glm::dvec3(1.0, 0.01, 0.0), glm::dvec3(1.0, 0.0, 0.01)}) {
      mesh.positions.push_back(size * corner);
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  for (int i = 0; i < 100; ++i) mesh.triangles.push_back(mesh.triangles.front());  // and equal centres
  EXPECT_LT(worstError(mesh, gridAround(glm::dvec3(-0.1), glm::dvec3(1.1, 0.2, 0.2), 50)), kFloatUlps);
}

TEST(NarrowBand, IsTheDenseDistanceCutAtTheBand) {
  const Mesh mixed = reference::joined(soup(150, 23), reference::boxMesh(glm::dvec3(1.3, 0.2, 0.7)));
  for (const double band : {0.3, 3.0, 11.5, 1000.0}) {
    for (const Simd simd : {Simd::automatic, Simd::portable}) {
      const Grid grid = gridAround(glm::dvec3(-2.5, -1.4, -1.3), glm::dvec3(2.6, 2.5, 1.6), 50);
      std::vector<float> expected = unsignedDistance(mixed, grid, {}, simd);
      const auto cut = static_cast<float>(band * grid.voxelSize);
      for (float& distance : expected) distance = std::min(distance, cut);
      EXPECT_EQ(narrowBand(mixed, grid, band, {}, simd), expected) << "band of " << band << " voxels";
    }
  }
}

TEST(NarrowBand, TurnedSlabLeavesMostPacketsAlone) {
  Mesh slab;  // two long triangles across the grid's diagonal
  slab.positions = {{-1.0, -1.0, -1.0}, {1.0, 1.0, -1.0}, {-1.0, -1.0, 1.0}, {1.0, 1.0, 1.0}};
  slab.triangles = {{0, 1, 2}, {2, 1, 3}};
  const Grid grid{glm::ivec3(64), glm::dvec3(-1.0), 2.0 / 63.0};
  DistanceCost cost;
  const std::vector<float> distance = narrowBand(slab, grid, 2.0, {}, Simd::automatic, &cost);
  EXPECT_LT(cost.packets, 16 * 16 * 16 / 3);
  const std::vector<double> truth = reference::distance(slab, pointsOf(grid));
  for (std::size_t i = 0; i < distance.size(); ++i) ASSERT_NEAR(distance[i], std::min(truth[i], 2.0 * grid.voxelSize), 1e-6);
}

TEST(NarrowBand, FarFromTheMeshIsTheBand) {
  const Grid grid{glm::ivec3(9), glm::dvec3(50.0), 0.1};
  const Mesh mesh = soup(20, 2);
  EXPECT_EQ(narrowBand(mesh, grid, 3.0), std::vector<float>(sampleCount(grid), static_cast<float>(3.0 * 0.1)));
}

TEST(Distance, SameBytesForAnyThreadCount) {
  const Mesh mesh = soup(500, 13);
  const Grid grid = gridAround(glm::dvec3(-1.5), glm::dvec3(1.5), 31);
  std::vector<float> first;
  for (const int threads : {1, 2, 4}) {
    tbb::task_arena arena(threads);
    const std::vector<float> distance = arena.execute([&] { return unsignedDistance(mesh, grid); });
    if (first.empty()) first = distance;
    EXPECT_EQ(first, distance) << threads << " threads";
  }
  tbb::task_arena one(1);
  EXPECT_EQ(one.execute([&] { return narrowBand(mesh, grid, 2.5); }), narrowBand(mesh, grid, 2.5));
}

TEST(Distance, StopsWhenAsked) {
  const Mesh mesh = reference::boxMesh(glm::dvec3(1.0));
  const Grid grid = gridAround(glm::dvec3(-2.0), glm::dvec3(2.0), 32);
  EXPECT_TRUE(unsignedDistance(mesh, grid, [](double) { return false; }).empty());
  double last = 0.0;
  const auto listen = [&](double share) {
    last = std::max(last, share);
    return true;
  };
  tbb::task_arena arena(1);
  EXPECT_EQ(arena.execute([&] { return unsignedDistance(mesh, grid, listen); }).size(), sampleCount(grid));
  EXPECT_DOUBLE_EQ(last, 1.0);
}

RC_GTEST_PROP(Distance, AtPointsMatchesBruteForceInDouble, (unsigned seed)) {
  const Mesh mesh = soup(60, seed);
  std::mt19937 random(seed + 1);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<glm::dvec3> points;
  for (int i = 0; i < 40; ++i) points.push_back(std::pow(10.0, i % 4 - 1) * glm::dvec3(normal(random), normal(random), normal(random)));
  points.push_back(mesh.positions[0]);
  const std::vector<double> distance = distanceAt(mesh, points);
  const std::vector<double> truth = reference::distance(mesh, points);
  RC_ASSERT(distance.size() == points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    RC_ASSERT(std::abs(distance[i] - truth[i]) <= 1e-11 * (1.0 + distance[i]));
  }
}

}  // namespace
}  // namespace overcast
