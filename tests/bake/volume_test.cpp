#include "bake/volume.h"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>

#include "tests/bake/test_meshes.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using namespace reference;

BakedVolume baked(const Mesh& mesh, const VolumeSettings& settings = {}) {
  const Result<BakedVolume> result = bakeVolume(mesh, settings);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : message(result.error()));
  return result.ok() ? result.value() : BakedVolume{};
}

/// Largest difference between the samples and a formula, in voxels.
template <class Formula>
double worstSample(const Volume& volume, Formula formula) {
  const Grid grid{volume.size, volume.origin, volume.voxelSize};
  double worst = 0.0;
  for (std::uint64_t i = 0; i < volume.distance.size(); ++i)
    worst = std::max(worst, std::abs(volume.distance[i] - formula(test::samplePoint(grid, i))));
  return worst / volume.voxelSize;
}

VolumeSettings singles(int resolution = 32) {
  VolumeSettings settings;
  settings.resolution = resolution;
  settings.bits = VolumeBits::single;
  return settings;
}

TEST(BakeVolume, SphereIsItsFormula) {
  const BakedVolume sphere = baked(icosphere(1.0, 5), singles());
  EXPECT_EQ(sphere.volume.size, glm::ivec3(32));
  EXPECT_EQ(sphere.volume.signMethod, "signed-crossings");
  const double sag = icosphereSag(1.0, 5) / sphere.volume.voxelSize;
  EXPECT_LT(worstSample(sphere.volume, [](const glm::dvec3& p) { return sphereDistance(p, 1.0); }), sag + 1e-5);
  EXPECT_EQ(sphere.error.signErrors, 0u);
  EXPECT_LT(sphere.error.rms, 0.05 * sphere.volume.voxelSize);
  EXPECT_EQ(sphere.error.samples, 4096u);
}

TEST(BakeVolume, BoxIsItsFormula) {
  const glm::dvec3 half(1.0, 0.5, 0.25);
  const BakedVolume box = baked(boxMesh(half), singles());
  EXPECT_LT(worstSample(box.volume, [&](const glm::dvec3& p) { return boxDistance(p, half); }), 1e-5);
  // 27 cells span the long side and 4 are padding; the short sides get what they need and no more.
  EXPECT_EQ(box.volume.size, glm::ivec3(32, 19, 12));
  const Box bounds = overcast::bounds(box.volume);
  for (int axis = 0; axis < 3; ++axis) EXPECT_GE(bounds.max[axis], half[axis] + 1.999 * box.volume.voxelSize);
}

TEST(BakeVolume, TorusIsItsFormula) {
  const BakedVolume torus = baked(torusMesh(1.0, 0.4, 400, 200), singles(40));
  EXPECT_LT(worstSample(torus.volume, [](const glm::dvec3& p) { return torusDistance(p, 1.0, 0.4); }), 0.01);
}

TEST(BakeVolume, ErrorIsThatOfTheStoredHalves) {
  VolumeSettings settings;
  settings.bits = VolumeBits::half;
  const BakedVolume halves = baked(icosphere(1.0, 4), settings);
  const Volume again = asStored(halves.volume, VolumeBits::half);
  EXPECT_EQ(again.distance, halves.volume.distance);
  const BakedVolume floats = baked(icosphere(1.0, 4), singles());
  EXPECT_NE(floats.volume.distance, halves.volume.distance);
  EXPECT_NE(floats.error.rms, halves.error.rms);
  EXPECT_NEAR(floats.error.rms, halves.error.rms, 0.01 * floats.volume.voxelSize);
}

