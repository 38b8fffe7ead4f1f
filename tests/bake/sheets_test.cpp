#include "bake/sheets.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <glm/gtc/quaternion.hpp>

#include "bake/examine.h"
#include "bake/measure.h"
#include "bake/volume.h"
#include "tests/bake/test_meshes.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using namespace test;
using reference::boxMesh;
using reference::insideOut;
using reference::joined;
using reference::moved;

/// The square [-1, 1]^2 in the plane z = 0, a grid of cells so that its interior has vertices.
Mesh square() {
  Mesh mesh;
  constexpr std::uint32_t kCells = 4;
  for (std::uint32_t j = 0; j <= kCells; ++j)
    for (std::uint32_t i = 0; i <= kCells; ++i) mesh.positions.emplace_back(0.5 * i - 1.0, 0.5 * j - 1.0, 0.0);
  for (std::uint32_t j = 0; j < kCells; ++j)
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::uint32_t a = j * (kCells + 1) + i;
      mesh.triangles.emplace_back(a, a + 1, a + kCells + 2);
      mesh.triangles.emplace_back(a, a + kCells + 2, a + kCells + 1);
    }
  return mesh;
}

double squareDistance(const glm::dvec3& p) {
  return glm::length(glm::dvec3(glm::max(glm::abs(glm::dvec2(p)) - 1.0, 0.0), p.z));
}

Mesh turned(Mesh mesh, const glm::dquat& turn) {
  for (glm::dvec3& p : mesh.positions) p = turn * p;
  return mesh;
}

BakedVolume baked(const Mesh& mesh, int resolution, SheetMode mode = SheetMode::automatic, double thickness = 0.0) {
  VolumeSettings settings;
  settings.resolution = resolution;
  settings.bits = VolumeBits::single;
  settings.sheets = {mode, thickness};
  const auto result = bakeVolume(mesh, settings);
  EXPECT_TRUE(result.ok());
  return result.ok() ? result.value() : BakedVolume{};
}

template <class Formula>
void expectSamples(const Volume& volume, Formula formula) {
  const Grid grid{volume.size, volume.origin, volume.voxelSize};
  for (std::uint64_t i = 0; i < volume.distance.size(); ++i)
    ASSERT_NEAR(volume.distance[i], formula(samplePoint(grid, i)), 1e-4 * volume.voxelSize) << "sample " << i;
}

TEST(Sheets, ASheetIsItsDistanceLessHalfTheThickness) {
  for (const double thickness : {0.0, 0.3}) {
    const BakedVolume sheet = baked(square(), 24, SheetMode::automatic, thickness);
    const double stated = sheet.volume.sheetThickness;
    EXPECT_EQ(sheet.volume.inside, Inside::none);
    EXPECT_EQ(sheet.volume.signMethod, kTwoSided);
    EXPECT_EQ(sheet.sheetTriangles, square().triangles.size());
    EXPECT_DOUBLE_EQ(stated, thickness > 0.0 ? thickness : std::sqrt(3.0) * sheet.volume.voxelSize);
    expectSamples(sheet.volume, [&](const glm::dvec3& p) { return squareDistance(p) - 0.5 * stated; });
    EXPECT_EQ(sheet.error.signErrors, 0u);
    EXPECT_LT(sheet.error.max, sheet.volume.voxelSize);
  }
}

// The bound of leastThickness holds wherever the sheet lies in the grid.
RC_GTEST_PROP(Sheets, HaveNoHoleHoweverTheyLie, ()) {
  const auto numbers = *rc::gen::container<std::vector<int>>(4, rc::gen::inRange(-100, 101));
  const glm::dquat turn = glm::normalize(glm::dquat(numbers[0] + 0.5, numbers[1], numbers[2], numbers[3]));
  const Mesh mesh = turned(square(), turn);
  const BakedVolume sheet = baked(mesh, 16 + std::abs(numbers[0]) % 7);
  for (const glm::dvec3& u : reference::randomPoints({glm::dvec3(-1.0), glm::dvec3(1.0)}, 400, 5))
    RC_ASSERT(sampleVolume(sheet.volume, turn * glm::dvec3(u.x, u.y, 0.0)) <= 1e-5 * sheet.volume.voxelSize);
}

TEST(Sheets, ThinnerOnesHaveHoles) {
  const glm::dquat turn = glm::angleAxis(0.5, glm::normalize(glm::dvec3(1.0, 0.3, 0.2)));
  const BakedVolume thin = baked(turned(square(), turn), 24, SheetMode::automatic, 0.001);
  int holes = 0;
  for (const glm::dvec3& u : reference::randomPoints({glm::dvec3(-1.0), glm::dvec3(1.0)}, 400, 5))
    holes += sampleVolume(thin.volume, turn * glm::dvec3(u.x, u.y, 0.0)) > 0.0 ? 1 : 0;
  EXPECT_GT(holes, 300);
}

