#include "bake/heightfield.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <span>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "bake/distance.h"
#include "bake/height_raster.h"
#include "formats/asset.h"
#include "formats/mesh.h"
#include "tests/bake/test_meshes.h"
#include "tests/reference/distance.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using namespace reference;

/// z = height(x, y) over [-1, 1] x [-ratio, ratio] as 2 n^2 triangles that face +z, then turned.
Mesh terrain(int n, double ratio, const std::function<double(double, double)>& height, const glm::dquat& turn = glm::dquat(1, 0, 0, 0)) {
  Mesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = 2.0 * i / n - 1.0, y = ratio * (2.0 * j / n - 1.0);
      mesh.positions.push_back(turn * glm::dvec3(x, y, height(x, y)));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const auto a = static_cast<std::uint32_t>(i + (n + 1) * j), b = a + static_cast<std::uint32_t>(n) + 1;
      mesh.triangles.emplace_back(a, a + 1, b + 1);
      mesh.triangles.emplace_back(a, b + 1, b);
    }
  return mesh;
}

double hills(double x, double y) {
  return 0.15 * std::sin(3.0 * x + 0.4) * std::cos(4.0 * y) + 0.1 * x;
}

HeightField baked(const Mesh& mesh, int resolution = 64) {
  const auto field = bakeHeightField(mesh, resolution);
  EXPECT_TRUE(field.ok()) << (field.ok() ? "" : message(field.error()));
  return field.ok() ? field.value() : HeightField{};
}

std::string reasonAgainst(const Mesh& mesh) {
  const auto field = bakeHeightField(mesh);
  return field.ok() ? std::string() : field.error().reason;
}

TEST(HeightRaster, IsTheHighestAndLowestOfAllTriangles) {
  const Mesh soup = triangleSoup(5, 40, 1.0);
  const LineGrid grid{{37, 23}, {-1.0, -1.0}, {2.0 / 37, 2.0 / 23}};
  const HeightRaster raster = rasterHeights(soup.positions, soup.triangles, grid);
  std::size_t met = 0;
  for (int j = 0; j < 23; ++j)
    for (int i = 0; i < 37; ++i) {
      // Cramer's rule for a + u (b - a) + v (c - a) + w (0, 0, 1) = p.
      const double x = -1.0 + (i + 0.5) * 2.0 / 37, y = -1.0 + (j + 0.5) * 2.0 / 23;
      double top = -INFINITY, bottom = INFINITY;
      for (const glm::uvec3& t : soup.triangles) {
        const glm::dvec3 a = soup.positions[t.x], ab = soup.positions[t.y] - a, ac = soup.positions[t.z] - a;
        const double det = ab.x * ac.y - ac.x * ab.y, u = ((x - a.x) * ac.y - ac.x * (y - a.y)) / det,
                     v = (ab.x * (y - a.y) - (x - a.x) * ab.y) / det;
        if (u < 0.0 || v < 0.0 || u + v > 1.0) continue;
        top = std::max(top, a.z + u * ab.z + v * ac.z);
        bottom = std::min(bottom, a.z + u * ab.z + v * ac.z);
      }
      const auto line = static_cast<std::size_t>(i + 37 * j);
      ASSERT_EQ(std::isfinite(top), std::isfinite(raster.top[line]));
      if (!std::isfinite(top)) continue;
      ++met;
      EXPECT_NEAR(raster.top[line], top, 1e-9);
      EXPECT_NEAR(raster.bottom[line], bottom, 1e-9);
    }
  EXPECT_GT(met, 400u);
}