TEST(BakeVolume, EightBitsAreWithinHalfAStepAndMeasuredAsSuch) {
  VolumeSettings settings;
  settings.bits = VolumeBits::snorm8;
  const BakedVolume eight = baked(icosphere(1.0, 4), settings);
  const BakedVolume floats = baked(icosphere(1.0, 4), singles());
  const double step = eight.volume.step;
  ASSERT_GT(step, 0.0);
  for (std::size_t i = 0; i < floats.volume.distance.size(); ++i)
    ASSERT_NEAR(eight.volume.distance[i], floats.volume.distance[i], 0.5001 * step);
  // Rounding adds a uniform error of a standard deviation of step / sqrt(12), less what interpolation averages out.
  EXPECT_GT(eight.error.rms, floats.error.rms);
  EXPECT_LT(eight.error.rms, std::hypot(floats.error.rms, step / std::sqrt(12.0)));
  EXPECT_EQ(eight.error.signErrors, 0u);
}

// What `measure` reports, recomputed from closed forms at other points.
TEST(BakeVolume, MeasuredErrorAgreesWithTheFormula) {
  const glm::dvec3 half(1.0, 0.7, 0.4);
  VolumeSettings settings = singles();
  settings.errorSamples = 40000;
  const BakedVolume box = baked(boxMesh(half), settings);
  double squares = 0.0, worst = 0.0;
  const std::vector<glm::dvec3> points = randomPoints(bounds(box.volume), 40000, 77);
  for (const glm::dvec3& p : points) {
    const double difference = sampleVolume(box.volume, p) - boxDistance(p, half);
    squares += difference * difference;
    worst = std::max(worst, std::abs(difference));
  }
  EXPECT_NEAR(box.error.rms / std::sqrt(squares / 40000.0), 1.0, 0.05);
  EXPECT_NEAR(box.error.max / worst, 1.0, 0.1);
  EXPECT_EQ(box.error.signErrors, 0u);
}

TEST(BakeVolume, PlaceAndScaleChangeNothing) {
  const Mesh mesh = torusMesh(1.0, 0.4, 48, 24);
  const BakedVolume plain = baked(mesh, singles());
  const double size = 2.8;
  for (const double scale : {1e-4, 1.0, 1e4})
    for (const double offset : {0.0, 1e5}) {
      const BakedVolume other =
          baked(moved(scaled(mesh, scale), glm::dvec3(offset * size * scale, -offset * size * scale, 0.0)), singles());
      ASSERT_EQ(other.volume.size, plain.volume.size) << scale << " " << offset;
      double worst = 0.0;
      for (std::size_t i = 0; i < plain.volume.distance.size(); ++i)
        worst = std::max(worst, std::abs(other.volume.distance[i] / scale - plain.volume.distance[i]));
      // 1e5 diagonals away doubles resolve 1e-11 of the mesh; single floats 1e-7 of the distance.
      EXPECT_LT(worst / plain.volume.voxelSize, 1e-5) << scale << " " << offset;
      EXPECT_EQ(other.error.signErrors, 0u);
    }
}

TEST(BakeVolume, TurningTheAxesTurnsTheVolume) {
  Mesh mesh = torusMesh(1.0, 0.4, 40, 20);
  mesh = joined(mesh, moved(boxMesh(glm::dvec3(0.3, 0.2, 0.5)), glm::dvec3(0.9, 0.4, 0.1)));
  const BakedVolume plain = baked(mesh, singles());
  Mesh turned = mesh;
  for (glm::dvec3& p : turned.positions) p = glm::dvec3(p.y, p.z, p.x);  // a third of a turn about the diagonal: permutes the axes
  const BakedVolume other = baked(turned, singles());
  ASSERT_EQ(other.volume.size, glm::ivec3(plain.volume.size.y, plain.volume.size.z, plain.volume.size.x));
  double worst = 0.0;
  for (int k = 0; k < plain.volume.size.z; ++k)
    for (int j = 0; j < plain.volume.size.y; ++j)
      for (int i = 0; i < plain.volume.size.x; ++i) {
        const float a = plain.volume.distance[sampleIndex(plain.volume, i, j, k)];
        const float b = other.volume.distance[sampleIndex(other.volume, j, k, i)];
        worst = std::max(worst, std::abs(double{a} - double{b}));
      }
  EXPECT_LT(worst / plain.volume.voxelSize, 1e-5);
}

