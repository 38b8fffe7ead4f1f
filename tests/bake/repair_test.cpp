#include "bake/repair.h"

#include <algorithm>
#include <array>
#include <random>

#include <gtest/gtest.h>

#include "bake/outside.h"
#include "tests/bake/test_meshes.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using namespace test;
using reference::insideOut;
using reference::joined;
using reference::torusMesh;
using reference::unwelded;

/// Corner positions of every triangle, each triangle from its smallest corner on, sorted: the mesh without its order.
std::vector<std::array<std::array<double, 3>, 3>> surfaceOf(const Mesh& mesh) {
  std::vector<std::array<std::array<double, 3>, 3>> surface;
  for (const glm::uvec3& t : mesh.triangles) {
    std::array<std::array<double, 3>, 3> corner{};
    for (int c = 0; c < 3; ++c) {
      const glm::dvec3& p = mesh.positions[t[c]];
      corner[static_cast<std::size_t>(c)] = {p.x, p.y, p.z};
    }
    std::rotate(corner.begin(), std::min_element(corner.begin(), corner.end()), corner.end());
    surface.push_back(corner);
  }
  std::sort(surface.begin(), surface.end());
  return surface;
}

double volumeOf(const Mesh& mesh) {
  double sum = 0.0;
  for (const glm::uvec3& t : mesh.triangles) sum += glm::dot(mesh.positions[t.x], glm::cross(mesh.positions[t.y], mesh.positions[t.z]));
  return sum / 6.0;
}

TEST(Repair, LeavesACleanMeshAlone) {
  const Mesh mesh = torusMesh(1.0, 0.4, 20, 10);
  const RepairedMesh repaired = repair(mesh);
  EXPECT_EQ(repaired.mesh.positions.size(), mesh.positions.size());
  EXPECT_EQ(surfaceOf(repaired.mesh), surfaceOf(mesh));
  EXPECT_TRUE(repaired.found.closed);
  EXPECT_FALSE(repaired.found.insideOut);
  EXPECT_EQ(repaired.found.components, 1u);
  EXPECT_EQ(repaired.found.verticesMerged + repaired.found.degenerateTriangles + repaired.found.duplicateTriangles +
                repaired.found.boundaryEdges + repaired.found.nonManifoldEdges + repaired.found.inconsistentEdges +
                repaired.found.reorientedTriangles,
            0u);
}

TEST(Repair, WeldsExactlyEqualPositionsOnly) {
  const Mesh sphere = sphereMesh(glm::dvec3(0.0), 1.0, 8, 12);
  const RepairedMesh repaired = repair(unwelded(sphere));
  EXPECT_EQ(repaired.mesh.positions.size(), sphere.positions.size());
  EXPECT_EQ(repaired.found.verticesMerged, sphere.triangles.size() * 3 - sphere.positions.size());
  EXPECT_TRUE(repaired.found.closed);

  Mesh apart = unwelded(boxBetween(glm::dvec3(0.0), glm::dvec3(1.0)));
  apart.positions[0].x = std::nextafter(apart.positions[0].x, 1.0);
  EXPECT_FALSE(repair(apart).found.closed);
}

TEST(Repair, OrientsAShuffledClosedMeshOutward) {
  std::mt19937 random(3);
  Mesh mesh = torusMesh(1.0, 0.4, 20, 10);
  const double volume = volumeOf(mesh);
  for (glm::uvec3& t : mesh.triangles)
    if (random() % 2) std::swap(t.x, t.y);
  const RepairedMesh repaired = repair(mesh);
  EXPECT_TRUE(repaired.found.closed);
  EXPECT_GT(repaired.found.inconsistentEdges, 0u);
  EXPECT_GT(repaired.found.reorientedTriangles, 0u);
  EXPECT_NEAR(volumeOf(repaired.mesh), volume, 1e-12);
}

TEST(Repair, KeepsConsistentComponentsAsTheyAre) {
  Mesh mesh = joined(sphereMesh(glm::dvec3(0.0), 1.0, 10, 12), insideOut(sphereMesh(glm::dvec3(0.0), 0.5, 10, 12)));  // a cavity
  const auto given = surfaceOf(mesh);
  Mesh mixed = boxBetween(glm::dvec3(2.0), glm::dvec3(3.0));
  std::swap(mixed.triangles[4].x, mixed.triangles[4].y);
  mesh = joined(mesh, mixed);
  const RepairedMesh repaired = repair(mesh);
  const auto kept = surfaceOf(repaired.mesh);
  EXPECT_TRUE(std::includes(kept.begin(), kept.end(), given.begin(), given.end()));
  EXPECT_EQ(repaired.found.reorientedTriangles, 1u);
  EXPECT_EQ(repaired.found.inconsistentEdges, 3u);
  EXPECT_EQ(repaired.found.components, 3u);
  EXPECT_TRUE(repaired.found.closed);

  const RepairedMesh inverted = repair(insideOut(boxBetween(glm::dvec3(2.0), glm::dvec3(3.0))));
  EXPECT_TRUE(inverted.found.insideOut);
  EXPECT_EQ(inverted.found.reorientedTriangles, 0u);
}

