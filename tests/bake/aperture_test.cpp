// Apertures at vertices: what is filled, fitted, measured and stored.
#include "bake/aperture.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bake/aperture_fit.h"
#include "formats/normals.h"
#include "tests/bake/test_meshes.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

BakedApertures baked(const Mesh& mesh, const ApertureSettings& settings = {}) {
  auto result = bakeApertures(mesh, settings);
  EXPECT_TRUE(result.ok());
  return std::move(result).value();
}

TEST(Aperture, ConvexMeshesGetTheirNormalsAndTheWholeHemisphere) {
  for (const Mesh& mesh : {withNormals(reference::boxMesh({1.0, 2.0, 0.3})), withNormals(reference::icosphere(1.0, 2))}) {
    ApertureSettings settings;
    settings.bits = ApertureBits::packed64;
    const BakedApertures result = baked(mesh, settings);
    ASSERT_EQ(result.visibility.apertures.size(), mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      EXPECT_EQ(result.visibility.apertures[i].radius, capRadius(1.0));
      EXPECT_LT(glm::length(result.visibility.apertures[i].direction - mesh.normals[i]), 1e-4f);  // the code of the normal
      EXPECT_EQ(result.visibility.ambient[i], 1.0f);
    }
    EXPECT_LT(result.report.sampled.radius, 1e-12);  // between vertices too: the smooth surface has no terminator
    EXPECT_LT(result.report.sampled.ambient, 1e-12);
    EXPECT_FALSE(result.report.fitted);
    EXPECT_EQ(result.report.shut, 0u);
  }
}

TEST(Aperture, WhatIsEnclosedIsShutAndKeepsItsNormal) {
  const Mesh shell = withNormals(reference::icosphere(1.0, 3));
  const Mesh core = withNormals(reference::boxMesh({0.2, 0.2, 0.2}));
  Mesh both = reference::joined(reference::insideOut(shell), core);
  both.normals.assign(both.positions.size(), glm::vec3(0.0f));
  for (std::size_t i = 0; i < both.positions.size(); ++i)
    both.normals[i] = i < shell.positions.size() ? -shell.normals[i] : core.normals[i - shell.positions.size()];
  const BakedApertures result = baked(both);
  EXPECT_EQ(result.report.shut, both.positions.size());
  EXPECT_EQ(result.report.interior, 0u);
  for (std::size_t i = 0; i < both.positions.size(); ++i) {
    EXPECT_EQ(result.visibility.apertures[i].radius, 0.0f);
    EXPECT_GT(glm::dot(result.visibility.apertures[i].direction, both.normals[i]), 0.99999f);
  }
}

TEST(Aperture, VerticesInSolidsAreFilledFromTheirNeighbours) {
  // A pillar that stands deep in a block: its lower rings are inside.
  Mesh pillar;
  constexpr int kRings = 9, kSides = 16;
  for (int r = 0; r < kRings; ++r)
    for (int s = 0; s < kSides; ++s) {
      const double turn = 2.0 * 3.14159265358979 * s / kSides;
      pillar.positions.emplace_back(0.2 * std::cos(turn), 0.2 * std::sin(turn), -0.8 + 0.4 * r);
    }
  for (unsigned r = 0; r + 1 < kRings; ++r)
    for (unsigned s = 0; s < kSides; ++s) {
      const unsigned a = r * kSides + s, b = r * kSides + (s + 1) % kSides;
      pillar.triangles.emplace_back(a, b, b + kSides);
      pillar.triangles.emplace_back(a, b + kSides, a + kSides);
    }
  Mesh mesh = withNormals(reference::joined(test::boxBetween({-40.0, -40.0, -1.0}, {40.0, 40.0, 0.1}), pillar));
  ApertureSettings settings;
  settings.errorSamples = 0;  // no fit: as sampled and filled
  const BakedApertures result = baked(mesh, settings);
  EXPECT_EQ(result.report.interior, 3u * kSides);  // z = -0.8, -0.4, 0
  EXPECT_EQ(result.report.shut, 0u);
  const auto radiusAt = [&](double z) {
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      if (std::abs(mesh.positions[i].z - z) > 1e-9 || std::hypot(mesh.positions[i].x, mesh.positions[i].y) > 0.3) continue;
      sum += double{result.visibility.apertures[i].radius};
      count += 1.0;
    }
    return sum / count;
  };
  EXPECT_NEAR(radiusAt(0.4), 1.047, 0.02);  // above the block half of the hemisphere is sky: 60 degrees
  EXPECT_NEAR(radiusAt(0.0), radiusAt(0.4), 0.01);
  EXPECT_NEAR(radiusAt(-0.8), radiusAt(0.4), 0.01);
}

