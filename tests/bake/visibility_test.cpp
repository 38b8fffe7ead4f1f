// Visibility from rays: closed forms, brute force in double, convex meshes, invariance to scale, place, order and threads.
#include "bake/visibility.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/task_arena.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "formats/aperture.h"
#include "formats/normals.h"
#include "tests/bake/test_meshes.h"
#include "tests/reference/shapes.h"
#include "tests/reference/visibility.h"

namespace overcast {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<PointVisibility> seen(const Mesh& mesh, const std::vector<SurfacePoint>& points, int rays, bool transfer = false) {
  auto scene = makeRayScene(mesh);
  EXPECT_TRUE(scene.ok());
  return traceVisibility({scene.value().get(), nullptr}, points, {rays, transfer});
}

std::vector<SurfacePoint> verticesOf(const Mesh& mesh) {
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) points.push_back({mesh.positions[i], mesh.normals[i]});
  return points;
}

TEST(Visibility, DirectionsAreUniformOverTheHemisphere) {
  for (const int rays : {16, 128, 250, 1024}) {
    const std::vector<glm::dvec3> directions = hemisphereDirections(rays);
    ASSERT_EQ(directions.size(), static_cast<std::size_t>((rays + 15) / 16 * 16));
    // Bands of equal height have equal area (Archimedes).
    std::vector<int> bands(16, 0);
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& d : directions) {
      EXPECT_NEAR(glm::length(d), 1.0, 1e-12);
      ++bands[static_cast<std::size_t>(d.z * 16.0)];
      sum += d;
    }
    for (const int band : bands) EXPECT_EQ(band, static_cast<int>(directions.size() / 16));
    sum /= static_cast<double>(directions.size());
    EXPECT_NEAR(sum.z, 0.5, 1e-12);
    EXPECT_LT(std::hypot(sum.x, sum.y), 1.0 / static_cast<double>(directions.size()));  // a random set: 0.6 / sqrt(n)
  }
}

TEST(Visibility, FramesAreTurnedRightHandedBases) {
  for (const glm::dvec3& n : reference::randomPoints({glm::dvec3(-1.0), glm::dvec3(1.0)}, 200, 3)) {
    const glm::dvec3 normal = glm::normalize(n);
    const auto frame = frameOf(normal, 0.7);
    EXPECT_EQ(frame[2], normal);
    EXPECT_LT(glm::length(glm::cross(frame[0], frame[1]) - normal), 1e-12);
    EXPECT_NEAR(glm::length(frame[0]), 1.0, 1e-12);
    EXPECT_NEAR(glm::dot(frame[0], frameOf(normal, 0.0)[0]), std::cos(0.7), 1e-12);
  }
  EXPECT_EQ(frameOf({0.0, 0.0, -1.0}, 0.0)[2].z, -1.0);
}

/// Everything about an open point is known: 1, 1, the normal, and the harmonics of the clamped cosine over pi (1, 2/3, 1/4 times Y).
void expectOpen(const PointVisibility& point, const glm::vec3& normal) {
  EXPECT_EQ(point.visible, 1.0f);
  EXPECT_EQ(point.ambient, 1.0f);
  EXPECT_EQ(point.direction, normal);
  EXPECT_EQ(point.bent, normal);
  EXPECT_FALSE(point.interior);
  const glm::dvec3 n(normal);
  const double k0 = 0.5 / std::sqrt(kPi), k1 = std::sqrt(3.0) * k0, k2 = std::sqrt(15.0) * k0;
  const double expected[9] = {k0,
                              2.0 / 3.0 * k1 * n.y,
                              2.0 / 3.0 * k1 * n.z,
                              2.0 / 3.0 * k1 * n.x,
                              0.25 * k2 * n.x * n.y,
                              0.25 * k2 * n.y * n.z,
                              0.25 * std::sqrt(5.0) / 2.0 * k0 * (3.0 * n.z * n.z - 1.0),
                              0.25 * k2 * n.x * n.z,
                              0.25 * k2 / 2.0 * (n.x * n.x - n.y * n.y)};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(point.transfer[i], expected[i], 1e-6) << i;
}

TEST(Visibility, ConvexMeshesSeeEverythingExactly) {
  for (const Mesh& mesh : {withNormals(reference::boxMesh({1.0, 2.0, 0.3})), withNormals(reference::icosphere(1.0, 3)),
                           withNormals(reference::moved(reference::icosphere(2.0, 1), {1e5, -3.0, 7.0}))}) {
    const std::vector<SurfacePoint> points = verticesOf(mesh);
    for (const int rays : {128, 256, 1024}) {
      const std::vector<PointVisibility> result = seen(mesh, points, rays, true);
      for (std::size_t i = 0; i < points.size(); ++i) expectOpen(result[i], points[i].normal);
    }
  }
}