TEST(BakeHeightField, PlanesAreExactToHalfFloats) {
  const glm::dquat turn = glm::normalize(glm::dquat(0.8, 0.4, -0.3, 0.2));
  for (const glm::dvec2& slope : {glm::dvec2(0.0), glm::dvec2(0.3, -0.2)}) {
    const Mesh mesh = terrain(
        6, 0.5, [&](double x, double y) { return slope.x * x + slope.y * y; }, turn);
    const HeightField field = baked(mesh, 32);
    EXPECT_TRUE(field.back.empty());
    const glm::dvec3 normal = turn * glm::normalize(glm::dvec3(-slope, 1.0));
    EXPECT_GT(glm::dot(field.localFromField[2], normal), 0.9);
    for (const glm::dvec3& p : randomPoints({glm::dvec3(-0.35), glm::dvec3(0.35)}, 500, 3)) {
      const glm::dvec3 inField = (p - field.origin) * field.localFromField, wall = glm::abs(inField) - field.halfExtent;
      if (std::max({wall.x, wall.y, wall.z}) > -0.1) continue;
      EXPECT_NEAR(sampleHeightField(field, p), std::abs(glm::dot(normal, p)), 1e-3 * field.halfExtent.z);
    }
  }
}

TEST(BakeHeightField, TexelsHoldTheMomentsOfTheirSurface) {
  const Mesh mesh = terrain(128, 1.0, hills);
  const HeightField field = bakeHeightField(mesh, HeightView{}, 16).value();
  const glm::dvec2 cell = cellSize(field);
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 16; ++i) {
      double sum = 0.0, squares = 0.0;
      constexpr int n = 64;
      for (int b = 0; b < n; ++b)
        for (int a = 0; a < n; ++a) {
          const double h = hills(-1.0 + cell.x * (i + (a + 0.5) / n), -1.0 + cell.y * (j + (b + 0.5) / n)) - field.origin.z;
          sum += h;
          squares += h * h;
        }
      const double mean = sum / (n * n), variance = squares / (n * n) - mean * mean;
      const HeightTexel& texel = field.front[0][static_cast<std::size_t>(i + 16 * j)];
      // Halves, facets (a 128th of the side, curvature below 3), and 16 of infinitely many lines: 1/16 of a plane's variance.
      EXPECT_NEAR(texel.mean * field.halfExtent.z, mean, 1.5e-3 * field.halfExtent.z);
      EXPECT_NEAR(texel.variance * field.halfExtent.z * field.halfExtent.z, variance * 15.0 / 16.0, 0.04 * variance + 1e-6);
    }
}

TEST(BakeHeightField, TerrainIsNearItsDistance) {
  for (const glm::dquat& turn : {glm::dquat(1, 0, 0, 0), glm::normalize(glm::dquat(0.8, -0.4, 0.3, 0.2))}) {
    const Mesh mesh = terrain(96, 0.7, hills, turn);
    const auto view = bestHeightView(mesh).value();
    EXPECT_FALSE(view.pair);
    EXPECT_GT(view.seen, 0.999);
    EXPECT_GT(glm::dot(view.localFromField[2], turn * glm::dvec3(0, 0, 1)), 0.9);
    double before = 1e300;
    for (const int resolution : {8, 16, 32, 64}) {
      const HeightField field = bakeHeightField(mesh, view, resolution).value();
      std::vector<glm::dvec3> points;
      for (const glm::dvec3& p : randomPoints({glm::dvec3(-0.85, -0.55, 0.0), glm::dvec3(0.85, 0.55, 0.1)}, 1500, 5))
        points.push_back(turn * glm::dvec3(p.x, p.y, hills(p.x, p.y) + p.z));
      const std::vector<double> exact = distance(mesh, points);
      double squares = 0.0;
      for (std::size_t n = 0; n < points.size(); ++n) {
        const double off = sampleHeightField(field, points[n]) - exact[n];
        squares += off * off / static_cast<double>(points.size());
      }
      EXPECT_LT(std::sqrt(squares), before) << resolution;
      before = std::sqrt(squares);
    }
    EXPECT_LT(before, 0.005);
  }
}

