// Aperture maps: charts, atlases, and what is baked into texels, against closed forms and brute force.
#include "bake/aperture_map.h"

#include <cmath>
#include <numbers>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bake/chart_atlas.h"
#include "bake/chart_raster.h"
#include "formats/normals.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using testing::HasSubstr;

ApertureMapSettings settingsOf(int texels, bool atlas = false, int rays = 256) {
  ApertureMapSettings settings;
  settings.texels = texels;
  settings.atlas = atlas;
  settings.visibility.rays = rays;
  settings.errorSamples = 1024;
  return settings;
}

/// A quad of two triangles through these corners, over a rectangle of the texture.
void addQuad(Mesh& mesh, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d, glm::vec2 low,
             glm::vec2 high) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c, d});
  mesh.textureCoordinates.insert(mesh.textureCoordinates.end(), {low, {high.x, low.y}, high, {low.x, high.y}});
  const glm::vec3 normal(glm::normalize(glm::cross(b - a, d - a)));
  mesh.normals.insert(mesh.normals.end(), 4, normal);
  mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
  mesh.parts = {{0, static_cast<std::uint32_t>(mesh.triangles.size()), -1}};
}

Mesh plane(glm::vec2 low = {0.1f, 0.2f}, glm::vec2 high = {0.7f, 0.9f}) {
  Mesh mesh;
  addQuad(mesh, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, low, high);
  return mesh;
}

BakedApertureMap baked(Mesh& mesh, const ApertureMapSettings& settings) {
  auto result = bakeApertureMap(mesh, settings);
  EXPECT_TRUE(result) << message(result.error());
  return result ? std::move(result).value() : BakedApertureMap{};
}

std::string errorOf(Mesh mesh, const ApertureMapSettings& settings) {
  const auto result = bakeApertureMap(mesh, settings);
  return result ? "" : result.error().reason;
}

TEST(ApertureMapBake, APlaneSeesEverythingInEveryTexelOfTheMap) {
  Mesh mesh = plane();
  const BakedApertureMap map = baked(mesh, settingsOf(64));
  ASSERT_TRUE(isWhole(map.map));
  for (const std::vector<ApertureTexel>& level : map.map.levels)
    for (const ApertureTexel& texel : level) {  // the gaps too: nothing dark lies about the chart
      ASSERT_EQ(texel.aperture.radius, capRadius(1.0));
      ASSERT_EQ(texel.ambient, 1.0f);
      ASSERT_EQ(texel.aperture.direction, glm::vec3(0, 0, 1));
    }
  double coverage = 0.0;
  for (const ApertureTexel& texel : map.map.levels[0]) coverage += double{texel.coverage};
  EXPECT_NEAR(coverage / (64.0 * 64.0), 0.6 * 0.7, 1e-3);
  EXPECT_EQ(map.report.charts, 1u);
  EXPECT_EQ(map.report.levels, static_cast<int>(map.map.levels.size()));
  EXPECT_EQ(map.report.error.radius, 0.0);
}

// The floor of a trench with walls of the same height at both sides, endless along y: seen from the floor, a point at x sees the sky
// between the elevations of the two edges. In the plane across the trench the visible directions are an interval of angles; of a straight
// trench the cosine-weighted visibility is half the difference of the sines of the angles to the vertical, (sin a + sin b) / 2.
TEST(ApertureMapBake, TheFloorOfATrenchSeesWhatTheClosedFormSays) {
  Mesh mesh;
  const double half = 0.5, height = 0.6, far = 60.0;
  addQuad(mesh, {-half, -far, 0}, {half, -far, 0}, {half, far, 0}, {-half, far, 0}, {0.02f, 0.02f}, {0.48f, 0.98f});
  addQuad(mesh, {half, -far, 0}, {half, -far, height}, {half, far, height}, {half, far, 0}, {0.52f, 0.02f}, {0.72f, 0.98f});
  addQuad(mesh, {-half, -far, height}, {-half, -far, 0}, {-half, far, 0}, {-half, far, height}, {0.76f, 0.02f}, {0.98f, 0.98f});
  const BakedApertureMap map = baked(mesh, settingsOf(64, false, 1024));
  for (double x = -0.45; x < 0.5; x += 0.09) {
    const double u = 0.02 + 0.46 * (x + half) / (2.0 * half);
    const ApertureTexel seen = sampleApertureMap(map.map, {u, 0.5});
    const double a = std::atan((half - x) / height), b = std::atan((half + x) / height);
    EXPECT_NEAR(seen.ambient, 0.5 * (std::sin(a) + std::sin(b)), 0.012) << x;
    // Uniform in solid angle, a wedge between two planes through the y axis holds its angle over pi of the hemisphere.
    EXPECT_NEAR(1.0 - std::cos(double{seen.aperture.radius}), (a + b) / std::numbers::pi, 0.012) << x;
    const double turned = 0.5 * (a - b);  // the middle of the wedge
    EXPECT_NEAR(std::atan2(double{seen.aperture.direction.x}, double{seen.aperture.direction.z}), turned, 0.03) << x;
  }
  // Up to the foot of the wall, where the nearest texels of other charts are dark or bright: half of the sky.
  const ApertureTexel foot = sampleApertureMap(map.map, {0.02 + 0.46 * 0.9999, 0.5});
  EXPECT_NEAR(foot.ambient, 0.5 * std::sin(std::atan(2.0 * half / height)), 0.03);
}

