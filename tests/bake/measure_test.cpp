#include "bake/measure.h"

#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "bake/volume.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using namespace reference;

TEST(Measure, TheExactDistanceHasNoError) {
  const glm::dvec3 half(1.0, 0.5, 0.25), offset(1e4, -3.0, 7.0);
  const Probes probes = drawProbes(moved(boxMesh(half), offset), {});
  const MeasuredError error = measure([&](const glm::dvec3& p) { return boxDistance(p - offset, half); }, probes);
  EXPECT_LT(error.max, 1e-9);
  EXPECT_LE(error.rms, error.p99);
  EXPECT_LE(error.p99, error.max);
  EXPECT_LT(error.surfaceRms, 1e-9);
  EXPECT_LT(error.skyRmse, 1e-9);
  EXPECT_EQ(error.signErrors, 0u);
  EXPECT_EQ(error.samples, 4096u);
  EXPECT_EQ(error.method, "influence-2");
}

TEST(Measure, AConstantOffsetIsEveryFigure) {
  const glm::dvec3 half(1.0, 0.7, 0.4);
  const Probes probes = drawProbes(boxMesh(half), {});
  const MeasuredError error = measure([&](const glm::dvec3& p) { return boxDistance(p, half) + 0.125; }, probes);
  for (const double figure : {error.max, error.rms, error.p99, error.surfaceRms}) EXPECT_NEAR(figure, 0.125, 1e-9);
  EXPECT_GT(error.skyRmse, 1e-3);
  EXPECT_GT(error.signErrors, 0u);  // from 0.0259 to 0.125 deep
}

// Ball of radius 1, error e(r) = (r - 1): the shell's weights exp(-|r - 1| / sigma) and volume 4 pi r^2 integrated numerically.
TEST(Measure, SurfaceRmsIsTheWeightedIntegral) {
  const double sag = icosphereSag(1.0, 5);
  const double sigma = 0.02 * 2.0 * std::sqrt(3.0);
  double weighted = 0.0, weights = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const double t = (i + 0.5) / 200000.0 * 10.0 * sigma - 5.0 * sigma;
    const double weight = std::exp(-std::abs(t) / sigma) * (1.0 + t) * (1.0 + t);
    weighted += weight * t * t;
    weights += weight;
  }
  const Probes probes = drawProbes(icosphere(1.0, 5), {40000, 3});
  const MeasuredError error = measure([](const glm::dvec3& p) { return 2.0 * sphereDistance(p, 1.0); }, probes);
  EXPECT_NEAR(error.surfaceRms / std::sqrt(weighted / weights), 1.0, 0.03 + sag);
}

// An object that is not there leaves the ground open and the sphere lit; compared with the formula of DESIGN 5.4 written once more.
TEST(Measure, SkyErrorIsThatOfThePublishedEstimator) {
  const glm::dvec3 half(0.5, 0.6, 0.4);
  const Probes probes = drawProbes(boxMesh(half), {1600, 9});
  ASSERT_EQ(probes.receivers.size(), 200u);
  const double diagonal = 2.0 * glm::length(half);
  const auto visibility = [&](const Receiver& receiver, bool withBox) {
    double sum = 0.0, reach = 0.0;
    for (int i = 0; i < 5; ++i) {
      const double d = diagonal / 64.0 * std::pow(2.0, i);
      const glm::dvec3 tap = receiver.point + d * (receiver.normal + glm::dvec3(0.0, 0.5, 0.0));
      const double plane = glm::dot(tap - receiver.point, receiver.normal);
      sum += d - (withBox ? std::min(plane, boxDistance(tap, half)) : plane);
      reach += d;
    }
    const double exponent = std::max(0.0, 1.5 * (0.5 + sum / reach));
    return std::exp(-exponent * exponent / (exponent + 0.0625));
  };
  double squares = 0.0;
  for (const Receiver& receiver : probes.receivers) squares += std::pow(visibility(receiver, true) - visibility(receiver, false), 2.0);
  const MeasuredError error = measure([](const glm::dvec3&) { return 1e6; }, probes);
  EXPECT_NEAR(error.skyRmse, std::sqrt(squares / 200.0), 1e-9);
  EXPECT_GT(error.skyRmse, 0.05);
}

Mesh sheet() {
  Mesh mesh;
  mesh.positions = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}};  // facing up
  return mesh;
}

double aboveSheet(const glm::dvec3& p) {
  return boxDistance(p, glm::dvec3(1.0, 0.0, 1.0));
}

/// A block with the sheet as its top or, upside down, as its bottom.
double block(glm::dvec3 p, double thickness, double up) {
  p.y *= up;
  return boxDistance(p + glm::dvec3(0.0, 0.5 * thickness, 0.0), glm::dvec3(1.0, 0.5 * thickness, 1.0));
}

