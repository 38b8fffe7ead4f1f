// Truth against closed forms of form factors (Howell, "A Catalog of Radiation Heat Transfer Configuration Factors").
#include "bake/reference_trace.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <glm/ext/matrix_transform.hpp>

#include "bake/sample_table.h"
#include "formats/image_mipmaps.h"
#include "tests/bake/reference_scenes.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

constexpr double kPi = std::numbers::pi;

TraceSettings accurate() {
  TraceSettings settings;
  settings.samples = 32768;
  return settings;
}

/// Within four standard errors and what the mesh and the offset of rays leave.
void expectNear(const std::map<std::string, double>& truth, const std::string& name, double expected, double slack) {
  const double error = truth.at(name + ".error");
  EXPECT_NEAR(truth.at(name), expected, slack + 4.0 * error) << name;
  EXPECT_LT(error, 0.003 * std::max(expected, 0.1)) << name;
}

Lighting plainSky() {
  Lighting lighting;
  lighting.skyColour = glm::vec3(0.8f);
  return lighting;
}

TEST(ReferenceTrace, AnOpenPlaneSeesAllOfTheSky) {
  Scene scene;
  test::addMesh(scene, test::flatFloor(1.0), glm::vec3(0.5f));
  scene.lighting = plainSky();
  const TracedScene traced = test::traced(scene);
  for (const glm::dvec3 towards : {glm::dvec3(0, 1, 0), glm::dvec3(0.3, -1, 0)}) {
    const auto truth = test::truthAt(traced, test::onSheet(traced, {0.2, 0, 0.3}, towards), {});
    EXPECT_EQ(truth.at("sky"), 1.0);
    EXPECT_EQ(truth.at("ao"), 1.0);
    EXPECT_EQ(truth.at("dome"), towards.y > 0.0 ? 1.0 : 0.0) << "the underside faces away from the dome";
    EXPECT_FLOAT_EQ(static_cast<float>(truth.at("colour")), 0.5f * 0.8f);
    EXPECT_EQ(truth.at("bounce"), 0.0);
    EXPECT_EQ(truth.at("sky.error"), 0.0);
    EXPECT_EQ(truth.count("light"), 0u) << "there is none";
  }
}

TEST(ReferenceTrace, AFreeWallSeesHalfOfTheDome) {
  Scene scene;
  test::addMesh(scene, test::sheet({-1, 0, 0}, {2, 0, 0}, {0, 2, 0}), glm::vec3(1.0f));
  const TracedScene traced = test::traced(scene);
  const auto truth = test::truthAt(traced, test::onSheet(traced, {0.2, 1.1, 0}, {0, 0, 1}), accurate());
  EXPECT_EQ(truth.at("sky"), 1.0);
  expectNear(truth, "dome", 0.5, 0.0);
}

TEST(ReferenceTrace, ASphereOverAPlaneHidesTheSquareOfItsSine) {
  Scene scene;
  test::addMesh(scene, test::flatFloor(20.0), glm::vec3(1.0f));
  test::addMesh(scene, reference::moved(reference::icosphere(1.0, 5), {0.0, 1.5, 0.0}), glm::vec3(1.0f));
  const TracedScene traced = test::traced(scene);
  for (const double x : {0.0, 0.7, 2.0, 5.0}) {
    const auto truth = test::truthAt(traced, test::onSheet(traced, {x, 0, 0}, {0, 1, 0}), accurate());
    const double distance = std::hypot(x, 1.5);
    expectNear(truth, "sky", 1.0 - 1.5 / std::pow(distance, 3), 1e-3);
    expectNear(truth, "dome", 1.0 - 1.5 / std::pow(distance, 3), 1e-3);
  }
}

TEST(ReferenceTrace, AParallelPlateCountsWithinTheBoundAlone) {
  Scene scene;
  test::addMesh(scene, test::flatFloor(3.0), glm::vec3(1.0f));
  test::addMesh(scene, reference::moved(test::flatFloor(1.0), {0.0, 0.5, 0.0}), glm::vec3(1.0f));
  const TracedScene traced = test::traced(scene);
  const double a = 1.0 / 0.5, root = std::sqrt(1.0 + a * a);
  const double hidden = 4.0 * 2.0 * a / root * std::atan(a / root) / (2.0 * kPi);
  const TracedSurface point = test::onSheet(traced, {0, 0, 0}, {0, 1, 0});
  TraceSettings settings = accurate();
  settings.bounce = false;
  for (const double bound : {0.0, 0.4, 0.5 * std::sqrt(2.0), 10.0}) {
    settings.distanceBound = bound;
    const auto truth = test::truthAt(traced, point, settings);
    expectNear(truth, "sky", 1.0 - hidden, 1e-4);
    // A disc of radius 0.5 above the point: all directions within 45 degrees, which the cosine weights by a half.
    const double near = bound == 0.0 || bound > 5.0 ? hidden : bound < 0.5 ? 0.0 : 0.5;
    expectNear(truth, "ao", 1.0 - near, 1e-3);
  }
}