TEST(Visibility, TheBottomOfABowlSeesItsOpening) {
  // The part of the unit sphere within the angle `opening` pi of its lowest point.
  for (const double opening : {0.4, 0.5, 0.75}) {
    Mesh bowl = test::sphereMesh(glm::dvec3(0.0), 1.0, 160, 256);
    std::erase_if(bowl.triangles, [&](const glm::uvec3& t) {
      const double highest = std::max({bowl.positions[t.x].z, bowl.positions[t.y].z, bowl.positions[t.z].z});
      return highest > -std::cos(opening * kPi) + 1e-9;
    });
    const PointVisibility point = seen(bowl, {{{0.0, 0.0, -1.0}, {0.0f, 0.0f, 1.0f}}}, 65536, true).front();
    const double half = std::atan2(std::sin(opening * kPi), 1.0 - std::cos(opening * kPi));  // the cone under which the rim is seen
    EXPECT_NEAR(point.visible, 1.0 - std::cos(half), 5e-4);
    EXPECT_NEAR(point.ambient, std::pow(std::sin(half), 2.0), 5e-4);
    EXPECT_NEAR(capRadius(point.visible), half, 1e-3);
    EXPECT_LT(glm::length(point.direction - glm::vec3(0.0f, 0.0f, 1.0f)), 2e-3f);
    // Zonal harmonics of a cap lit through the cosine, in closed form.
    const double k0 = 0.5 / std::sqrt(kPi), c = std::cos(half);
    EXPECT_NEAR(point.transfer[0], k0 * (1.0 - c * c), 5e-4);
    EXPECT_NEAR(point.transfer[2], std::sqrt(3.0) * k0 * 2.0 / 3.0 * (1.0 - c * c * c), 5e-4);
    EXPECT_NEAR(point.transfer[6], std::sqrt(5.0) / 2.0 * k0 * (1.5 * (1.0 - std::pow(c, 4.0)) - (1.0 - c * c)), 5e-4);
  }
}

TEST(Visibility, TheFloorBetweenTwoWallsSeesALune) {
  for (const double height : {0.5, 2.0}) {
    const Mesh walls = reference::joined(test::boxBetween({-1.5, -400.0, 0.0}, {-1.0, 400.0, height}),
                                         test::boxBetween({1.0, -400.0, 0.0}, {1.5, 400.0, height}));
    const double half = std::atan2(1.0, height);
    const PointVisibility middle = seen(walls, {{{0.0, 0.0, 0.0}, {0.0f, 0.0f, 1.0f}}}, 65536).front();
    EXPECT_NEAR(middle.visible, 2.0 * half / kPi, 5e-3);  // the walls end: they cover a little less than endless ones
    EXPECT_NEAR(middle.ambient, std::sin(half), 5e-3);
    // Off the middle: the lune leans, and its mean direction with it.
    const double left = std::atan2(1.5, height), right = std::atan2(0.5, height);
    const PointVisibility side = seen(walls, {{{0.5, 0.0, 0.0}, {0.0f, 0.0f, 1.0f}}}, 65536).front();
    EXPECT_NEAR(side.visible, (left + right) / kPi, 5e-3);
    EXPECT_NEAR(side.ambient, 0.5 * (std::sin(left) + std::sin(right)), 5e-3);
    const double lean = std::atan2(std::cos(right) - std::cos(left), std::sin(left) + std::sin(right));
    EXPECT_NEAR(std::atan2(-side.direction.x, side.direction.z), lean, 5e-3);
  }
}

TEST(Visibility, APlaneUnderASphereSeesABandRoundTheHorizon) {
  Mesh sphere = reference::icosphere(1.0, 5);
  for (const double height : {1.2, 3.0}) {
    const SurfacePoint below{{0.0, 0.0, -height}, {0.0f, 0.0f, 1.0f}};
    const PointVisibility point = seen(sphere, {below}, 65536).front();
    const double hidden = std::asin(1.0 / height);
    EXPECT_NEAR(point.visible, std::cos(hidden), 1e-3);
    EXPECT_NEAR(point.ambient, 1.0 - std::pow(std::sin(hidden), 2.0), 1e-3);
    EXPECT_LT(glm::length(point.direction - below.normal), 2e-3f);  // "which way should the aperture point?" (Oat and Sander, figure 8)
  }
}