// Which side of a sheet is inside is nobody's to say, nor how far down: a bare sheet and blocks of any thickness to either side are right.
TEST(Measure, ASheetMayBeABlockOfAnyThickness) {
  for (const bool turned : {false, true}) {
    Mesh mesh = sheet();
    if (turned) std::swap(mesh.triangles[0].x, mesh.triangles[0].y), std::swap(mesh.triangles[1].x, mesh.triangles[1].y);
    const Probes probes = drawProbes(mesh, {2000, 1});
    EXPECT_GT(probes.ambiguousSign, 0.3);
    EXPECT_LT(measure(aboveSheet, probes).surfaceRms, 1e-9);
    for (const double thickness : {0.1, 0.5, 2.0}) {
      for (const double up : {1.0, -1.0}) {
        const MeasuredError error = measure([&](const glm::dvec3& p) { return block(p, thickness, up); }, probes);
        EXPECT_LT(error.surfaceRms, 1e-9) << thickness << ' ' << up;
        EXPECT_EQ(error.signErrors, 0u);
      }
    }
  }
}

// But not what bulges out in front of it, and not a side that is neither here nor there.
TEST(Measure, WhatABlockIsInFrontIsKnown) {
  const Probes probes = drawProbes(sheet(), {2000, 1});
  const auto raised = [](double by) { return [=](const glm::dvec3& p) { return block(p - glm::dvec3(0.0, by, 0.0), 1.0, 1.0); }; };
  const MeasuredError low = measure(raised(0.1), probes), high = measure(raised(0.2), probes);
  EXPECT_GT(low.surfaceRms, 0.08);
  EXPECT_GT(high.surfaceRms, 1.5 * low.surfaceRms);
  EXPECT_GT(low.skyRmse, 1e-3);
  EXPECT_GT(measure([](const glm::dvec3& p) { return boxDistance(p, glm::dvec3(1.0, 0.4, 1.0)); }, probes).surfaceRms, 0.05);
  EXPECT_GT(measure([](const glm::dvec3& p) { return -aboveSheet(p) - 0.1; }, probes).surfaceRms, 0.05);
  EXPECT_GT(measure([](const glm::dvec3& p) { return aboveSheet(p) + 0.1; }, probes).surfaceRms, 0.05);
}

// A ball with a hole in it: within, where the hole is small in sight, inside is known.
TEST(Measure, TheInsideOfAMeshWithAHoleIsKnown) {
  const Mesh bowl = withHoles(icosphere(1.0, 3), 0.02, 4);
  const Probes probes = drawProbes(bowl, {4000, 5});
  ASSERT_FALSE(probes.found.closed);
  const MeasuredError hollow = measure([](const glm::dvec3& p) { return std::abs(sphereDistance(p, 1.0)); }, probes);
  EXPECT_GT(hollow.signErrors, 20u);
  EXPECT_EQ(measure([](const glm::dvec3& p) { return sphereDistance(p, 1.0); }, probes).signErrors, 0u);
}

TEST(Measure, FinerVolumesAreNearer) {
  const Mesh torus = torusMesh(1.0, 0.4, 48, 24);
  const Probes probes = drawProbes(torus, {2000, 1});
  double last = 1e300;
  for (const int resolution : {8, 16, 32, 64}) {
    VolumeSettings settings;
    settings.resolution = resolution;
    settings.errorSamples = 0;
    const auto baked = bakeVolume(torus, settings);
    ASSERT_TRUE(baked.ok());
    const double now = measure(Asset(baked.value().volume), probes).surfaceRms;
    EXPECT_LT(now, 0.6 * last) << resolution;
    last = now;
  }
}

TEST(Measure, SameFiguresForAnyThreadCount) {
  const Mesh bowl = withHoles(icosphere(1.0, 3), 0.2, 4);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return measure([](const glm::dvec3& p) { return sphereDistance(p, 1.1); }, drawProbes(bowl, {1000, 5}));
  };
  const MeasuredError one = run(1), four = run(4);
  EXPECT_EQ(one.max, four.max);
  EXPECT_EQ(one.rms, four.rms);
  EXPECT_EQ(one.p99, four.p99);
  EXPECT_EQ(one.surfaceRms, four.surfaceRms);
  EXPECT_EQ(one.skyRmse, four.skyRmse);
  EXPECT_EQ(one.signErrors, four.signErrors);
}

TEST(Measure, FlatAndSlenderMeshesHaveFigures) {
  for (const glm::dvec3& half : {glm::dvec3(1.0, 0.0, 1.0), glm::dvec3(1e-3, 1.0, 1e-3)}) {
    const Mesh mesh = scaled(boxMesh(half), 1e-4);
    const MeasuredError error = measure([](const glm::dvec3& p) { return glm::length(p); }, drawProbes(mesh, {500, 2}));
    EXPECT_TRUE(std::isfinite(error.surfaceRms) && error.surfaceRms > 0.0);
    EXPECT_LE(error.surfaceRms, error.max);
  }
}

}  // namespace
}  // namespace overcast