TEST(Repair, AnOpenComponentKeepsTheSideOfMostOfItsArea) {
  Mesh mesh = sphereMesh(glm::dvec3(0.0), 1.0, 16, 16);
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 48);
  const std::vector<glm::uvec3> given = mesh.triangles;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i].x, mesh.triangles[i].y);
  const RepairedMesh repaired = repair(mesh);
  EXPECT_FALSE(repaired.found.closed);
  EXPECT_EQ(repaired.found.boundaryEdges, 16u);
  EXPECT_EQ(repaired.found.reorientedTriangles, (given.size() + 2) / 3);
}

TEST(Repair, CountsDegenerateDuplicateAndNonManifold) {
  Mesh mesh = boxBetween(glm::dvec3(0.0), glm::dvec3(1.0));
  mesh.triangles.push_back({mesh.triangles[3].y, mesh.triangles[3].z, mesh.triangles[3].x});  // the same again
  mesh.triangles.emplace_back(0, 0, 1);
  mesh.positions.emplace_back(0.5, 0.0, 0.0);
  mesh.triangles.emplace_back(0, 8, 1);  // collinear
  const RepairedMesh repaired = repair(mesh);
  EXPECT_EQ(repaired.mesh.triangles.size(), 14u);
  EXPECT_EQ(repaired.found.duplicateTriangles, 1u);
  EXPECT_EQ(repaired.found.degenerateTriangles, 2u);
  EXPECT_EQ(repaired.found.nonManifoldEdges, 1u);
  EXPECT_EQ(repaired.found.boundaryEdges, 3u);
}

// Two tetrahedra glued along a face that both have: nothing is open, and the wall between them says nothing about orientation.
TEST(Repair, OppositePairsCancel) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 1, 2}, {1, 0, 4}, {2, 1, 4}, {0, 2, 4}};
  const RepairedMesh repaired = repair(mesh);
  EXPECT_TRUE(repaired.found.closed);
  EXPECT_EQ(repaired.found.duplicateTriangles, 0u);
  EXPECT_EQ(repaired.found.inconsistentEdges, 0u);
  EXPECT_EQ(repaired.found.reorientedTriangles, 0u);
  EXPECT_NEAR(volumeOf(repaired.mesh), 1.0 / 3.0, 1e-15);
}

TEST(Repair, ADoubleSidedSolidIsASolid) {
  const Mesh torus = torusMesh(1.0, 0.4, 20, 10);
  Mesh mesh = joined(boxBetween(glm::dvec3(3.0), glm::dvec3(4.0)), joined(torus, insideOut(torus)));
  const RepairedMesh repaired = repair(mesh);
  EXPECT_TRUE(repaired.found.closed);
  EXPECT_EQ(repaired.found.components, 2u);
  EXPECT_EQ(repaired.found.duplicateTriangles, torus.triangles.size());
  EXPECT_NEAR(volumeOf(repaired.mesh), 1.0 + volumeOf(torus), 1e-12);
}

TEST(Repair, AMoebiusStripStaysOpen) {
  Mesh mesh;
  constexpr std::uint32_t kCount = 20;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const double u = 2.0 * std::numbers::pi * i / kCount;
    for (const double side : {-0.3, 0.3})
      mesh.positions.emplace_back((1.0 + side * std::cos(u / 2)) * std::cos(u), (1.0 + side * std::cos(u / 2)) * std::sin(u),
                                  side * std::sin(u / 2));
  }
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * i + 1;
    const std::uint32_t c = i + 1 < kCount ? 2 * i + 2 : 1, d = i + 1 < kCount ? 2 * i + 3 : 0;
    mesh.triangles.emplace_back(a, c, b);
    mesh.triangles.emplace_back(b, c, d);
  }
  const RepairedMesh repaired = repair(mesh);
  EXPECT_EQ(repaired.mesh.triangles.size(), mesh.triangles.size());
  EXPECT_FALSE(repaired.found.closed);
  EXPECT_GT(repaired.found.inconsistentEdges, 0u);
}