TEST(Visibility, RaysAgreeWithBruteForceInDouble) {
  const Mesh mesh = withNormals(reference::torusMesh(1.0, 0.6, 48, 32));
  const double diag = diagonal(bounds(mesh));
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 13) points.push_back({mesh.positions[i], mesh.normals[i]});
  const std::vector<PointVisibility> result = seen(mesh, points, 256);
  const std::vector<glm::dvec3> directions = hemisphereDirections(256);
  std::size_t off = 0, hidden = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 normal(points[i].normal);
    const auto frame = frameOf(normal, azimuthOf(i));
    std::vector<glm::dvec3> turned;
    for (const glm::dvec3& d : directions) turned.push_back(frame[0] * d.x + frame[1] * d.y + frame[2] * d.z);
    const std::vector<char> hits = reference::blocked(mesh, points[i].position + kRayOffset * diag * normal, turned);
    const auto count = std::count(hits.begin(), hits.end(), 1);
    double cosines = 0.0;
    for (std::size_t r = 0; r < hits.size(); ++r) cosines += hits[r] ? 0.0 : directions[r].z;
    off += static_cast<std::size_t>(std::abs(std::lround(256.0 * (1.0 - static_cast<double>(result[i].visible))) - count));
    hidden += static_cast<std::size_t>(count);
    EXPECT_NEAR(result[i].ambient, 2.0 * cosines / 256.0, 0.02);
  }
  EXPECT_GT(hidden, 1000u);
  EXPECT_LE(off, hidden / 1000);  // single floats: a ray in a thousand may pass the other side of an edge
}

TEST(Visibility, PresetsAreAsAccurateAsTheyPromise) {
  const Mesh mesh = withNormals(reference::torusMesh(1.0, 0.7, 64, 48));
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 11) points.push_back({mesh.positions[i], mesh.normals[i]});
  const std::vector<PointVisibility> truth = seen(mesh, points, 65536);
  const auto check = [&](int rays, double ambient, double radius) {
    const std::vector<PointVisibility> coarse = seen(mesh, points, rays);
    double sumAmbient = 0.0, sumRadius = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      sumAmbient += std::pow(double{coarse[i].ambient} - double{truth[i].ambient}, 2.0);
      sumRadius += std::pow(double{capRadius(double{coarse[i].visible})} - double{capRadius(double{truth[i].visible})}, 2.0);
    }
    EXPECT_LT(std::sqrt(sumAmbient / static_cast<double>(points.size())), ambient) << rays;
    EXPECT_LT(std::sqrt(sumRadius / static_cast<double>(points.size())), radius) << rays;
  };
  check(256, 0.006, 0.010);
  check(1024, 0.0025, 0.004);
}

double ambientRmse(const std::vector<PointVisibility>& a, const std::vector<PointVisibility>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(double{a[i].ambient} - double{b[i].ambient}, 2.0);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(Visibility, ScaleAndPlaceChangeNothing) {
  const Mesh mesh = withNormals(reference::torusMesh(1.0, 0.6, 48, 32));
  const std::vector<PointVisibility> here = seen(mesh, verticesOf(mesh), 256);
  const double far = 1e5 * diagonal(bounds(mesh));
  for (const Mesh& other : {reference::scaled(mesh, 1e-4), reference::scaled(mesh, 1e4), reference::moved(mesh, {far, -far, far})}) {
    Mesh changed = other;
    changed.normals = mesh.normals;
    EXPECT_LT(ambientRmse(seen(changed, verticesOf(changed), 256), here), 0.002);
  }
  Mesh doubled = reference::scaled(mesh, 2.0);  // a power of two rounds nothing: the same bits
  doubled.normals = mesh.normals;
  EXPECT_EQ(ambientRmse(seen(doubled, verticesOf(doubled), 256), here), 0.0);
}

TEST(Visibility, TheNumberOfThreadsChangesNothing) {
  const Mesh mesh = withNormals(reference::joined(reference::torusMesh(1.0, 0.6, 96, 64), reference::icosphere(0.3, 4)));
  const auto run = [&](int threads) {
    tbb::task_arena arena(threads);
    return arena.execute([&] { return seen(mesh, verticesOf(mesh), 256, true); });
  };
  const std::vector<PointVisibility> one = run(1);
  for (const int threads : {2, 4}) {
    const std::vector<PointVisibility> many = run(threads);
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one[i].visible, many[i].visible);
      EXPECT_EQ(one[i].direction, many[i].direction);
      EXPECT_EQ(one[i].transfer, many[i].transfer);
    }
  }
}

TEST(Visibility, PointsInSolidsAreFlaggedAndPointsInRoomsAreNot) {
  const Mesh box = reference::boxMesh({1.0, 1.0, 1.0});
  const std::vector<SurfacePoint> points = {{{0.2, 0.1, -0.3}, {0.0f, 0.0f, 1.0f}}, {{0.0, 0.0, -1.0}, {0.0f, 0.0f, 1.0f}}};
  for (const PointVisibility& point : seen(box, points, 64)) {
    EXPECT_TRUE(point.interior);
    EXPECT_EQ(point.visible, 0.0f);
  }
  for (const PointVisibility& point : seen(reference::insideOut(box), points, 64)) {
    EXPECT_FALSE(point.interior);  // the walls of a room face inward
    EXPECT_EQ(point.visible, 0.0f);
    EXPECT_EQ(point.ambient, 0.0f);
    EXPECT_EQ(point.direction, points[0].normal);
  }
}