/// Four sides of a pyramid over [-1, 1]^2, its tip at (0, 0, height), no base.
TEST(BakeHeightField, PyramidKeepsItsFaces) {
  const double height = 0.6;
  const Mesh mesh = terrain(2, 1.0, [&](double x, double y) { return height * (1.0 - std::max(std::abs(x), std::abs(y))); });
  Mesh pyramid = mesh;
  pyramid.triangles.clear();
  for (const auto& [a, b] : {std::pair{0u, 2u}, {2u, 8u}, {8u, 6u}, {6u, 0u}}) pyramid.triangles.emplace_back(a, b, 4u);
  const HeightField field = baked(pyramid, 64);
  const double scale = 1.0 / std::hypot(1.0, height), cell = cellSize(field).x;
  for (const glm::dvec3& p : randomPoints({glm::dvec3(-0.9, -0.9, 0.0), glm::dvec3(0.9, 0.9, 0.3)}, 2000, 8)) {
    const double outer = std::max(std::abs(p.x), std::abs(p.y));
    // Away from the ridges, where the nearest point is on the face below and what is blurred from that height is too, its distance is
    // exact.
    if (outer - std::min(std::abs(p.x), std::abs(p.y)) < 2.0 * cell + 2.0 * kSheetBlur * p.z) continue;
    const glm::dvec3 at(p.x, p.y, p.z + height * (1.0 - outer));
    if (at.z > height) continue;  // beyond the box the distance is a bound
    EXPECT_NEAR(sampleHeightField(field, at), p.z * scale, 2e-3) << at.x << " " << at.y << " " << at.z;
  }
}

TEST(BakeHeightField, FlattenedEllipsoidIsAPair) {
  Mesh mesh = icosphere(1.0, 5);
  for (glm::dvec3& p : mesh.positions) p = {p.x, 0.3 * p.y, 0.8 * p.z};
  const auto view = bestHeightView(mesh).value();
  EXPECT_TRUE(view.pair);
  EXPECT_GT(std::abs(view.localFromField[2].y), 0.999);
  const HeightField field = bakeHeightField(mesh, view, 128).value();
  const std::vector<glm::dvec3> points = randomPoints({glm::dvec3(-1.2, -0.5, -1.0), glm::dvec3(1.2, 0.5, 1.0)}, 4000, 2);
  const std::vector<double> exact = distance(mesh, points);
  double near = 0.0, worst = 0.0;
  int count = 0, wrong = 0;
  for (std::size_t n = 0; n < points.size(); ++n) {
    const glm::dvec3 unit = points[n] / glm::dvec3(1.0, 0.3, 0.8);
    const double truth = glm::length(unit) < 1.0 ? -exact[n] : exact[n], value = sampleHeightField(field, points[n]);
    if (exact[n] > 0.02) wrong += (value < 0.0) != (truth < 0.0);
    if (exact[n] > 0.1) continue;
    near += (value - truth) * (value - truth);
    worst = std::max(worst, std::abs(value - truth));
    ++count;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(std::sqrt(near / count), 0.012);
  EXPECT_LT(worst, 0.1);
}

TEST(BakeHeightField, BeyondTheOutlineOfAPairTheDistanceIsNeverMoreThanTrue) {
  Mesh mesh = icosphere(1.0, 4);
  for (glm::dvec3& p : mesh.positions) p.y *= 0.3;
  const HeightField field = baked(mesh, 64);
  for (const double x : {0.8, 0.9, 0.99})
    for (const double y : {-0.1, 0.0, 0.1}) {
      const glm::dvec3 p(x, y, x);  // in the box's corner
      const double exact = distance(mesh, std::span(&p, 1))[0], value = sampleHeightField(field, p);
      EXPECT_GT(value, 0.6 * exact);
      EXPECT_LT(value, exact + 2.0 * cellSize(field).x);
    }
}

TEST(BakeHeightField, HolesOfTerrainAreFilled) {
  const Mesh mesh = withHoles(terrain(64, 1.0, [](double, double) { return 0.0; }), 0.03, 4);
  const HeightField field = baked(mesh, 64);
  const float level = field.front[0][32 + 64 * 32].mean;
  for (std::size_t j = 8; j < 56; ++j)
    for (std::size_t i = 8; i < 56; ++i) EXPECT_NEAR(field.front[0][i + 64 * j].mean, level, 1e-3f);
}

TEST(BakeHeightField, OtherMeshesAreRefusedWithTheirShare) {
  const Mesh knot = torusMesh(1.0, 0.3, 48, 24);
  EXPECT_EQ(reasonAgainst(knot), "") << "a torus is a pair";
  Mesh linked = knot;
  for (glm::dvec3& p : linked.positions) p = glm::dvec3(p.y + 1.0, p.x, p.z);
  EXPECT_NE(reasonAgainst(joined(knot, linked)).find("% of the surface is seen"), std::string::npos) << reasonAgainst(joined(knot, linked));
  EXPECT_NE(reasonAgainst(joined(icosphere(1.0, 3), insideOut(icosphere(0.5, 3)))).find("% of the surface is seen"), std::string::npos);
  EXPECT_EQ(reasonAgainst(Mesh{}), "mesh has no triangle");
  Mesh point;
  point.positions = {glm::dvec3(1.0)};
  point.triangles = {{0, 0, 0}};
  EXPECT_EQ(reasonAgainst(point), "mesh has no extent");
  Mesh line = point;
  line.positions = {glm::dvec3(0.0), glm::dvec3(1.0), glm::dvec3(2.0)};
  line.triangles = {{0, 1, 2}};
  EXPECT_NE(reasonAgainst(line), "");
  for (const int resolution : {0, 4, 24, 512}) EXPECT_FALSE(bakeHeightField(terrain(4, 1.0, hills), resolution).ok());
}

TEST(BakeHeightField, SameForAnyThreadCountAndOrder) {
  Mesh mesh = terrain(40, 0.7, hills);
  const HeightField plain = bakeHeightField(mesh, HeightView{}, 64).value();
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const HeightField other = bakeHeightField(mesh, HeightView{}, 64).value();
    EXPECT_EQ(other.origin, plain.origin);
    for (std::size_t n = 0; n < plain.front[0].size(); ++n) {
      ASSERT_EQ(other.front[0][n].mean, plain.front[0][n].mean);
      ASSERT_EQ(other.front[0][n].variance, plain.front[0][n].variance);
    }
    EXPECT_EQ(bestHeightView(mesh).value().localFromField, bestHeightView(terrain(40, 0.7, hills)).value().localFromField);
  }
}

