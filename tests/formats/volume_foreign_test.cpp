// .vdb files that other programs would write, made with OpenVDB itself; and ours, looked at through its eyes.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include "formats/volume.h"
#include "tests/formats/support.h"

namespace overcast {
namespace {

using openvdb::Coord;
using openvdb::FloatGrid;

class ForeignVolume : public testing::Test {
 protected:
  ForeignVolume() { openvdb::initialize(); }

  Result<Volume> read(const openvdb::GridPtrVec& grids, std::uint32_t compression = openvdb::io::COMPRESS_ZIP) const {
    const auto path = folder / "foreign.vdb";
    openvdb::io::File file(path.string());
    file.setCompression(compression);
    file.write(grids);
    return readVolume(path);
  }

  void expectError(const openvdb::GridPtrVec& grids, const char* part) const {
    const auto volume = read(grids);
    ASSERT_FALSE(volume) << "expected: " << part;
    EXPECT_NE(message(volume.error()).find("foreign.vdb: "), std::string::npos);
    EXPECT_NE(message(volume.error()).find(part), std::string::npos) << message(volume.error());
  }

  /// 3 x 4 x 5 values i + 10 j + 100 k from index (-2, 7, 100) on.
  static FloatGrid::Ptr ramp() {
    auto grid = FloatGrid::create(9.0f);
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 3; ++i) grid->tree().setValueOn(Coord(i - 2, j + 7, k + 100), static_cast<float>(i + 10 * j + 100 * k));
    grid->setName("distance");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    return grid;
  }

  TemporaryFolder folder;
};

TEST_F(ForeignVolume, isReadOverItsActiveBox) {
  for (const std::uint32_t compression : {0u, 1u, 2u, 3u, 4u, 6u})
    for (const bool half : {false, true}) {
      const auto grid = ramp();
      grid->setSaveFloatAsHalf(half);
      const auto volume = read({grid}, compression);
      ASSERT_TRUE(volume) << message(volume.error());
      EXPECT_EQ(volume.value().size, glm::ivec3(3, 4, 5));
      EXPECT_EQ(volume.value().origin, glm::dvec3(-1.0, 3.5, 50.0));
      EXPECT_EQ(volume.value().voxelSize, 0.5);
      EXPECT_EQ(volume.value().signMethod, "");
      EXPECT_EQ(volume.value().distance[sampleIndex(volume.value(), 2, 3, 4)], 432.0f);
    }
}

TEST_F(ForeignVolume, narrowBandsComeWithTheirBackground) {
  const auto sphere = openvdb::tools::createLevelSetSphere<FloatGrid>(2.0f, openvdb::Vec3f(0.0f), 0.1f, 3.0f);
  sphere->setName("distance");
  const auto volume = read({sphere}, openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
  ASSERT_TRUE(volume) << message(volume.error());
  EXPECT_NEAR(sampleVolume(volume.value(), {1.9, 0.0, 0.0}), -0.1, 0.01);
  EXPECT_NEAR(sampleVolume(volume.value(), {0.0, 0.0, 0.0}), -0.3, 1e-6);  // the band is 0.3 wide
}

TEST_F(ForeignVolume, isFoundAmongOthers) {
  const auto density = FloatGrid::create(1.0f);
  density->setName("density");
  const auto ids = openvdb::Int32Grid::create(3);
  ids->setName("ids");
  const auto volume = read({density, ids, ramp()});
  ASSERT_TRUE(volume) << message(volume.error());
  EXPECT_EQ(volume.value().size, glm::ivec3(3, 4, 5));
  expectError({density, ids}, "has no grid named 'distance'");
}

TEST_F(ForeignVolume, otherTypesAreErrors) {
  const auto whole = openvdb::Int32Grid::create(3);
  whole->setName("distance");
  expectError({whole}, "not float");
  const auto doubles = openvdb::DoubleGrid::create(3.0);
  doubles->setName("distance");
  expectError({doubles}, "not float");
}

TEST_F(ForeignVolume, otherTransformsAreErrors) {
  const auto with = [](const openvdb::math::Mat4d& matrix) {
    auto grid = ramp();
    grid->setTransform(openvdb::math::Transform::createLinearTransform(matrix));
    return grid;
  };
  using openvdb::math::Mat4d;
  expectError({with(Mat4d(0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1))}, "not positive");  // a quarter turn
  expectError({with(Mat4d(1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1))}, "not a uniform scale");
  expectError({with(Mat4d(1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1))}, "not a uniform scale");
  expectError({with(Mat4d(-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1))}, "not positive");
  const auto frustum = ramp();
  frustum->setTransform(openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(8)), 0.5, 1.0));
  expectError({frustum}, "not a uniform scale");
}