/// A floor that goes on for ever in front of a wall 2 high, 100 wide.
Scene floorAndWall() {
  Scene scene;
  test::addMesh(scene, test::flatFloor(50.0), glm::vec3(0.6f));
  test::addMesh(scene, test::sheet({-50, 0, 0}, {100, 0, 0}, {0, 2, 0}), glm::vec3(0.5f));
  scene.lighting = plainSky();
  return scene;
}

TEST(ReferenceTrace, AWallHidesAndReflectsTheSky) {
  const TracedScene traced = test::traced(floorAndWall());
  for (const double z : {0.5, 1.0, 3.0}) {
    const auto truth = test::truthAt(traced, test::onSheet(traced, {0.1, 0, z}, {0, 1, 0}), accurate());
    const double hidden = 0.5 * (1.0 - z / std::hypot(z, 2.0));
    expectNear(truth, "sky", 1.0 - hidden, 2e-3);
    expectNear(truth, "colour", 0.6 * 0.8 * (1.0 - hidden), 2e-3);
    // The wall sees half of the sky: the other half of its view is the floor.
    EXPECT_NEAR(truth.at("bounce"), 0.6 * hidden * 0.5 * 0.8 * 0.5, 1e-3 + 4.0 * truth.at("bounce.error"));
    EXPECT_LT(truth.at("bounce.error"), 0.001);
  }
}

TEST(ReferenceTrace, ASphericalLightShinesAsTheSquareOfItsSine) {
  Scene scene;
  test::addMesh(scene, test::flatFloor(5.0), glm::vec3(0.5f));
  // In the shadow of this sheet the light is gone.
  test::addMesh(scene, test::sheet({-1.8, 0.5, 0.3}, {0.6, 0, 0}, {0, 0, -0.6}), glm::vec3(1.0f));
  Lighting lighting = plainSky();
  lighting.areaLights.push_back({{0.0f, 2.0f, 0.0f}, 0.5f, glm::vec3(3.0f), -1});
  scene.lighting = lighting;
  const TracedScene traced = test::traced(scene);
  TraceSettings settings = accurate();
  settings.samples = 4096;
  settings.bounce = false;
  for (const double x : {0.0, 1.0, 3.0}) {
    const auto truth = test::truthAt(traced, test::onSheet(traced, {x, 0, 0}, {0, 1, 0}), settings);
    const double share = 0.25 * 2.0 / std::pow(std::hypot(x, 2.0), 3);
    expectNear(truth, "light", 0.5 * 3.0 * share, 1e-5);
    EXPECT_GT(truth.at("sky"), 0.95) << "lights block nothing";
    EXPECT_NEAR(truth.at("colour") / (0.5 * 0.8), truth.at("sky") - share, 5e-3) << "but what they cover is not sky";
  }
  EXPECT_EQ(test::truthAt(traced, test::onSheet(traced, {-2, 0, 0}, {0, 1, 0}), settings).at("light"), 0.0);
}

TEST(ReferenceTrace, TheSunGivesItsIrradianceTimesTheCosine) {
  Scene scene;
  test::addMesh(scene, test::flatFloor(5.0), glm::vec3(0.5f));
  Lighting lighting = plainSky();
  lighting.sun = Sun{glm::normalize(glm::vec3(1.0f, 1.0f, 0.0f)), glm::vec3(2.0f), 0.01f};
  scene.lighting = lighting;
  const TracedScene traced = test::traced(scene);
  const auto truth = test::truthAt(traced, test::onSheet(traced, {0, 0, 0}, {0, 1, 0}), {});
  expectNear(truth, "light", 0.5 / kPi * 2.0 * std::sqrt(0.5), 1e-4);
}