TEST(ApertureMapBake, OverlapIsFoundAndItsShareIsRight) {
  Mesh mesh = plane({0.0f, 0.0f}, {0.5f, 1.0f});
  addQuad(mesh, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {0.25f, 0.0f}, {0.75f, 1.0f});
  const ChartRaster raster = rasteriseCharts(mesh, {64, 64});
  EXPECT_EQ(raster.covered, 64u * 48u);
  EXPECT_EQ(raster.overlapping, 64u * 16u);
  EXPECT_EQ(raster.charts, 2u);
  EXPECT_THAT(errorOf(mesh, settingsOf(64)), HasSubstr("overlap on 33.3 % of the texels they cover; --atlas"));
  EXPECT_EQ(errorOf(mesh, settingsOf(64, true)), "");
  // A mirrored half that shares its place in the texture.
  Mesh mirrored = plane();
  addQuad(mirrored, {2, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 1, 0}, {0.1f, 0.2f}, {0.7f, 0.9f});
  EXPECT_THAT(errorOf(mirrored, settingsOf(32)), HasSubstr("overlap on 100 %"));
}

TEST(ApertureMapBake, ChartsThatTouchOrRepeatDoNotOverlap) {
  // A grid whose inner edges lie anywhere within texels, in one chart; every triangle twice.
  Mesh mesh;
  for (int j = 0; j <= 7; ++j)
    for (int i = 0; i <= 7; ++i) {
      const glm::dvec2 p(i / 7.0 + 0.04 * std::sin(3.0 * i + 5.0 * j), j / 7.0 + 0.04 * std::cos(7.0 * i + 2.0 * j));
      mesh.positions.emplace_back(p, 0.0);
      mesh.textureCoordinates.push_back(glm::vec2(0.9 * p + 0.05));
    }
  for (std::uint32_t j = 0; j < 7; ++j)
    for (std::uint32_t i = 0; i < 7; ++i) {
      const std::uint32_t a = i + 8 * j;
      for (int twice = 0; twice < 2; ++twice) mesh.triangles.insert(mesh.triangles.end(), {{a, a + 1, a + 9}, {a, a + 9, a + 8}});
    }
  const ChartRaster raster = rasteriseCharts(mesh, {50, 41});
  EXPECT_GT(raster.covered, 50u * 41u * 7u / 10u);
  EXPECT_EQ(raster.overlapping, 0u);
  EXPECT_EQ(raster.charts, 1u);
}

TEST(ApertureMapBake, EveryTexelThatBilinearSamplingReadsHasTheNearestPointOfTheSurface) {
  Mesh mesh = reference::icosphere(1.0, 1);
  auto packed = packTriangles(mesh, 128);
  ASSERT_TRUE(packed) << message(packed.error());
  const ChartRaster raster = rasteriseCharts(packed.value(), {128, 128});
  for (const SurfaceSample& sample : sampleSurface(packed.value(), 3000, 5)) {
    glm::dvec2 at(0.0);
    for (int c = 0; c < 3; ++c)
      at += sample.weight[c] * glm::dvec2(packed.value().textureCoordinates[packed.value().triangles[sample.triangle][c]]);
    at = at * 128.0 - 0.5;
    for (int corner = 0; corner < 4; ++corner) {
      const int i = static_cast<int>(std::floor(at.x)) + corner % 2, j = static_cast<int>(std::floor(at.y)) + corner / 2;
      const double weight = (1.0 - std::abs(at.x - i)) * (1.0 - std::abs(at.y - j));
      if (weight < 1e-4) continue;
      // Sampling a triangle reads what was seen from that triangle alone.
      EXPECT_EQ(raster.sites[static_cast<std::size_t>(i + 128 * j)].at.triangle, sample.triangle);
    }
  }
}