TEST(BakeVolume, SpoiledMeshesGiveTheSameVolume) {
  const Mesh mesh = torusMesh(1.0, 0.4, 40, 20);
  const BakedVolume plain = baked(mesh, singles());
  for (const Mesh& spoiled : {insideOut(mesh), unwelded(mesh), withDuplicates(mesh, 0.5, 3), withFlips(mesh, 0.4, 4), joined(mesh, mesh)}) {
    const BakedVolume other = baked(spoiled, singles());
    ASSERT_EQ(other.volume.size, plain.volume.size);
    EXPECT_EQ(other.volume.distance, plain.volume.distance);
    EXPECT_EQ(other.volume.signMethod, "signed-crossings");
  }
}

TEST(BakeVolume, OverlappingSolidsAreSolidThroughout) {
  const Mesh mesh = joined(moved(icosphere(1.0, 4), glm::dvec3(-0.5, 0.0, 0.0)), moved(icosphere(1.0, 4), glm::dvec3(0.5, 0.0, 0.0)));
  const BakedVolume both = baked(mesh, singles(48));
  const Grid grid{both.volume.size, both.volume.origin, both.volume.voxelSize};
  for (std::uint64_t i = 0; i < both.volume.distance.size(); ++i) {
    const glm::dvec3 p = test::samplePoint(grid, i);
    const double phi = std::min(sphereDistance(p - glm::dvec3(-0.5, 0.0, 0.0), 1.0), sphereDistance(p - glm::dvec3(0.5, 0.0, 0.0), 1.0));
    if (std::abs(phi) > 0.01) {
      ASSERT_EQ(both.volume.distance[i] < 0.0f, phi < 0.0);
    }
  }
  EXPECT_EQ(both.found.components, 2u);
}

TEST(BakeVolume, SmallHolesChangeNoSignAwayFromThem) {
  const Mesh sphere = icosphere(1.0, 4);
  const BakedVolume open = baked(withHoles(sphere, 0.01, 9), singles());
  EXPECT_EQ(open.volume.signMethod, "winding-number");
  EXPECT_FALSE(open.found.closed);
  const Grid grid{open.volume.size, open.volume.origin, open.volume.voxelSize};
  for (std::uint64_t i = 0; i < open.volume.distance.size(); ++i) {
    const double phi = sphereDistance(test::samplePoint(grid, i), 1.0);
    if (std::abs(phi) > 0.1) {
      ASSERT_EQ(open.volume.distance[i] < 0.0f, phi < 0.0);
    }
  }
}

TEST(BakeVolume, AFlatSheetWithoutTwoSidesBakesAsAllOutside) {
  Mesh sheet;
  sheet.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  VolumeSettings settings = singles(20);
  settings.sheets.mode = SheetMode::none;
  const BakedVolume flat = baked(sheet, settings);
  EXPECT_EQ(flat.volume.size, glm::ivec3(20, 20, 5));
  EXPECT_EQ(flat.volume.inside, Inside::open);
  EXPECT_EQ(flat.volume.sheetThickness, 0.0);
  for (const float d : flat.volume.distance) EXPECT_GE(d, 0.0f);
}

TEST(BakeVolume, VerticesThatNoTriangleUsesDoNotMatter) {
  Mesh mesh = icosphere(1.0, 3);
  const BakedVolume plain = baked(mesh, singles());
  mesh.positions.emplace_back(1e30, -1e30, 5.0);
  EXPECT_EQ(baked(mesh, singles()).volume.distance, plain.volume.distance);
}

