// Meshes of terrains: what is shown at every level is the whole of it, without cracks, as near as it says; and what its points see.
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bake/aperture.h"
#include "bake/terrain_mesh.h"
#include "formats/scene.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

Terrain terrainOf(int columns, int rows, const std::function<double(double, double)>& height, double spacing = 1.0) {
  Terrain terrain;
  terrain.columns = columns;
  terrain.rows = rows;
  terrain.spacing = glm::dvec2(spacing);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) terrain.heights.push_back(static_cast<float>(height(column, row)));
  return terrain;
}

double rugged(double x, double y) {
  double sum = 0.02 * x - 0.01 * y;
  for (const double f : {0.05, 0.13, 0.37, 1.1}) sum += 0.9 / f * std::sin(f * x + 2.0 * std::cos(0.7 * f * y)) * std::cos(f * y);
  return sum;
}

Mesh meshOf(const Terrain& terrain) {
  auto mesh = terrainMesh(terrain);
  EXPECT_TRUE(mesh) << message(mesh.error());
  return mesh ? std::move(mesh).value() : Mesh{};
}

using Rating = std::function<double(const LevelGroup&)>;

/// Rule 1 of formats/terrain_levels.h, spelled out anew: the triangles shown at threshold t, and the largest error they may have.
struct Shown {
  std::vector<glm::uvec3> triangles;
  double error = 0.0;
};
Shown shownAt(const Mesh& mesh, const Rating& f, double t) {
  Shown shown;
  std::vector<glm::uvec3> all = mesh.triangles;
  all.insert(all.end(), mesh.levels->triangles.begin(), mesh.levels->triangles.end());
  for (const LevelCluster& cluster : mesh.levels->clusters) {
    const double own = cluster.own == kNoLevelGroup ? 0.0 : f(mesh.levels->groups[cluster.own]);
    if (own > t || (cluster.coarser != kNoLevelGroup && f(mesh.levels->groups[cluster.coarser]) <= t)) continue;
    if (cluster.own != kNoLevelGroup) shown.error = std::max(shown.error, double{mesh.levels->groups[cluster.own].error});
    shown.triangles.insert(shown.triangles.end(), all.begin() + cluster.firstTriangle,
                           all.begin() + cluster.firstTriangle + cluster.triangleCount);
  }
  return shown;
}

/// Seen from above: twice the area of a triangle, positive where it faces up.
double planArea(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a = mesh.positions[t.y] - mesh.positions[t.x], b = mesh.positions[t.z] - mesh.positions[t.x];
  return a.z * b.x - a.x * b.z;
}