TEST(BakeHeightField, RealTerrain) {
  const std::filesystem::path folder = std::filesystem::path(OVERCAST_SOURCE_FOLDER) / "../shared/meshes/terrain";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no ../shared/meshes/terrain here";
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (isMeshFile(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const Mesh mesh = readMesh(file).value().mesh;
    const auto view = bestHeightView(mesh);
    ASSERT_TRUE(view.ok()) << file << ": " << message(view.error());
    EXPECT_FALSE(view.value().pair);
    const double size = diagonal(bounds(mesh));
    // Near the middle of every triangle, on the side it faces.
    std::vector<glm::dvec3> points;
    for (std::size_t n = 0; n < mesh.triangles.size(); n += 7) {
      const glm::uvec3 t = mesh.triangles[n];
      const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
      const double share = static_cast<double>(n % 5) / 4.0;
      points.push_back((a + b + c) / 3.0 + 0.02 * share * size * view.value().localFromField[2]);
    }
    const std::vector<double> exact = distanceAt(mesh, points);
    for (const int resolution : {16, 32, 64, 128}) {
      const HeightField field = bakeHeightField(mesh, view.value(), resolution).value();
      double squares = 0.0;
      for (std::size_t n = 0; n < points.size(); ++n) squares += std::pow(sampleHeightField(field, points[n]) - exact[n], 2.0);
      const double rms = std::sqrt(squares / static_cast<double>(points.size())) / size;
      const glm::dvec3 axis = view.value().localFromField[2];
      std::printf("%-32s axis (%.2f %.2f %.2f) seen %.4f flat %.2f  %3d: rms near the surface %.3f %% of the diagonal, lipschitz %.1f\n",
                  file.filename().c_str(), axis.x, axis.y, axis.z, view.value().seen, view.value().flatness, resolution, 100.0 * rms,
                  lipschitzBound(field));
      if (resolution == 128) {
        EXPECT_LT(rms, 0.01);
      }
    }
  }
}

}  // namespace
}  // namespace overcast