TEST(BakeVolume, SameForAnyThreadCount) {
  const Mesh mesh = withHoles(torusMesh(1.0, 0.4, 60, 30), 0.1, 2);
  std::vector<BakedVolume> volumes;
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    volumes.push_back(baked(mesh));
  }
  for (const BakedVolume& other : volumes) {
    EXPECT_EQ(other.volume.distance, volumes[0].volume.distance);
    EXPECT_EQ(other.error.rms, volumes[0].error.rms);
    EXPECT_EQ(other.error.max, volumes[0].error.max);
  }
}

TEST(BakeVolume, BadSettingsAndMeshesAreErrors) {
  const Mesh mesh = icosphere(1.0, 1);
  const auto reason = [](const Mesh& m, auto change) {
    VolumeSettings settings;
    change(settings);
    const Result<BakedVolume> result = bakeVolume(m, settings);
    return result.ok() ? std::string() : result.error().reason;
  };
  EXPECT_NE(reason(mesh, [](VolumeSettings& s) { s.resolution = 7; }), "");
  EXPECT_NE(reason(mesh, [](VolumeSettings& s) { s.resolution = 513; }), "");
  EXPECT_NE(reason(mesh, [](VolumeSettings& s) { s.padding = -1.0; }), "");
  EXPECT_NE(reason(mesh, [](VolumeSettings& s) { s.padding = 16.0; }), "");
  EXPECT_NE(reason(mesh, [](VolumeSettings& s) { s.padding = NAN; }), "");
  EXPECT_NE(reason(mesh, [](VolumeSettings& s) { s.voxelSize = 1e-4; }), "");
  EXPECT_NE(reason(mesh, [](VolumeSettings& s) { s.voxelSize = -1.0; }), "");
  EXPECT_EQ(reason(mesh, [](VolumeSettings& s) { s.voxelSize = 0.1; }), "");
  EXPECT_NE(reason(scaled(mesh, 1e5), [](VolumeSettings& s) { s.bits = VolumeBits::half; }), "");
  EXPECT_NE(reason(scaled(mesh, 1e39), [](VolumeSettings&) {}), "");
  EXPECT_NE(reason(scaled(mesh, 1e-45), [](VolumeSettings&) {}), "");
  EXPECT_NE(reason(Mesh{}, [](VolumeSettings&) {}), "");
  Mesh point;
  point.positions = {glm::dvec3(1.0)};
  point.triangles = {{0, 0, 0}};
  EXPECT_NE(reason(point, [](VolumeSettings&) {}), "");
  const Result<BakedVolume> stopped = bakeVolume(mesh, {}, [](double) { return false; });
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().reason, "interrupted");
}

RC_GTEST_PROP(BakeVolume, GridHoldsTheBoxAndItsPadding, ()) {
  VolumeSettings settings;
  settings.resolution = *rc::gen::inRange(kMinResolution, kMaxResolution + 1);
  settings.padding = *rc::gen::inRange(0, (settings.resolution - 2) / 2) / 2.0;
  Box box;
  include(box, glm::dvec3(*rc::gen::inRange(-1000, 1000), *rc::gen::inRange(-1000, 1000), *rc::gen::inRange(-1000, 1000)) * 0.37);
  include(box, glm::dvec3(*rc::gen::inRange(-1000, 1000), *rc::gen::inRange(-1000, 1000), *rc::gen::inRange(-1000, 1000)) * 0.11);
  RC_PRE(diagonal(box) > 0.0);
  const Result<Grid> made = volumeGrid(box, settings);
  RC_ASSERT(made.ok());
  const Grid& grid = made.value();
  RC_ASSERT(std::max({grid.size.x, grid.size.y, grid.size.z}) == settings.resolution);
  for (int axis = 0; axis < 3; ++axis) {
    const double margin = (settings.padding - 1e-6) * grid.voxelSize;
    RC_ASSERT(grid.origin[axis] <= box.min[axis] - margin);
    RC_ASSERT(grid.origin[axis] + grid.voxelSize * (grid.size[axis] - 1) >= box.max[axis] + margin);
  }
}

}  // namespace
}  // namespace overcast