/// Edges that no other triangle shares in the opposite direction, as pairs of vertices.
std::vector<std::pair<std::uint32_t, std::uint32_t>> openEdges(const std::vector<glm::uvec3>& triangles) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges, open;
  for (const glm::uvec3& t : triangles)
    for (int c = 0; c < 3; ++c) edges.emplace_back(t[c], t[(c + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  EXPECT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end()) << "an edge twice in one direction";
  for (const auto& [a, b] : edges)
    if (!std::binary_search(edges.begin(), edges.end(), std::pair(b, a))) open.emplace_back(a, b);
  return open;
}

/// Several ways to rate groups: their error, and that seen from places near and far.
std::vector<Rating> ratings(const Mesh& mesh) {
  std::vector<Rating> all = {[](const LevelGroup& g) { return double{g.error}; }};
  const Box box = bounds(mesh);
  for (const double a : {0.1, 0.5, 0.83}) {
    const glm::dvec3 eye = box.min + extent(box) * glm::dvec3(a, 1.1, 1.0 - 0.9 * a);
    all.push_back([eye](const LevelGroup& g) {
      const double distance = glm::length(glm::dvec3(g.centre) - eye) - double{g.radius};
      return g.error == 0.0f ? 0.0 : distance > 0.0 ? double{g.error} / distance : std::numeric_limits<double>::infinity();
    });
  }
  return all;
}

void expectWhole(const Terrain& terrain) {
  const Mesh mesh = meshOf(terrain);
  ASSERT_TRUE(mesh.levels);
  ASSERT_EQ(brokenLevels(*mesh.levels, mesh.positions.size(), mesh.triangles.size()), "");
  const glm::dvec2 half = 0.5 * terrain.spacing * glm::dvec2(terrain.columns - 1, terrain.rows - 1);
  std::size_t fewest = mesh.triangles.size();
  for (const Rating& f : ratings(mesh))
    for (const double t : {0.0, 0.003, 0.05, 0.4, 5.0, 1e9}) {
      const Shown shown = shownAt(mesh, f, t);
      fewest = std::min(fewest, shown.triangles.size());
      double area = 0.0;
      for (const glm::uvec3& triangle : shown.triangles) {
        ASSERT_GT(planArea(mesh, triangle), 0.0);
        area += 0.5 * planArea(mesh, triangle);
      }
      EXPECT_NEAR(area, 4.0 * half.x * half.y, 1e-9 * area) << t;
      for (const auto& [a, b] : openEdges(shown.triangles)) {
        const glm::dvec3 &p = mesh.positions[a], &q = mesh.positions[b];
        const bool side = (std::abs(p.x) == half.x && p.x == q.x) || (std::abs(p.z) == half.y && p.z == q.z);
        ASSERT_TRUE(side) << "a crack at threshold " << t << " between " << a << " and " << b;
      }
    }
  EXPECT_LT(fewest, mesh.triangles.size() / 4);
}

TEST(TerrainMesh, hasNoCracksBetweenAnyLevels) {
  expectWhole(terrainOf(129, 129, rugged));
  expectWhole(terrainOf(150, 97, rugged, 3.0));
  expectWhole(terrainOf(33, 301, rugged));
}

TEST(TerrainMesh, isTheGridAtItsFinest) {
  const Terrain terrain = terrainOf(45, 70, rugged, 2.5);
  const Mesh mesh = meshOf(terrain);
  ASSERT_EQ(mesh.positions.size(), terrain.heights.size());
  EXPECT_EQ(mesh.triangles.size(), 2u * 44u * 69u);
  double lowest = 1e9;
  for (const float h : terrain.heights) lowest = std::min(lowest, double{h});
  for (int row = 0; row < terrain.rows; ++row)
    for (int column = 0; column < terrain.columns; ++column) {
      const auto i = static_cast<std::size_t>(row * terrain.columns + column);
      const glm::dvec3 expected((column - 22.0) * 2.5, double{terrain.heights[i]} - lowest, (row - 34.5) * 2.5);
      ASSERT_LT(glm::length(mesh.positions[i] - expected), 1e-9) << i;
      ASSERT_NEAR(glm::length(mesh.normals[i]), 1.0f, 1e-5f);
      ASSERT_GT(mesh.normals[i].y, 0.0f);
      ASSERT_NEAR(mesh.textureCoordinates[i].x * 45.0f, static_cast<float>(column) + 0.5f, 1e-3f);
      ASSERT_NEAR(mesh.textureCoordinates[i].y * 70.0f, static_cast<float>(row) + 0.5f, 1e-3f);
    }
}

TEST(TerrainMesh, staysWithinItsError) {
  const Terrain terrain = terrainOf(150, 97, rugged, 3.0);
  const Mesh mesh = meshOf(terrain);
  const double lowest = double{*std::min_element(terrain.heights.begin(), terrain.heights.end())};
  double coarsest = 0.0;
  for (const double t : {0.05, 0.5, 2.0, 8.0, 1e9}) {
    const Shown shown = shownAt(mesh, ratings(mesh)[0], t);
    EXPECT_LE(shown.error, t);
    double worst = 0.0;
    // Every sample under every triangle, by its weights: no search and no tree.
    for (const glm::uvec3& triangle : shown.triangles) {
      const std::array<glm::dvec3, 3> p = {mesh.positions[triangle.x], mesh.positions[triangle.y], mesh.positions[triangle.z]};
      const auto column = [&](double x) { return x / 3.0 + 74.5; };
      const auto row = [&](double z) { return z / 3.0 + 48.0; };
      const double area = planArea(mesh, triangle);
      const auto [left, right] = std::minmax({column(p[0].x), column(p[1].x), column(p[2].x)});
      const auto [top, bottom] = std::minmax({row(p[0].z), row(p[1].z), row(p[2].z)});
      for (int y = static_cast<int>(std::lround(top)); y <= std::lround(bottom); ++y)
        for (int x = static_cast<int>(std::lround(left)); x <= std::lround(right); ++x) {
          const glm::dvec2 at((x - 74.5) * 3.0, (y - 48.0) * 3.0);
          double height = 0.0, least = 1.0;
          for (std::size_t c = 0; c < 3; ++c) {
            const glm::dvec3 &a = p[(c + 1) % 3], &b = p[(c + 2) % 3];
            const double weight = ((a.z - at.y) * (b.x - at.x) - (a.x - at.x) * (b.z - at.y)) / area;
            least = std::min(least, weight);
            height += weight * p[c].y;
          }
          if (least < -1e-9) continue;
          const double truth = double{terrain.heights[static_cast<std::size_t>(y * terrain.columns + x)]} - lowest;
          worst = std::max(worst, std::abs(height - truth));
        }
    }
    EXPECT_LE(worst, shown.error * (1.0 + 1e-6) + 1e-9);
    EXPECT_GE(worst, 0.5 * shown.error) << "far from tight at " << t;
    coarsest = std::max(coarsest, worst);
  }
  EXPECT_GT(coarsest, 1.0);
}

TEST(TerrainMesh, spendsNothingOnPlanes) {
  const Mesh mesh = meshOf(terrainOf(257, 257, [](double x, double y) { return 0.25 * x - 0.5 * y; }));
  EXPECT_EQ(mesh.triangles.size(), 2u * 256u * 256u);
  const Shown shown = shownAt(mesh, ratings(mesh)[0], 1e-9);
  EXPECT_LE(shown.triangles.size(), 2u * kClusterTriangles);
  EXPECT_EQ(shown.error, 0.0);
}

TEST(TerrainMesh, endsWhereHeightsEnd) {
  // A disc of heights with a bite: no triangle beyond it, and what is open lies at the outline.
  const auto inside = [](double x, double y) {
    return (x - 60) * (x - 60) + (y - 50) * (y - 50) < 48 * 48 && !((x - 100) * (x - 100) + (y - 50) * (y - 50) < 400);
  };
  const Terrain terrain = terrainOf(121, 101, [&](double x, double y) { return inside(x, y) ? rugged(x, y) : std::nan(""); });
  const Mesh mesh = meshOf(terrain);
  for (const Rating& f : ratings(mesh))
    for (const double t : {0.0, 0.1, 1.0, 4.0}) {
      const Shown shown = shownAt(mesh, f, t);
      for (const glm::uvec3& triangle : shown.triangles) ASSERT_GT(planArea(mesh, triangle), 0.0);
      for (const auto& edge : openEdges(shown.triangles))
        for (const std::uint32_t v : {edge.first, edge.second}) {
          // A vertex at the outline has a sample without height beside it.
          const int x = static_cast<int>(std::lround(mesh.positions[v].x + 60.0)),
                    y = static_cast<int>(std::lround(mesh.positions[v].z + 50.0));
          bool outline = t >= 1.0;  // coarse outlines may cut corners: they say so in their error
          for (int j = -2; j <= 2; ++j)
            for (int i = -2; i <= 2; ++i) outline = outline || !inside(x + i, y + j);
          ASSERT_TRUE(outline) << x << ", " << y << " at " << t;
        }
    }
}

TEST(TerrainMesh, needsThreeHeights) {
  Terrain terrain = terrainOf(5, 4, [](double x, double y) { return x == y ? 1.0 : std::nan(""); });
  const auto mesh = terrainMesh(terrain);
  ASSERT_FALSE(mesh);
  EXPECT_EQ(mesh.error().reason, "has no three heights beside each other");
}

TEST(TerrainMesh, comesBackFromItsFile) {
  const auto scene = sceneFromTerrain(terrainOf(70, 50, rugged), "hills");
  ASSERT_TRUE(scene);
  const fs::path folder = fs::temp_directory_path() / "overcast-terrain-levels";
  const auto written = writeScene(folder / "hills.gltf", scene.value());
  ASSERT_TRUE(written) << message(written.error());
  const auto read = readScene(folder / "hills.gltf");
  fs::remove_all(folder);
  ASSERT_TRUE(read) << message(read.error());
  const MeshLevels &before = *scene.value().meshes[0].levels, &after = read.value().meshes[0].levels.value();
  EXPECT_EQ(after.triangles, before.triangles);
  ASSERT_EQ(after.groups.size(), before.groups.size());
  ASSERT_EQ(after.clusters.size(), before.clusters.size());
  for (std::size_t g = 0; g < before.groups.size(); ++g) {
    EXPECT_EQ(after.groups[g].error, before.groups[g].error);
    EXPECT_EQ(after.groups[g].centre, before.groups[g].centre);
    EXPECT_EQ(after.groups[g].radius, before.groups[g].radius);
  }
  for (std::size_t c = 0; c < before.clusters.size(); ++c) {
    EXPECT_EQ(after.clusters[c].own, before.clusters[c].own);
    EXPECT_EQ(after.clusters[c].coarser, before.clusters[c].coarser);
    EXPECT_EQ(after.clusters[c].triangleCount, before.clusters[c].triangleCount);
  }
}

TEST(TerrainGaps, areFilledWithTheSmoothSurface) {
  // On a slope, and on the saddle x y, the mean of four neighbours is the height itself.
  const auto saddle = [](double x, double y) { return 0.02 * (x - 20.0) * (y - 15.0) + 0.5 * x; };
  Terrain terrain = terrainOf(48, 40, saddle);
  std::uint64_t gaps = 0;
  for (int y = 8; y < 27; ++y)
    for (int x = 10; x < 33; ++x, ++gaps) terrain.heights[static_cast<std::size_t>(y * 48 + x)] = std::nanf("");
  for (int x = 40; x < 48; ++x) terrain.heights[static_cast<std::size_t>(20 * 48 + x)] = std::nanf("");  // reaches the border
  EXPECT_EQ(fillGaps(terrain), gaps);
  for (int y = 8; y < 27; ++y)
    for (int x = 10; x < 33; ++x) ASSERT_NEAR(double{terrain.heights[static_cast<std::size_t>(y * 48 + x)]}, saddle(x, y), 5e-3);
  EXPECT_TRUE(std::isnan(terrain.heights[20 * 48 + 44]));
}

/// What the vertex nearest to a place of the grid sees.
struct Seen {
  double visible;
  glm::dvec3 direction;
  double ambient;
};
Seen seenAt(const Mesh& mesh, const BakedApertures& baked, const glm::dvec2& ground) {
  std::size_t nearest = 0;
  const auto distance = [&](std::size_t i) { return glm::length(glm::dvec2(mesh.positions[i].x, mesh.positions[i].z) - ground); };
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    if (distance(i) < distance(nearest)) nearest = i;
  const Aperture& aperture = baked.visibility.apertures[nearest];
  const double s = std::sin(0.5 * double{aperture.radius});
  return {2.0 * s * s, glm::dvec3(aperture.direction), double{baked.visibility.ambient[nearest]}};
}

BakedApertures aperturesOf(const Mesh& mesh) {
  ApertureSettings settings;
  settings.visibility.rays = 1024;
  settings.bits = ApertureBits::packed64;
  settings.errorSamples = 0;
  auto baked = bakeApertures(mesh, settings);
  EXPECT_TRUE(baked);
  return std::move(baked).value();
}

TEST(TerrainApertures, ofAPlaneAreWideOpenUpToItsBorder) {
  const Mesh mesh = meshOf(terrainOf(40, 30, [](double x, double y) { return 0.3 * x + 0.2 * y; }));
  const BakedApertures baked = aperturesOf(mesh);
  EXPECT_EQ(baked.report.interior, 0u);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(-0.3, 1.0, -0.2));
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    ASSERT_NEAR(baked.visibility.apertures[i].radius, std::numbers::pi_v<float> / 2.0f, 1e-3f) << i;
    ASSERT_LT(glm::length(glm::dvec3(baked.visibility.apertures[i].direction) - normal), 2e-3) << i;
  }
}