TEST(Sheets, SolidsBesideThemKeepTheirInside) {
  const Mesh mesh = joined(boxMesh(glm::dvec3(0.5)), moved(square(), glm::dvec3(0.0, 0.0, 1.5)));
  const BakedVolume both = baked(mesh, 32);
  EXPECT_EQ(both.volume.inside, Inside::partly);
  EXPECT_EQ(both.sheetTriangles, square().triangles.size());
  EXPECT_EQ(both.volume.signMethod, "signed-crossings");
  expectSamples(both.volume, [&](const glm::dvec3& p) {
    return std::min(reference::boxDistance(p, glm::dvec3(0.5)),
                    squareDistance(p - glm::dvec3(0.0, 0.0, 1.5)) - 0.5 * both.volume.sheetThickness);
  });
}

TEST(Sheets, PlatesAreSheetsOnlyWhereVoxelsMissThem) {
  const Mesh plate = boxMesh(glm::dvec3(1.0, 1.0, 0.02));
  EXPECT_EQ(baked(plate, 24).volume.inside, Inside::none);
  EXPECT_EQ(baked(plate, 64).volume.inside, Inside::solid);
  EXPECT_EQ(baked(boxMesh(glm::dvec3(1.0)), kMinResolution).volume.inside, Inside::solid);
}

TEST(Sheets, HolesAndCavitiesMakeNone) {
  Mesh holed = sphereMesh(glm::dvec3(0.0), 1.0, 24, 32);
  holed.triangles.erase(holed.triangles.begin(), holed.triangles.begin() + 160);
  EXPECT_EQ(baked(holed, 24).volume.inside, Inside::open);
  const Mesh hollow = joined(sphereMesh(glm::dvec3(0.0), 1.0, 16, 24), insideOut(sphereMesh(glm::dvec3(0.0), 0.6, 16, 24)));
  EXPECT_EQ(baked(hollow, 24).volume.inside, Inside::solid);
  // Six sheets that together are a box.
  Mesh apart;
  const Mesh box = boxMesh(glm::dvec3(1.0));
  for (std::size_t face = 0; face < 6; ++face) {
    Mesh one = box;
    one.triangles = {box.triangles[2 * face], box.triangles[2 * face + 1]};
    apart = joined(apart, moved(one, glm::dvec3(1e-6 * static_cast<double>(face))));
  }
  const BakedVolume six = baked(apart, 24);
  EXPECT_EQ(six.volume.inside, Inside::open);
  EXPECT_LT(sampleVolume(six.volume, glm::dvec3(0.0)), -0.9);
}

TEST(Sheets, AskedForEverythingIsHollow) {
  const BakedVolume hollow = baked(boxMesh(glm::dvec3(1.0)), 32, SheetMode::all, 0.2);
  EXPECT_EQ(hollow.volume.inside, Inside::none);
  expectSamples(hollow.volume, [](const glm::dvec3& p) { return std::abs(reference::boxDistance(p, glm::dvec3(1.0))) - 0.1; });
}

TEST(Sheets, AreMeasuredByTheirOwnDefinition) {
  const Mesh mesh = joined(boxMesh(glm::dvec3(0.5)), moved(square(), glm::dvec3(0.3, 0.0, 1.5)));
  const BakedVolume both = baked(mesh, 48);
  const Probes probes = drawProbes(mesh, {2048, 3});
  const MeasuredError error = measure(Asset(both.volume), probes);
  EXPECT_EQ(error.signErrors, 0u);
  EXPECT_LT(error.surfaceRms, 0.5 * both.volume.voxelSize);
  Volume lie = both.volume;
  lie.sheetThickness *= 3.0;
  EXPECT_GT(measure(Asset(lie), probes).surfaceRms, 0.5 * both.volume.voxelSize);
}

TEST(Examine, CountsEdgesThatPassThrough) {
  const Mesh box = boxMesh(glm::dvec3(1.0));
  EXPECT_EQ(examineSurface(repair(box), 0.1).edgesPiercing, 0u);
  EXPECT_EQ(examineSurface(repair(box), 0.1).edges, 18u);
  EXPECT_EQ(examineSurface(repair(joined(box, moved(box, glm::dvec3(5.0, 0.0, 0.0)))), 0.1).edgesPiercing, 0u);
  // A corner of each box within the other: three edges of either pass a face.
  const SurfaceReport overlap = examineSurface(repair(joined(box, moved(box, glm::dvec3(1.1, 0.9, 1.3)))), 0.1);
  EXPECT_GE(overlap.edgesPiercing, 6u);
  EXPECT_LE(overlap.edgesPiercing, 12u);
}

TEST(Examine, MeasuresWhatIsThinAndWhatLiesInside) {
  const Mesh box = boxMesh(glm::dvec3(1.0));
  EXPECT_EQ(examineSurface(repair(box), 0.5).thinShare, 0.0);
  const Mesh plate = boxMesh(glm::dvec3(1.0, 1.0, 0.05));
  EXPECT_NEAR(examineSurface(repair(plate), 0.2).thinShare, 8.0 / 8.8, 0.03);  // all but the narrow sides
  EXPECT_EQ(examineSurface(repair(plate), 0.05).thinShare, 0.0);
  const Mesh inner = boxMesh(glm::dvec3(0.5));
  EXPECT_NEAR(examineSurface(repair(joined(box, inner)), 0.1).innerShare, 0.2, 0.02);
  EXPECT_EQ(examineSurface(repair(joined(box, insideOut(inner))), 0.1).innerShare, 0.0);  // a cavity
}

}  // namespace
}  // namespace overcast