TEST(Repair, KleinBottleIsNotClosedForTheWindingNumber) {
  Mesh mesh;
  constexpr std::uint32_t kAround = 12, kAcross = 8;
  for (std::uint32_t i = 0; i < kAround; ++i)
    for (std::uint32_t j = 0; j < kAcross; ++j) mesh.positions.emplace_back(i, j, (i * 7 + j * 3) % 5);
  const auto at = [](std::uint32_t i, std::uint32_t j) { return i < kAround ? i * kAcross + j % kAcross : (2 * kAcross - j) % kAcross; };
  for (std::uint32_t i = 0; i < kAround; ++i)
    for (std::uint32_t j = 0; j < kAcross; ++j) {
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  EXPECT_FALSE(repair(mesh).found.closed);
}

/// Every triangle on its own, a little apart from its neighbours; half of them turned.
Mesh unorientedSoup(const Mesh& mesh) {
  Mesh soup = unwelded(mesh);
  for (const glm::uvec3& t : soup.triangles) {
    const glm::dvec3 middle = (soup.positions[t.x] + soup.positions[t.y] + soup.positions[t.z]) / 3.0;
    for (int i = 0; i < 3; ++i) soup.positions[t[i]] = middle + 0.95 * (soup.positions[t[i]] - middle);
  }
  return reference::withFlips(soup, 0.5, 9);
}

TEST(Outside, TurnsASoupOfAClosedShapeOutward) {
  const Mesh torus = torusMesh(1.0, 0.4, 48, 24);
  RepairedMesh repaired = repair(unorientedSoup(torus));
  const std::uint64_t turned = orientByOutside(repaired);
  EXPECT_EQ(turned, repaired.found.turnedOutward);
  EXPECT_NEAR(static_cast<double>(turned), 0.5 * static_cast<double>(torus.triangles.size()), 100.0);
  for (const glm::uvec3& t : repaired.mesh.triangles) {
    const auto& p = repaired.mesh.positions;
    const glm::dvec3 middle = (p[t.x] + p[t.y] + p[t.z]) / 3.0;
    const glm::dvec3 ring = glm::normalize(glm::dvec3(middle.x, 0.0, middle.z));
    ASSERT_GT(glm::dot(glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]), middle - ring), 0.0);
  }
}

// So many triangles of any orientation that their winding number is next to nothing everywhere.
TEST(Outside, TurnsAFineSoupOutward) {
  RepairedMesh repaired = repair(unorientedSoup(torusMesh(1.0, 0.4, 240, 120)));
  orientByOutside(repaired);
  EXPECT_NEAR(volumeOf(repaired.mesh), 2.0 * std::numbers::pi * std::numbers::pi * 0.16 * 0.9025, 0.05);
}

TEST(Outside, LeavesSheetsHolesAndClosedMeshesAlone) {
  Mesh sheet = boxBetween(glm::dvec3(0.0), glm::dvec3(1.0));
  sheet.triangles.resize(2);
  Mesh bowl = sphereMesh(glm::dvec3(0.0), 1.0, 24, 32);
  bowl.triangles.erase(bowl.triangles.begin(), bowl.triangles.begin() + 700);
  const Mesh inverted = insideOut(sphereMesh(glm::dvec3(0.0), 1.0, 24, 32));
  for (const Mesh* mesh : std::initializer_list<const Mesh*>{&sheet, &bowl, &inverted}) {
    RepairedMesh repaired = repair(*mesh);
    EXPECT_EQ(orientByOutside(repaired), 0u);
    EXPECT_EQ(repaired.mesh.triangles, repair(*mesh).mesh.triangles);
  }
}

TEST(Repair, OnlyDegenerateTrianglesDoNotCrash) {
  Mesh mesh;
  mesh.positions = {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}};
  mesh.triangles = {{0, 1, 2}};
  const RepairedMesh repaired = repair(mesh);
  EXPECT_EQ(repaired.found.degenerateTriangles, 1u);
  EXPECT_EQ(repaired.mesh.triangles.size(), 1u);
  EXPECT_EQ(repair(Mesh{}).mesh.triangles.size(), 0u);
}

TEST(Repair, AHundredThousandFacesAreWeldedAndTurned) {
  Mesh mesh = torusMesh(1.0, 0.4, 400, 125);
  std::swap(mesh.triangles[7].x, mesh.triangles[7].y);
  const RepairedMesh repaired = repair(unwelded(mesh));
  EXPECT_TRUE(repaired.found.closed);
  EXPECT_EQ(repaired.found.reorientedTriangles, 1u);
  EXPECT_EQ(repaired.mesh.triangles.size(), mesh.triangles.size());
}

}  // namespace
}  // namespace overcast