TEST(Aperture, SeamsOfOtherAttributesDoNotShowAndTheOrderOfVerticesDoesNotMatter) {
  const Mesh mesh = withNormals(reference::torusMesh(1.0, 0.6, 24, 16));
  Mesh shuffled = mesh;
  std::vector<std::uint32_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::mt19937 dice(5);
  std::shuffle(order.begin(), order.end(), dice);
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    shuffled.positions[order[i]] = mesh.positions[i];
    shuffled.normals[order[i]] = mesh.normals[i];
  }
  for (glm::uvec3& t : shuffled.triangles) t = {order[t.x], order[t.y], order[t.z]};
  const auto last = static_cast<std::uint32_t>(shuffled.positions.size());  // vertex 0 once more, as at a seam
  shuffled.positions.push_back(glm::dvec3(shuffled.positions[order[0]]));
  shuffled.normals.push_back(glm::vec3(shuffled.normals[order[0]]));
  for (glm::uvec3& t : shuffled.triangles)
    if (t.x == order[0]) t.x = last;
  ApertureSettings settings;
  settings.errorSamples = 0;
  const BakedApertures a = baked(mesh, settings), b = baked(shuffled, settings);
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    EXPECT_EQ(a.visibility.apertures[i].radius, b.visibility.apertures[order[i]].radius);
    EXPECT_EQ(a.visibility.apertures[i].direction, b.visibility.apertures[order[i]].direction);
    EXPECT_EQ(a.visibility.ambient[i], b.visibility.ambient[order[i]]);
  }
  EXPECT_EQ(b.visibility.apertures[last].radius, b.visibility.apertures[order[0]].radius);
  EXPECT_EQ(b.report.points, a.report.points);
}

TEST(Aperture, TheFootOfAWallSeesHalfOfItsHemisphere) {
  // A floor and a wall that meet in a sharp edge: vertices of the floor on the edge lie in the plane of the wall.
  Mesh corner;
  corner.positions = {{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {0, 1, 50}, {0, 0, 50}};
  corner.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  corner.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
  for (glm::dvec3& p : corner.positions) p.y = 100.0 * (p.y - 0.5);
  // In the middle of the edge, where the wall's ends are far.
  corner.positions.insert(corner.positions.end(), {{0, 0, 0}, {1, 0, 0}});
  corner.normals.insert(corner.normals.end(), {{0, 0, 1}, {0, 0, 1}});
  corner.triangles[0] = {0, 9, 8};
  corner.triangles[1] = {0, 3, 9};
  corner.triangles.push_back({8, 9, 2});
  corner.triangles.push_back({8, 2, 1});
  ApertureSettings settings;
  settings.errorSamples = 0;
  settings.visibility.rays = 4096;
  const BakedApertures result = baked(corner, settings);
  EXPECT_NEAR(result.visibility.ambient[8], 0.5f, 0.02f);
}

TEST(Aperture, PatchesThatFaceInwardAreCountedAndPointsInSolidsAreNot) {
  ApertureSettings settings;
  settings.errorSamples = 0;
  const Mesh ball = withNormals(reference::icosphere(1.0, 3)), core = reference::icosphere(0.2, 2);
  const ApertureReport inward = baked(withNormals(reference::insideOut(reference::icosphere(1.0, 3))), settings).report;
  EXPECT_EQ(inward.interior, 0u);  // a room: its walls see each other's fronts
  EXPECT_EQ(inward.shut, inward.vertices);
  EXPECT_EQ(inward.inward, inward.vertices);
  Mesh turned = ball;  // normals alone point in
  for (glm::vec3& n : turned.normals) n = -n;
  const ApertureReport patches = baked(turned, settings).report;
  EXPECT_EQ(patches.interior, patches.vertices);
  EXPECT_EQ(patches.inward, patches.vertices);
  const ApertureReport within = baked(withNormals(reference::joined(ball, core)), settings).report;
  EXPECT_EQ(within.interior, core.positions.size());
  EXPECT_EQ(within.inward, 0u);
}

double meanOf(const std::vector<SurfaceSample>& samples, const Mesh& mesh, int axis) {
  double sum = 0.0;
  for (const SurfaceSample& s : samples)
    for (int c = 0; c < 3; ++c) sum += s.weight[c] * mesh.positions[mesh.triangles[s.triangle][c]][axis];
  return sum / static_cast<double>(samples.size());
}

TEST(Aperture, SurfaceSamplesAreEvenOverTheArea) {
  Mesh mesh;  // one triangle with nine times the area of the other
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {10, 0, 0}, {11, 0, 0}, {10, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const std::vector<SurfaceSample> samples = sampleSurface(mesh, 20000, 7);
  ASSERT_EQ(samples.size(), 20000u);
  const auto small = std::count_if(samples.begin(), samples.end(), [](const SurfaceSample& s) { return s.triangle == 1; });
  EXPECT_NEAR(static_cast<double>(small) / 20000.0, 0.1, 0.01);
  EXPECT_NEAR(meanOf(samples, mesh, 0), 0.9 * 1.0 + 0.1 * (31.0 / 3.0), 0.1);  // the centroid
  EXPECT_NEAR(meanOf(samples, mesh, 1), 0.9 * 1.0 + 0.1 / 3.0, 0.03);
}

/// A strip of unit squares along x, two unknowns per step.
std::vector<glm::uvec3> strip(std::uint32_t steps) {
  std::vector<glm::uvec3> triangles;
  for (std::uint32_t i = 0; i + 1 < steps; ++i) {
    triangles.emplace_back(2 * i, 2 * i + 2, 2 * i + 1);
    triangles.emplace_back(2 * i + 2, 2 * i + 3, 2 * i + 1);
  }
  return triangles;
}

std::vector<FitSample> observations(const std::vector<glm::uvec3>& triangles, const std::vector<ApertureSample>& truth, int each) {
  std::vector<FitSample> samples;
  std::mt19937 dice(3);
  const auto draw = [&] { return static_cast<double>(dice()) * 0x1p-32; };
  for (const glm::uvec3& t : triangles) {
    for (int i = 0; i < each; ++i) {
      double u = draw(), v = draw();
      if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
      FitSample sample{t, {1.0 - u - v, u, v}, {glm::dvec3(0.0), 0.0, 0.0, {}}};
      for (int c = 0; c < 3; ++c) {
        const ApertureSample& corner = truth[t[c]];
        sample.seen.direction += sample.weight[c] * corner.direction;
        sample.seen.radius += sample.weight[c] * corner.radius;
        sample.seen.ambient += sample.weight[c] * corner.ambient;
        sample.seen.transfer[4] += sample.weight[c] * corner.transfer[4];
      }
      samples.push_back(sample);
    }
  }
  return samples;
}

TEST(ApertureFit, FindsTheVerticesBehindAnInterpolatedSurface) {
  const std::vector<glm::uvec3> triangles = strip(12);
  std::vector<ApertureSample> truth(24), start(24);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double x = static_cast<double>(i);
    truth[i] = {glm::normalize(glm::dvec3(0.1 * x, 0.3, 1.0)), 0.5 + 0.02 * x, 0.9 - 0.01 * x, {}};
    truth[i].transfer[4] = 0.1 * x;
  }
  const std::vector<ApertureSample> fitted = fitApertures(start, triangles, observations(triangles, truth, 200));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(fitted[i].radius, truth[i].radius, 0.02);
    EXPECT_NEAR(fitted[i].ambient, truth[i].ambient, 0.03);
    EXPECT_NEAR(fitted[i].transfer[4], truth[i].transfer[4], 0.05);
    EXPECT_LT(glm::length(fitted[i].direction - truth[i].direction), 0.05);
    EXPECT_NEAR(glm::length(fitted[i].direction), 1.0, 1e-12);
  }
}

