#include "formats/mesh_triangulate.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include <glm/geometric.hpp>

namespace overcast {
namespace {

using Points = std::vector<glm::dvec3>;

std::vector<glm::uvec3> triangulated(const Points& points) {
  std::vector<std::uint32_t> polygon(points.size());
  std::iota(polygon.begin(), polygon.end(), 0u);
  std::vector<glm::uvec3> triangles;
  triangulate(points, polygon, triangles);
  return triangles;
}

glm::dvec3 areaVector(const Points& points, const glm::uvec3& t) {
  return 0.5 * glm::cross(points[t.y] - points[t.x], points[t.z] - points[t.x]);
}

/// Twice nothing: the shoelace formula in space.
glm::dvec3 areaVector(const Points& points) {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < points.size(); ++i) sum += 0.5 * glm::cross(points[i], points[(i + 1) % points.size()]);
  return sum;
}

/// A planar polygon is covered exactly once: all triangles turn the polygon's way and their areas add up to its own.
void expectCovers(const Points& points) {
  const auto triangles = triangulated(points);
  ASSERT_EQ(triangles.size(), points.size() - 2);
  const glm::dvec3 whole = areaVector(points);
  const double area = glm::length(whole);
  double sum = 0.0;
  for (const glm::uvec3& t : triangles) {
    const glm::dvec3 part = areaVector(points, t);
    EXPECT_GT(glm::dot(part, whole), -1e-9 * area * area) << "a triangle is turned over";
    sum += glm::length(part);
  }
  EXPECT_NEAR(sum / area, 1.0, 1e-9);
}

/// Points of the plane put on a tilted plane in space, so that every projection axis comes up.
Points tilted(const std::vector<std::pair<double, double>>& flat, int turn, double scale = 1.0) {
  const glm::dvec3 bases[][2] = {{{1, 0, 0}, {0, 1, 0}}, {{0, 1, 0}, {0, 0, 1}},     {{0, 0, 1}, {1, 0, 0}},
                                 {{0, 1, 0}, {1, 0, 0}}, {{0.6, 0.8, 0}, {0, 0, 1}}, {{0.48, 0.64, -0.6}, {0.8, -0.6, 0}}};
  Points points;
  for (const auto& [x, y] : flat) points.push_back(scale * (x * bases[turn][0] + y * bases[turn][1]) + glm::dvec3(5, -7, 11) * scale);
  return points;
}

TEST(Triangulate, ConcavePolygonsInAnyPlaneAndSize) {
  const std::vector<std::pair<double, double>> arrow = {{0, 0}, {2, 1}, {0, 2}, {0.5, 1}};
  std::vector<std::pair<double, double>> comb;
  for (int i = 0; i < 20; ++i) {
    comb.emplace_back(i, 0.0);
    comb.emplace_back(i + 0.5, 9.0);
  }
  comb.emplace_back(20.0, -1.0);
  comb.emplace_back(0.0, -1.0);
  std::vector<std::pair<double, double>> spiral;
  for (int i = 0; i < 60; ++i) spiral.emplace_back((1 + 0.1 * i) * std::cos(0.3 * i), (1 + 0.1 * i) * std::sin(0.3 * i));
  for (int i = 59; i >= 0; --i) spiral.emplace_back((1.3 + 0.1 * i) * std::cos(0.3 * i), (1.3 + 0.1 * i) * std::sin(0.3 * i));
  for (int turn = 0; turn < 6; ++turn) {
    for (const double scale : {1.0, 1e-12, 1e12}) {
      for (auto shape : {arrow, comb, spiral}) {
        expectCovers(tilted(shape, turn, scale));
        std::reverse(shape.begin(), shape.end());
        expectCovers(tilted(shape, turn, scale));
        std::rotate(shape.begin(), shape.begin() + 1, shape.end());
        expectCovers(tilted(shape, turn, scale));
      }
    }
  }
}

TEST(Triangulate, RandomStarsAreCoveredOnce) {
  EXPECT_TRUE(rc::check("stars", [] {
    const int corners = *rc::gen::inRange(4, 40);
    std::mt19937 random(*rc::gen::arbitrary<std::uint32_t>());
    std::uniform_real_distribution<double> radius(0.05, 1.0);
    std::vector<std::pair<double, double>> flat;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / corners, r = radius(random);
      flat.emplace_back(r * std::cos(angle), r * std::sin(angle));
    }
    expectCovers(tilted(flat, *rc::gen::inRange(0, 6)));
    RC_ASSERT(!testing::Test::HasFailure());
  }));
}

TEST(Triangulate, AConvexPolygonIsAFan) {
  Points hexagon;
  for (int i = 0; i < 6; ++i) hexagon.emplace_back(std::cos(i * std::numbers::pi / 3), std::sin(i * std::numbers::pi / 3), 0.0);
  const auto triangles = triangulated(hexagon);
  ASSERT_EQ(triangles.size(), 4u);
  for (std::uint32_t i = 0; i < 4; ++i) EXPECT_EQ(triangles[i], glm::uvec3(0, i + 1, i + 2));
}

TEST(Triangulate, CollinearCornersOnASquareAreCovered) {
  expectCovers({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}});
  expectCovers({{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}});
}

TEST(Triangulate, APolygonBridgedToItsHoleIsCovered) {
  expectCovers({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0}, {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}});
}

TEST(Triangulate, DegeneratePolygonsEndWithTheRightCount) {
  const double nearMax = 1e308;
  std::vector<Points> cases = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
                               {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1.5, 0, 0}},
                               {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}},
                               {{-nearMax, 0, 0}, {nearMax, nearMax, 0}, {0, 0, nearMax}, {0, -nearMax, 0}, {1, 1, 1}}};
  Points pentagram, random;
  for (int i = 0; i < 5; ++i) pentagram.emplace_back(std::cos(i * 0.8 * std::numbers::pi), std::sin(i * 0.8 * std::numbers::pi), 0);
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  for (int i = 0; i < 500; ++i) random.emplace_back(coordinate(engine), coordinate(engine), coordinate(engine));
  cases.push_back(pentagram);
  cases.push_back(random);
  for (const Points& points : cases) {
    const auto triangles = triangulated(points);
    EXPECT_EQ(triangles.size(), points.size() - 2);
    for (const glm::uvec3& t : triangles) {
      for (int c = 0; c < 3; ++c) ASSERT_LT(t[c], points.size());
    }
  }
}

TEST(Triangulate, WorkIsBoundedForTheWorstPolygons) {
  std::mt19937 engine(2);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  Points worst;
  for (std::size_t i = 0; i < kMaxEarClippingCorners; ++i) worst.emplace_back(coordinate(engine), coordinate(engine), 0.0);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(triangulated(worst).size(), kMaxEarClippingCorners - 2);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  worst.resize(200'000, glm::dvec3(0.0));
  EXPECT_EQ(triangulated(worst).size(), worst.size() - 2);
}

}  // namespace
}  // namespace overcast