TEST_F(ForeignVolume, hugeAndEmptyBoxesAreErrors) {
  const auto wide = ramp();
  wide->tree().setValueOn(Coord(5000, 8, 101), 1.0f);
  expectError({wide}, "samples along an axis");
  const auto whole = FloatGrid::create(0.0f);
  whole->setName("distance");
  expectError({whole}, "no active voxels");
  whole->tree().root().addTile(Coord(0), 1.0f, true);  // 4096 samples along each axis in a few bytes
  expectError({whole}, "samples along an axis");
  const auto furthest = FloatGrid::create(0.0f);
  furthest->setName("distance");
  furthest->tree().setValueOn(Coord::min(), 1.0f);
  furthest->tree().setValueOn(Coord::max(), 1.0f);
  expectError({furthest}, "samples along an axis");
  const auto flat = FloatGrid::create(0.0f);
  flat->setName("distance");
  flat->tree().setValueOn(Coord(0), 1.0f);
  expectError({flat}, "samples along an axis");
}

TEST_F(ForeignVolume, valuesThatAreNotFiniteAreErrors) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const auto grid = ramp();
    grid->tree().setValueOn(Coord(0, 8, 102), bad);
    expectError({grid}, "not finite");
  }
}

TEST_F(ForeignVolume, laterVersionsAndWrongSizesAreErrors) {
  auto grid = ramp();
  grid->insertMeta("overcast_version", openvdb::Int32Metadata(kVolumeVersion + 1));
  expectError({grid}, "overcast_version");
  grid = ramp();
  grid->insertMeta("overcast_size", openvdb::Vec3IMetadata(openvdb::Vec3i(3, 4, 6)));
  expectError({grid}, "overcast_size");
}

TEST_F(ForeignVolume, stepsThatDistancesDoNotKeepAreErrors) {
  const auto with = [](float step) {
    auto grid = ramp();
    grid->insertMeta("overcast_step", openvdb::FloatMetadata(step));
    return grid;
  };
  expectError({with(-1.0f)}, "overcast_step");
  expectError({with(1.0f)}, "overcast_step");  // 432 steps
  expectError({with(7.0f)}, "overcast_step");
  const auto read8 = read({with(4.0f)});
  EXPECT_FALSE(read8) << "1 is no multiple of 4";
}

TEST_F(ForeignVolume, openVdbReadsOursOfEightBits) {
  Volume volume;
  volume.size = {11, 9, 10};
  volume.voxelSize = 0.5;
  for (int n = 0; n < 990; ++n) volume.distance.push_back(0.013f * static_cast<float>(n - 300));
  ASSERT_TRUE(writeVolume(folder / "eight.vdb", volume, VolumeBits::snorm8));
  openvdb::io::File file((folder / "eight.vdb").string());
  file.open();
  const auto grid = openvdb::gridPtrCast<FloatGrid>(file.readGrid("distance"));
  ASSERT_TRUE(grid);
  const float step = grid->metaValue<float>("overcast_step");
  EXPECT_NEAR(step, 0.013f * 689.0f / 127.0f, 0.125f * step);
  for (int n = 0; n < 990; ++n)
    EXPECT_NEAR(grid->tree().getValue(Coord(n % 11, n / 11 % 9, n / 99)), volume.distance[static_cast<std::size_t>(n)], 0.5001f * step);
}

TEST_F(ForeignVolume, openVdbReadsOurs) {
  Volume volume;
  volume.size = {9, 10, 3};
  volume.origin = {0.1, -0.2, 1e4};
  volume.voxelSize = 0.37;
  volume.signMethod = "winding-number";
  for (int n = 0; n < 270; ++n) volume.distance.push_back(0.25f * static_cast<float>(n - 100));
  ASSERT_TRUE(writeVolume(folder / "ours.vdb", volume));
  openvdb::io::File file((folder / "ours.vdb").string());
  file.open();
  EXPECT_EQ(file.getGrids()->size(), 1u);
  const auto grid = openvdb::gridPtrCast<FloatGrid>(file.readGrid("distance"));
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_TRUE(grid->saveFloatAsHalf());
  EXPECT_EQ(grid->activeVoxelCount(), 270u);
  EXPECT_GT(grid->background(), 0.0f);
  EXPECT_EQ(grid->indexToWorld(openvdb::Vec3d(0.0)), openvdb::Vec3d(0.1, -0.2, 1e4));
  EXPECT_EQ(grid->voxelSize(), openvdb::Vec3d(0.37));
  EXPECT_EQ(grid->tree().getValue(Coord(8, 9, 2)), 0.25f * 169.0f);
  EXPECT_EQ(grid->metaValue<std::int32_t>("overcast_version"), kVolumeVersion);
  EXPECT_EQ(grid->metaValue<std::string>("overcast_sign_method"), "winding-number");
  EXPECT_EQ(grid->metaValue<openvdb::Vec3i>("overcast_size"), openvdb::Vec3i(9, 10, 3));
}

}  // namespace
}  // namespace overcast