TEST(ReferenceTrace, InAHollowSphereAllLightComesFromAllAround) {
  Scene scene;
  test::addMesh(scene, reference::insideOut(reference::icosphere(2.0, 5)), glm::vec3(0.5f)).translation = {10.0, 0.0, 0.0};
  scene.nodes[0].scale = glm::dvec3(3.0, 3.0, -3.0);
  Lighting lighting;
  lighting.areaLights.push_back({{0.0f, 0.0f, 0.0f}, 1.5f, glm::vec3(4.0f), 0});
  scene.lighting = lighting;
  const TracedScene traced = test::traced(scene);
  const TracedSurface point =
      surfaceAt(traced, {77, {0.2, 0.3, 0.5}}, glm::dvec3(10, 0, 0) - traced.mesh.positions[traced.mesh.triangles[77].x]);
  const auto truth = test::truthAt(traced, point, accurate());
  const double direct = 0.5 * 4.0 * std::pow(1.5 / 6.0, 2);
  EXPECT_EQ(truth.at("sky"), 0.0);
  expectNear(truth, "light", direct, 5e-3 * direct);
  expectNear(truth, "bounce", 0.5 * direct, 5e-3 * direct);
}

TEST(ReferenceTrace, ASkyImageShinesFromWhereItSays) {
  // Bright towards +x above the horizon, and just below it, where the floor does not look.
  Image image{16, 8, {"R", "G", "B"}, std::vector<float>(std::size_t{16} * 8 * 3, 0.0f)};
  for (int y = 2; y < 6; ++y)
    for (int x = 0; x < 8; ++x)
      for (int c = 0; c < 3; ++c) at(image, x, y, c) = c == 0 ? 2.0f : 1.0f;
  const SkyImage sky = makeSkyImage(image).value();
  EXPECT_NEAR(sky.mean.x, 2.0 * 0.5 * std::sqrt(0.5), 1e-6);
  EXPECT_EQ(radianceFrom(sky, {1, 0, 0}).x, 2.0);
  EXPECT_EQ(radianceFrom(sky, glm::normalize(glm::dvec3(0.1, 0.2, -1))).x, 2.0);
  EXPECT_EQ(radianceFrom(sky, glm::normalize(glm::dvec3(-0.1, 0.2, 1))).x, 0.0);
  EXPECT_EQ(radianceFrom(sky, {0, 1, 0}).x, 0.0);
  Scene scene;
  test::addMesh(scene, test::flatFloor(5.0), glm::vec3(0.5f));
  const TracedScene traced = makeTracedScene(scene, 0.0, &sky).value();
  const TracedSurface point = test::onSheet(traced, {0, 0, 0}, {0, 1, 0});
  const auto quantities = traceQuantities(traced, std::vector{point}, accurate()).value();
  // The cosine over half of the circle from the horizon to 45 degrees: a half of sin^2 45.
  EXPECT_NEAR(quantities[3].values[0], 0.5 * 2.0 * 0.25, 2e-3);
  EXPECT_NEAR(quantities[3].values[1], 0.5 * 1.0 * 0.25, 1e-3);
  EXPECT_EQ(quantities[0].values[0], 1.0f);
  image.width = 8;
  EXPECT_FALSE(makeSkyImage(image).ok());
}

TEST(ReferenceTrace, ACubeIsTheSkyThatItsPixelsSay) {
  // A radiance that says the direction: what is read back is that of a pixel's centre nearby.
  constexpr int kSide = 33;
  Image image{kSide, 6 * kSide, {"R", "G", "B"}, {}};
  for (const glm::dvec3& direction : cubePixelDirections(kSide))
    for (int c = 0; c < 3; ++c) image.pixels.push_back(static_cast<float>(1.0 + glm::normalize(direction)[c]));
  const SkyImage sky = makeSkyImage(image).value();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sky.mean[c], 1.0, 1e-6);
  const auto apart = [&](const glm::dvec3& direction) { return glm::length(radianceFrom(sky, direction) - 1.0 - direction); };
  for (const glm::dvec3& pixel : cubePixelDirections(kSide)) EXPECT_LT(apart(glm::normalize(pixel)), 1e-6);
  for (int i = 0; i < 1000; ++i) {
    const double height = 1.0 - 2.0 * (i + 0.5) / 1000.0, turn = 2.4 * i, around = std::sqrt(1.0 - height * height);
    EXPECT_LT(apart({around * std::cos(turn), height, around * std::sin(turn)}), std::sqrt(2.0) / (kSide - 1) + 1e-6);
  }
  image.height = 5 * kSide;
  EXPECT_FALSE(makeSkyImage(image).ok());
}