TEST(TerrainApertures, ofAPitAreThePyramidOfItsSky) {
  // At the bottom of four equal slopes, tan a steep, the sky is a pyramid with half an opening of b = pi / 2 - a: 4 asin(sin^2 b) of solid
  // angle, and of the cosine-weighted half what a square ceiling of half side tan b takes (Howell, factor B-3, four times).
  for (const double a : {0.3, 0.7, 1.0}) {
    const auto pit = [&](double x, double y) { return std::tan(a) * std::max(std::abs(x - 31.0), std::abs(y - 31.0)); };
    const Mesh mesh = meshOf(terrainOf(63, 63, pit));  // diagonals run through places with odd numbers, as the pit's edges
    const Seen seen = seenAt(mesh, aperturesOf(mesh), {0.0, 0.0});
    const double b = 0.5 * std::numbers::pi - a;
    EXPECT_NEAR(seen.visible, 4.0 * std::asin(std::sin(b) * std::sin(b)) / (2.0 * std::numbers::pi), 0.005) << a;
    EXPECT_NEAR(seen.ambient, 4.0 / std::numbers::pi * std::sin(b) * std::atan(std::sin(b)), 0.005) << a;
    EXPECT_GT(seen.direction.y, 0.999) << a;
  }
}

TEST(TerrainApertures, ofAValleyAreTheWedgeBetweenItsSides) {
  // At the bottom between two slopes that rise by an angle a to both sides, a wedge of pi - 2 a is open: 1 - 2 a / pi of the hemisphere.
  // On a slope the far side is no higher, so not less is seen, and it leans to that side.
  const double a = 0.5;
  const Mesh mesh = meshOf(terrainOf(33, 401, [&](double x, double) { return std::tan(a) * std::abs(x - 16.0); }));
  const BakedApertures baked = aperturesOf(mesh);
  const Seen bottom = seenAt(mesh, baked, {0.0, 0.0}), slope = seenAt(mesh, baked, {4.0, 0.0});
  EXPECT_NEAR(bottom.visible, 1.0 - 2.0 * a / std::numbers::pi, 0.012);
  EXPECT_GT(bottom.direction.y, 0.999);
  // Cosine-weighted at the bottom: the wedge about its normal: cos a.
  EXPECT_NEAR(bottom.ambient, std::cos(a), 0.012);
  EXPECT_LT(slope.visible, 0.95);
  EXPECT_GT(slope.visible, bottom.visible + 0.01);
  EXPECT_LT(slope.direction.x, -0.05);
}