TEST(ApertureFit, StaysWithinWhatItsSamplesShow) {
  const std::vector<glm::uvec3> triangles = strip(12);
  std::vector<ApertureSample> truth(24);
  std::vector<FitSample> samples = observations(triangles, truth, 50);
  for (FitSample& s : samples) s.seen.radius = s.corner.x % 4 == 0 ? 1.0 : 0.2;  // a step that a free fit would overshoot
  for (const ApertureSample& fitted : fitApertures(truth, triangles, samples)) {
    EXPECT_GE(fitted.radius, 0.0);
    EXPECT_LE(fitted.radius, 1.0);
  }
}

TEST(ApertureFit, VerticesWithoutSamplesKeepTheirStart) {
  const std::vector<glm::uvec3> triangles = strip(3);
  std::vector<ApertureSample> start(6);
  for (ApertureSample& s : start) s.radius = 0.7;
  for (const ApertureSample& fitted : fitApertures(start, triangles, {})) EXPECT_NEAR(fitted.radius, 0.7, 1e-12);
}

/// A floor of n x n squares with a post on it: between vertices, its shadow is not where interpolation puts it.
Mesh floorWithPost(int n) {
  Mesh floor;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) floor.positions.emplace_back(4.0 * i / n - 2.0, 4.0 * j / n - 2.0, 0.0);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + n + 1;
      floor.triangles.emplace_back(a, a + 1, b + 1);
      floor.triangles.emplace_back(a, b + 1, b);
    }
  return withNormals(reference::joined(floor, test::boxBetween({-0.3, -0.2, 0.001}, {0.35, 0.25, 1.5})));
}

TEST(Aperture, CoarseMeshesAreFittedAndFineOnesAreNot) {
  const ApertureReport coarse = baked(floorWithPost(5)).report;
  EXPECT_TRUE(coarse.fitted);
  EXPECT_LT(coarse.error.radius + coarse.error.ambient, 0.85 * (coarse.sampled.radius + coarse.sampled.ambient));
  const ApertureReport fine = baked(withNormals(reference::torusMesh(1.0, 0.5, 96, 64))).report;
  EXPECT_FALSE(fine.fitted);
  EXPECT_LT(fine.error.radius, kCoarse);
}

}  // namespace
}  // namespace overcast