/// A heap with edges, soft shadows and colours.
Scene heap() {
  Scene scene;
  test::addMesh(scene, test::flatFloor(3.0), {0.8f, 0.7f, 0.6f});
  test::addMesh(scene, reference::icosphere(0.5, 3), {0.9f, 0.2f, 0.1f}).translation = {0.3, 0.5, 0.0};
  test::addMesh(scene, reference::boxMesh({0.4, 0.6, 0.3}), {0.2f, 0.3f, 0.9f}).translation = {-0.7, 0.6, 0.2};
  test::addMesh(scene, reference::torusMesh(0.7, 0.2, 32, 16), {0.2f, 0.8f, 0.2f}).translation = {0.2, 0.2, 1.2};
  Lighting lighting;
  lighting.areaLights.push_back({{1.5f, 2.0f, 1.0f}, 0.9f, glm::vec3(6.0f, 5.0f, 4.0f), -1});
  lighting.sun = Sun{glm::normalize(glm::vec3(-1.0f, 1.0f, 0.4f)), glm::vec3(1.0f), 0.3f};
  scene.lighting = lighting;
  return scene;
}

std::vector<TracedSurface> pointsOn(const TracedScene& scene, std::uint64_t count) {
  std::vector<TracedSurface> points;
  for (const SurfaceSample& sample : sampleSurface(scene.mesh, count, 3)) {
    const glm::uvec3& t = scene.mesh.triangles[sample.triangle];
    const auto edge = [&](std::uint32_t corner) { return scene.mesh.positions[corner] - scene.mesh.positions[t.x]; };
    points.push_back(surfaceAt(scene, sample, glm::cross(edge(t.y), edge(t.z))));
  }
  return points;
}

TEST(ReferenceTrace, StandardErrorsAreHonest) {
  const TracedScene scene = test::traced(heap());
  const std::vector<TracedSurface> points = pointsOn(scene, 500);
  TraceSettings settings;
  settings.distanceBound = 0.5;
  settings.seed = 99;
  settings.samples = 8192;
  const auto truth = traceQuantities(scene, points, settings).value();
  ASSERT_EQ(truth.size(), 6u);
  // The sum of squared errors over that of squared standard errors is 1 on average, whatever the distribution.
  std::vector<double> errors(truth.size(), 0.0), stated(truth.size(), 0.0), bias(truth.size(), 0.0), spread(truth.size(), 0.0);
  settings.samples = 256;
  for (settings.seed = 1; settings.seed <= 4; ++settings.seed) {
    const auto rough = traceQuantities(scene, points, settings).value();
    for (std::size_t q = 0; q < truth.size(); ++q) {
      EXPECT_EQ(rough[q].samples, 256u);
      for (std::size_t i = 0; i < rough[q].values.size(); ++i) {
        const double error = static_cast<double>(rough[q].values[i] - truth[q].values[i]);
        errors[q] += error * error / static_cast<double>(rough[q].channels);
        bias[q] += error;
      }
      for (const float error : rough[q].errors) stated[q] += static_cast<double>(error * error);
    }
  }
  for (std::size_t q = 0; q < truth.size(); ++q) {
    EXPECT_GT(stated[q], 0.0) << truth[q].name;
    EXPECT_NEAR(errors[q] / stated[q], 1.0, 0.2) << truth[q].name;
    // Its mean over 2000 points, which share tables of directions, is far smaller than the error of one.
    const double samples = 4.0 * static_cast<double>(truth[q].values.size());
    EXPECT_LT(std::abs(bias[q] / samples), 0.1 * std::sqrt(stated[q] / 2000.0)) << truth[q].name;
  }
}

TEST(ReferenceTrace, StopsWhenTheErrorIsReached) {
  const TracedScene scene = test::traced(heap());
  const std::vector<TracedSurface> points = pointsOn(scene, 300);
  TraceSettings settings;
  settings.error = 0.01;
  std::vector<double> shares;
  std::mutex mutex;
  const auto rough = traceQuantities(scene, points, settings, [&](double share) {
                       const std::lock_guard lock(mutex);
                       shares.push_back(share);
                       return true;
                     }).value();
  settings.error = 0.004;
  const auto fine = traceQuantities(scene, points, settings).value();
  for (const auto* traced : {&rough, &fine}) {
    double light = 0.0;
    for (const TracedQuantity& quantity : *traced) light += quantity.channels == 3 ? quantity.mean : 0.0;
    light = std::max(light, 0.9);
    for (const TracedQuantity& quantity : *traced)
      EXPECT_LE(quantity.meanError, (traced == &rough ? 0.01 : 0.004) * (quantity.channels == 3 ? light : 1.0)) << quantity.name;
  }
  EXPECT_GT(fine[0].samples, rough[0].samples);
  EXPECT_LT(fine[0].samples, 65536u);
  EXPECT_GE(*std::min_element(shares.begin(), shares.end()), 0.0);
  EXPECT_LE(*std::max_element(shares.begin(), shares.end()), 1.0);
  EXPECT_FALSE(traceQuantities(scene, points, settings, [](double) { return false; }).has_value());
}