TEST(ApertureMapBake, AtlasesHoldEveryTriangleOnceAtAboutTheSameScale) {
  Mesh sliver = reference::torusMesh(1.0, 0.2, 40, 12);
  sliver.positions[0] += glm::dvec3(0.0, 0.0, 3.0);
  for (const Mesh& mesh : {reference::icosphere(1.0, 3), reference::boxMesh({1.0, 2.0, 0.01}), sliver}) {
    const int side = 256;
    auto packed = packTriangles(mesh, side);
    ASSERT_TRUE(packed) << message(packed.error());
    const Mesh& atlas = packed.value();
    ASSERT_EQ(atlas.triangles.size(), mesh.triangles.size());
    ASSERT_EQ(atlas.positions.size(), 3 * mesh.triangles.size());
    EXPECT_EQ(atlas.parts.size(), mesh.parts.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int c = 0; c < 3; ++c) EXPECT_EQ(atlas.positions[atlas.triangles[t][c]], mesh.positions[mesh.triangles[t][c]]);
    const ChartRaster raster = rasteriseCharts(atlas, glm::ivec2(side));
    EXPECT_EQ(raster.overlapping, 0u);
    EXPECT_EQ(raster.charts, mesh.triangles.size());
    std::set<std::uint32_t> seen;
    for (const TexelSite& site : raster.sites)
      if (site.coverage > 0.0f) seen.insert(site.at.triangle);
    EXPECT_EQ(seen.size(), mesh.triangles.size());
    for (const glm::vec2& c : atlas.textureCoordinates) EXPECT_TRUE(c.x > 0.0f && c.y > 0.0f && c.x < 1.0f && c.y < 1.0f);
    EXPECT_GT(raster.covered, static_cast<std::uint64_t>(side * side / 4)) << "most of the atlas lies idle";
    const auto again = packTriangles(mesh, side);
    EXPECT_EQ(again.value().textureCoordinates, atlas.textureCoordinates);
  }
}

TEST(ApertureMapBake, AnAtlasThatIsTooSmallNamesTheSizeThatDoes) {
  const Mesh mesh = reference::icosphere(1.0, 4);  // 5,120 triangles
  const int enough = smallestAtlas(mesh.triangles.size());
  EXPECT_TRUE(packTriangles(mesh, enough));
  const auto small = packTriangles(mesh, enough / 2);
  ASSERT_FALSE(small);
  EXPECT_THAT(small.error().reason, HasSubstr(fmt::format("--texels {} holds them", enough)));
}

TEST(ApertureMapBake, ConvexMeshesInAnAtlasAreOpenEverywhere) {
  for (Mesh mesh : {reference::boxMesh({1.0, 2.0, 0.3}), reference::icosphere(1.0, 2)}) {
    const BakedApertureMap map = baked(mesh, settingsOf(128, true, 128));
    for (const ApertureTexel& texel : map.map.levels[0]) {
      ASSERT_EQ(texel.ambient, 1.0f);
      ASSERT_EQ(texel.aperture.radius, capRadius(1.0));
    }
    EXPECT_EQ(map.report.error.ambient, 0.0);
    EXPECT_LT(map.report.error.direction, 0.02);
    EXPECT_EQ(map.report.interior, 0u);
  }
}