TEST(Visibility, ASealedRoomLetsNoRayOut) {
  const Mesh room = reference::insideOut(reference::icosphere(1.0, 4));
  std::vector<SurfacePoint> points;
  for (const glm::dvec3& p : reference::randomPoints({glm::dvec3(-0.5), glm::dvec3(0.5)}, 500, 9))
    points.push_back({p, glm::vec3(glm::normalize(p))});
  for (const PointVisibility& point : seen(room, points, 1024)) EXPECT_EQ(point.visible, 0.0f);
  // Among so many rays past so many edges some pass exactly between two triangles.
  points.resize(60);
  for (const PointVisibility& point : seen(reference::insideOut(reference::icosphere(1.0, 6)), points, 65536))
    EXPECT_EQ(point.visible, 0.0f);
}

/// A small square facing up, and what a point on it sees of the sphere of radius 1 that `hereFromThere` places.
PointVisibility underSphere(const glm::dmat4& hereFromThere) {
  Mesh square;
  square.positions = {{-0.1, -0.1, 0.0}, {0.1, -0.1, 0.0}, {0.1, 0.1, 0.0}, {-0.1, 0.1, 0.0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  auto here = makeRayScene(square);
  auto there = makeRayScene(reference::moved(reference::icosphere(1.0, 5), {50.0, 0.0, 0.0}), here.value().get());
  const Neighbour neighbour{there.value().get(), hereFromThere * glm::translate(glm::dmat4(1.0), {-50.0, 0.0, 0.0})};
  auto around = surround(*here.value(), {&neighbour, 1});
  EXPECT_TRUE(around.ok());
  const std::vector<SurfacePoint> points = {{{0.01, 0.02, 0.0}, {0.0f, 0.0f, 1.0f}}};
  return traceVisibility({here.value().get(), around.value().get()}, points, {65536, false}).front();
}

TEST(Visibility, NeighboursHideTheSkyWhereTheyLie) {
  // A sphere of radius 3 at a distance of 5 in one direction, plain, turned or mirrored: a cap of asin(3/5) is hidden.
  const glm::dvec3 towards = glm::normalize(glm::dvec3(0.3, -0.2, 0.9));
  const glm::dmat4 place = glm::scale(glm::translate(glm::dmat4(1.0), glm::dvec3(0.01, 0.02, 0.0) + 5.0 * towards), glm::dvec3(3.0));
  const glm::dmat4 turned = glm::rotate(place, 1.0, glm::dvec3(1.0, 2.0, 0.5));
  const glm::dmat4 mirrored = glm::scale(turned, glm::dvec3(-1.0, 1.0, 1.0));
  for (const glm::dmat4& transform : {place, turned, mirrored}) {
    const PointVisibility point = underSphere(transform);
    EXPECT_NEAR(point.visible, std::cos(std::asin(0.6)), 1e-3);            // 1 - (1 - cos): all of the cap is above the horizon
    EXPECT_NEAR(point.ambient, 1.0 - 0.36 * towards.z, 1e-3);              // the projected solid angle of a cap above the horizon
    EXPECT_LT(glm::dot(glm::dvec3(point.direction), towards), towards.z);  // leans away
    EXPECT_FALSE(point.interior);
  }
}

TEST(Visibility, PointsInsideOfANeighbourAreInterior) {
  for (const double sign : {1.0, -1.0}) {
    const PointVisibility point = underSphere(glm::scale(glm::dmat4(1.0), glm::dvec3(2.0, 2.0 * sign, 2.0)));
    EXPECT_TRUE(point.interior);
    EXPECT_EQ(point.visible, 0.0f);
  }
  EXPECT_EQ(underSphere(glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 0.0, 1.0))).visible, 1.0f);  // flattened: left out
}

TEST(Visibility, AMeshWithoutExtentIsAnError) {
  Mesh mesh;
  mesh.positions.assign(3, glm::dvec3(1.0));
  mesh.triangles = {{0, 1, 2}};
  EXPECT_FALSE(makeRayScene(mesh).ok());
}

TEST(Visibility, AStoppedJobStops) {
  const Mesh mesh = withNormals(reference::icosphere(1.0, 4));
  auto scene = makeRayScene(mesh);
  ASSERT_TRUE(scene.ok());
  int calls = 0;
  tbb::task_arena arena(1);
  arena.execute([&] { traceVisibility({scene.value().get(), nullptr}, verticesOf(mesh), {}, [&](double) { return ++calls < 2; }); });
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace overcast