TEST(ReferenceTrace, ThreadsChangeNothing) {
  const TracedScene scene = test::traced(heap());
  const std::vector<TracedSurface> points = pointsOn(scene, 200);
  TraceSettings settings;
  settings.samples = 256;
  const auto many = traceQuantities(scene, points, settings).value();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto single = traceQuantities(scene, points, settings).value();
  for (std::size_t q = 0; q < many.size(); ++q) {
    EXPECT_EQ(many[q].values, single[q].values);
    EXPECT_EQ(many[q].errors, single[q].errors);
  }
}

TEST(ReferenceTrace, PlaceAndScaleChangeNothing) {
  TraceSettings settings;
  settings.samples = 256;
  settings.light = settings.bounce = false;
  const TracedScene here = test::traced(heap());
  const auto expected = traceQuantities(here, pointsOn(here, 300), settings).value();
  for (const double scale : {1e-4, 1e4}) {
    Scene scene = heap();
    for (Node& node : scene.nodes) {
      node.translation = scale * (node.translation + glm::dvec3(1e5, -2e5, 3e5));
      node.scale = glm::dvec3(scale);
    }
    const TracedScene there = test::traced(scene);
    const auto found = traceQuantities(there, pointsOn(there, 300), settings).value();
    double squares = 0.0;
    for (std::size_t i = 0; i < 300; ++i) squares += std::pow(static_cast<double>(found[0].values[i] - expected[0].values[i]), 2);
    EXPECT_LT(std::sqrt(squares / 300.0), 0.002) << scale;
  }
}

TEST(ReferenceTrace, RoundShapesOfFewTrianglesAreNotShadedInFacets) {
  // All of a sphere on its own is open, whatever the angle between its normals and its triangles.
  Scene scene;
  Mesh ball = reference::icosphere(1.0, 1);
  for (const glm::dvec3& position : ball.positions) ball.normals.emplace_back(glm::normalize(position));
  test::addMesh(scene, ball, glm::vec3(1.0f)).scale = {1.0, -1.0, 1.0};
  const TracedScene traced = test::traced(scene);
  TraceSettings settings;
  settings.samples = 1024;
  const auto truth = traceQuantities(traced, pointsOn(traced, 200), settings).value();
  EXPECT_GT(truth[0].mean, 0.995);
  EXPECT_GT(*std::min_element(truth[0].values.begin(), truth[0].values.end()), 0.9f);
}

TEST(SampleTable, IsStratifiedInEveryWay) {
  const auto tables = makeSampleTables(3, 0, 64, 1);
  ASSERT_NE(tables[0].x, tables[1].x);
  for (const SampleTable& table : tables) {
    for (const auto& [first, second] : {std::pair(&table.u, &table.v), std::pair(&table.second, &table.third)}) {
      for (int columns = 1; columns <= 64; columns *= 2) {
        const int rows = 64 / columns;
        std::vector<int> cells(64, 0);
        for (std::size_t i = 0; i < 64; ++i) {
          const float across = (*first)[i] * static_cast<float>(columns), down = (*second)[i] * static_cast<float>(rows);
          ++cells[static_cast<std::size_t>(across) + static_cast<std::size_t>(columns) * static_cast<std::size_t>(down)];
        }
        EXPECT_EQ(cells, std::vector<int>(64, 1)) << columns;
      }
    }
    double squares = 0.0;
    for (std::size_t i = 0; i < 64; ++i) {
      EXPECT_NEAR(table.x[i] * table.x[i] + table.y[i] * table.y[i] + table.z[i] * table.z[i], 1.0f, 1e-6f);
      squares += static_cast<double>(table.z[i] * table.z[i]) / 64.0;
    }
    EXPECT_NEAR(squares, 0.5, 0.5 / 64.0) << "distributed as the cosine";
  }
}

TEST(SampleTable, GoesOnWithoutAGap) {
  const auto whole = makeSampleTables(1, 0, 64, 1), later = makeSampleTables(1, 32, 32, 1), start = makeSampleTables(1, 0, 32, 1);
  std::vector<float> all = whole[0].z, parts = start[0].z;
  parts.insert(parts.end(), later[0].z.begin(), later[0].z.end());
  std::sort(all.begin(), all.end());
  std::sort(parts.begin(), parts.end());
  EXPECT_EQ(all, parts);
}

}  // namespace
}  // namespace overcast