TEST(ApertureMapBake, PlaceAndScaleChangeNothing) {
  const auto mapOf = [](double scale, double offset) {
    Mesh mesh = withNormals(reference::torusMesh(1.0, 0.6, 24, 12));
    for (glm::dvec3& p : mesh.positions) p = scale * p + offset;
    return baked(mesh, settingsOf(128, true, 128)).map;
  };
  const ApertureMap first = mapOf(1.0, 0.0);
  for (const auto& [scale, offset] : {std::pair(1e-4, 0.0), std::pair(1e4, 0.0), std::pair(1.0, 4e5)}) {
    const ApertureMap other = mapOf(scale, offset);
    double squares = 0.0;
    for (std::size_t i = 0; i < first.levels[0].size(); ++i)
      squares += std::pow(double{first.levels[0][i].ambient - other.levels[0][i].ambient}, 2.0);
    EXPECT_LT(std::sqrt(squares / static_cast<double>(first.levels[0].size())), 0.002);
  }
}

TEST(ApertureMapBake, TexelsInSolidsAreFilledFromThoseAroundThem) {
  // A wall runs into a closed box: what of it is inside sees only backs.
  Mesh mesh = plane({0.05f, 0.05f}, {0.95f, 0.6f});
  Mesh box = withNormals(reference::boxMesh({0.15, 0.15, 0.15}));
  for (glm::dvec3& p : box.positions) p += glm::dvec3(0.5, 0.5, 0.0);
  for (std::size_t i = 0; i < box.positions.size(); ++i)
    box.textureCoordinates.emplace_back(0.05f + 0.9f * static_cast<float>(i % 5) / 5.0f, 0.7f + 0.02f * static_cast<float>(i / 5));
  const std::vector<glm::vec2> unwrapped = [&] {  // every face a little quad
    std::vector<glm::vec2> c;
    for (std::size_t i = 0; i < box.positions.size(); ++i) {
      const glm::vec3 n = glm::abs(box.normals[i]);
      const int axis = n.x > 0.5f ? 0 : n.y > 0.5f ? 1 : 2;
      const glm::dvec3 p = (box.positions[i] - glm::dvec3(0.5, 0.5, 0.0)) / 0.3 + 0.5;
      const int face = 2 * axis + (box.normals[i][axis] > 0.0f);
      c.emplace_back(0.05 + 0.15 * face + 0.1 * p[(axis + 1) % 3], 0.7 + 0.2 * p[(axis + 2) % 3]);
    }
    return c;
  }();
  box.textureCoordinates = unwrapped;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), box.positions.begin(), box.positions.end());
  mesh.normals.insert(mesh.normals.end(), box.normals.begin(), box.normals.end());
  mesh.textureCoordinates.insert(mesh.textureCoordinates.end(), box.textureCoordinates.begin(), box.textureCoordinates.end());
  for (const glm::uvec3& t : box.triangles) mesh.triangles.push_back(t + first);
  mesh.parts[0].triangleCount = static_cast<std::uint32_t>(mesh.triangles.size());
  const BakedApertureMap map = baked(mesh, settingsOf(64));
  EXPECT_GT(map.report.interior, 100u);
  const ApertureTexel inside = sampleApertureMap(map.map, {0.05 + 0.9 * 0.5, 0.05 + 0.55 * 0.5});
  EXPECT_GT(inside.ambient, 0.3f);
  EXPECT_GT(inside.aperture.direction.z, 0.5f);
}

TEST(ApertureMapBake, CoordinatesOutsideTheSquareAreMovedIntoIt) {
  Mesh mesh = plane({-2.5f, 7.0f}, {-1.7f, 7.5f});
  EXPECT_EQ(baked(mesh, settingsOf(32)).report.covered, 26u * 16u);
  for (const glm::vec2& c : mesh.textureCoordinates) EXPECT_TRUE(c.x >= 0.0f && c.y >= 0.0f && c.x <= 1.0f && c.y <= 1.0f);
  Mesh wide = plane({0.0f, 0.0f}, {20.0f, 10.0f});
  EXPECT_EQ(baked(wide, settingsOf(32)).report.covered, 32u * 16u);
}

TEST(ApertureMapBake, WhatCarriesNoMapSaysWhy) {
  Mesh mesh = plane();
  mesh.textureCoordinates.clear();
  EXPECT_THAT(errorOf(mesh, settingsOf(32)), HasSubstr("has no texture coordinates on all its triangles; --atlas"));
  EXPECT_THAT(errorOf(plane({0.3f, 0.3f}, {0.3f, 0.3f}), settingsOf(32)), HasSubstr("without area"));
}

}  // namespace
}  // namespace overcast