TEST(TerrainApertures, ofARavineDoNotStartBehindItsWalls) {
  // At the bottom between walls of 6 and 30 to 1 the larger triangles of the steeper wall turn the normal into the other wall. What is open
  // is the wedge between them, which lies within the hemisphere about that normal.
  const Mesh mesh = meshOf(terrainOf(17, 401, [](double x, double) { return x < 8.0 ? 6.0 * (8.0 - x) : 30.0 * (x - 8.0); }));
  const BakedApertures baked = aperturesOf(mesh);
  EXPECT_EQ(baked.report.interior, 0u);
  EXPECT_EQ(baked.report.inward, 0u);
  const Seen bottom = seenAt(mesh, baked, {0.0, 0.0});
  const double open = std::numbers::pi - std::atan(6.0) - std::atan(30.0);
  EXPECT_NEAR(bottom.visible, open / std::numbers::pi, 0.006);
  const double middle = 0.5 * (std::atan(30.0) + std::numbers::pi - std::atan(6.0));
  EXPECT_NEAR(bottom.direction.x, std::cos(middle), 0.02);
}

TEST(TerrainMesh, ofMountSaintHelensIsWhole) {
  const fs::path file = fs::path(OVERCAST_SOURCE_FOLDER) / "../shared/meshes/terrain/sthelens_usgs.dem";
  if (!fs::exists(file)) GTEST_SKIP() << "no ../shared/meshes/terrain here";
  const auto terrain = readTerrain(file);
  ASSERT_TRUE(terrain) << message(terrain.error());
  const Mesh mesh = meshOf(terrain.value());
  ASSERT_EQ(brokenLevels(*mesh.levels, mesh.positions.size(), mesh.triangles.size()), "");
  std::size_t last = mesh.triangles.size() + 1;
  for (const double t : {0.0, 5.0, 20.0, 80.0}) {
    const Shown shown = shownAt(mesh, ratings(mesh)[0], t);
    openEdges(shown.triangles);  // no edge twice
    EXPECT_LT(shown.triangles.size(), last) << t;
    last = shown.triangles.size();
  }
}

}  // namespace
}  // namespace overcast
