// The composite: singular values and records on the CPU, then the volume on the device against brute force on the device (bit for bit) and
// against brute force in double.
#include "runtime/passes/composite/composite_pass.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "tests/reference/composite.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

using test::randomTransform;
using test::sampled;
using test::sphereDistance;

struct Placement {
  std::size_t asset = 0;
  glm::dmat4 worldFromLocal{1.0};
};

GlobalGrid cubeGrid(int side, double half) {
  return globalGrid({glm::dvec3(-half), glm::dvec3(half)}, side, 0);
}

std::vector<shared::CompositeObject> records(const AssetStore& store, const std::vector<Placement>& placements, const GlobalGrid& grid) {
  std::vector<shared::CompositeObject> objects;
  for (const Placement& p : placements) objects.push_back(compositeObject(store.entries[p.asset], p.worldFromLocal, grid));
  return objects;
}

class Composite : public test::DeviceTest {
 protected:
  void SetUp() override {
    DeviceTest::SetUp();
    if (device.device) assets = test::variedAssets();
  }

  void TearDown() override {
    for (CompositePass& pass : passes) destroyCompositePass(device, pass);
    if (device.device) destroyAssetStore(device, store);
    DeviceTest::TearDown();
  }

  void load(AtlasBits bits = AtlasBits::half) {
    Result<AssetStore> made = makeAssetStore(device, assets, bits);
    ASSERT_TRUE(made.ok()) << message(made.error());
    store = std::move(made).value();
  }

  CompositePass& pass(const GlobalGrid& grid, std::uint32_t capacity, CompositeMethod method = CompositeMethod::culled) {
    Result<CompositePass> made = makeCompositePass(device, grid, store, capacity, method);
    if (!made) throw std::runtime_error(message(made.error()));
    return passes.emplace_back(std::move(made).value());
  }

  bool run(CompositePass& pass, const std::vector<Placement>& placements) {
    bool recorded = false;
    const Result<Done> done = runCommands(
        device, [&](VkCommandBuffer commands) { recorded = recordComposite(commands, pass, records(store, placements, pass.grid)); });
    EXPECT_TRUE(done.ok());
    return recorded;
  }

  std::vector<std::uint16_t> bits(const CompositePass& pass) {
    const Result<std::vector<std::byte>> bytes = readImage(device, pass.volume, kComputeWrite);
    EXPECT_TRUE(bytes.ok());
    std::vector<std::uint16_t> halves(bytes.value().size() / 2);
    std::memcpy(halves.data(), bytes.value().data(), bytes.value().size());
    return halves;
  }

  std::uint32_t activeBricks(const CompositePass& pass) {
    const Result<std::vector<std::byte>> bytes = readBuffer(device, pass.active, 0, sizeof(std::uint32_t));
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.value().data(), sizeof count);
    return count;
  }

  std::vector<Asset> assets;
  AssetStore store;
  std::vector<CompositePass> passes;
};

RC_GTEST_PROP(SingularValues, AreTheScalesOfRotatedScaling, ()) {
  const auto number = rc::gen::map(rc::gen::inRange(-1000, 1000), [](int n) { return n / 300.0; });
  glm::dvec3 scale;
  for (int axis = 0; axis < 3; ++axis) scale[axis] = std::pow(10.0, *rc::gen::inRange(-60, 60) / 10.0);
  const glm::dmat3 u(glm::mat4_cast(glm::normalize(glm::dquat(1.0, *number, *number, *number))));
  const glm::dmat3 m = u * glm::dmat3(scale.x, 0, 0, 0, -scale.y, 0, 0, 0, scale.z);
  const glm::dvec3 values = singularValues(m);
  RC_ASSERT(values.x >= values.y && values.y >= values.z);
  RC_ASSERT(std::abs(values.z / std::min({scale.x, scale.y, scale.z}) - 1.0) < 1e-9);
  RC_ASSERT(std::abs(values.x / std::max({scale.x, scale.y, scale.z}) - 1.0) < 1e-9);
}

TEST(SingularValues, AgreeWithBisectionOnGeneralMatrices) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 500; ++trial) {
    glm::dmat3 m;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) m[c][r] = static_cast<double>(random()) / 4294967296.0 - 0.5;
    const double expected = reference::smallestSingularValue(m);
    EXPECT_NEAR(singularValues(m).z, expected, 1e-7 * expected + 1e-12);
  }
  EXPECT_EQ(singularValues(glm::dmat3(0.0)), glm::dvec3(0.0));
  EXPECT_LT(singularValues(glm::dmat3(1, 2, 3, 2, 4, 6, 0, 0, 1)).z, 1e-15);
}

TEST(CompositeFormulas, BrickRadiusReachesTheOutermostVoxelCentres) {
  for (const auto& [radius, side] :
       {std::pair{shared::kBrickRadius, shared::kBrickSide}, std::pair{shared::kOctantRadius, shared::kOctantSide}}) {
    const double exact = 0.5 * (side - 1) * std::sqrt(3.0);
    EXPECT_NEAR(radius, exact, 1e-6);
    EXPECT_GE(radius, exact);
  }
}

TEST(GlobalGrid, IsCubicInMultiplesOfEightAroundTheBox) {
  for (const double scale : {1e-4, 1.0, 1e4}) {
    const GlobalGrid grid = globalGrid({glm::dvec3(1, 2, 3) * scale, glm::dvec3(5, 3, 4.5) * scale}, 128);
    EXPECT_EQ(grid.size, glm::ivec3(128, 40, 56));
    EXPECT_NEAR(grid.voxelSize, scale * 4.0 / 120.0, 1e-12 * scale);
    EXPECT_NEAR(glm::length(centre(grid) - glm::dvec3(3, 2.5, 3.75) * scale), 0.0, 1e-12 * scale);
    const glm::dvec4 corner = voxelFromWorld(grid) * glm::dvec4(glm::dvec3(5, 3, 4.5) * scale, 1.0);
    EXPECT_NEAR(corner.x, 124.0, 1e-9);
  }
  EXPECT_EQ(globalGrid({glm::dvec3(-1), glm::dvec3(1)}, 64, 0).size, glm::ivec3(64));
  EXPECT_EQ(globalGrid({}, 64).size, glm::ivec3(64));
  EXPECT_EQ(globalGrid({glm::dvec3(0), glm::dvec3(1, 0, 1)}, 64).size, glm::ivec3(64, 8, 64));
}

TEST(CompositeObject, DegenerateTransformsAreAbsent) {
  const AtlasEntry entry{{0, 0, 0}, {8, 8, 8}, glm::dvec3(-1), 2.0 / 7, 1.0f, 0.0f};
  const GlobalGrid grid = cubeGrid(32, 1.0);
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(compositeObject(entry, glm::dmat4(1.0), grid).present, 1u);
  for (const glm::dvec3& scale : {glm::dvec3(0.0), glm::dvec3(1, 0, 1), glm::dvec3(nan, 1, 1), glm::dvec3(1, inf, 1), glm::dvec3(1e-300)})
    EXPECT_EQ(compositeObject(entry, glm::scale(glm::dmat4(1.0), scale), grid).present, 0u);
  for (const double where : {nan, inf, 1e300})
    EXPECT_EQ(compositeObject(entry, glm::translate(glm::dmat4(1.0), glm::dvec3(where, 0, 0)), grid).present, 0u);
}

TEST(CompositeObject, DoesNotDependOnTheScaleOfTheScene) {
  const glm::dmat4 placed = glm::translate(glm::dmat4(1.0), glm::dvec3(0.3, -0.2, 0.1));
  for (const double scale : {1e-4, 1e4}) {
    const AtlasEntry one{{0, 0, 0}, {8, 8, 8}, glm::dvec3(-0.5), 1.0 / 7, 1.0f, 0.0f};
    AtlasEntry other = one;
    other.origin *= scale;
    other.voxelSize *= scale;
    glm::dmat4 moved = placed;
    moved[3] = glm::dvec4(glm::dvec3(placed[3]) * scale, 1.0);
    const shared::CompositeObject a = compositeObject(one, placed, cubeGrid(32, 1.0));
    const shared::CompositeObject b = compositeObject(other, moved, cubeGrid(32, scale));
    EXPECT_NEAR(glm::length(a.rowX - b.rowX), 0.0f, 1e-5f);
    EXPECT_NEAR(glm::length(a.axisScale - b.axisScale), 0.0f, 1e-5f);
  }
}

/// Plays an animation in which about a third of the objects move each frame, and some vanish and come back.
class CompositeScenes : public Composite, public ::testing::WithParamInterface<int> {};

TEST_P(CompositeScenes, CulledEqualsBruteForceBitForBit) {
  load();
  std::mt19937 random(static_cast<unsigned>(GetParam()));
  const std::size_t count = static_cast<std::size_t>(GetParam());
  const GlobalGrid grid = globalGrid({glm::dvec3(-4, -3, -4), glm::dvec3(4, 3, 3.5)}, 48);
  std::vector<Placement> placements(count);
  for (Placement& p : placements) p = {random() % assets.size(), randomTransform(random, 4.5)};
  pass(grid, static_cast<std::uint32_t>(count));
  pass(grid, static_cast<std::uint32_t>(count), CompositeMethod::bruteForce);
  for (int frame = 0; frame < 4; ++frame) {
    EXPECT_TRUE(run(passes[0], placements));
    run(passes[1], placements);
    const std::vector<std::uint16_t> culled = bits(passes[0]), brute = bits(passes[1]);
    std::size_t different = 0;
    for (std::size_t i = 0; i < culled.size(); ++i) different += culled[i] != brute[i];
    EXPECT_EQ(different, 0u) << count << " objects, frame " << frame;
    placements[random() % count].worldFromLocal = frame % 2 ? randomTransform(random, 4.5) : glm::dmat4(0.0);
    for (Placement& p : placements)
      if (random() % 3 == 0) p.worldFromLocal[3] += glm::dvec4(0.1, -0.05, 0.02, 0.0);
  }
}

INSTANTIATE_TEST_SUITE_P(Objects, CompositeScenes, ::testing::Values(1, 2, 5, 17, 60, 200));

TEST_F(Composite, ShadersHoldTheKindsThatTheSceneHolds) {
  load();
  std::uint32_t kinds = 0;
  for (const shared::CompositeObject& object :
       records(store, {{0, glm::dmat4(1.0)}, {assets.size() - 1, glm::dmat4(1.0)}}, cubeGrid(16, 1.0)))
    kinds |= 1u << object.kind;
  EXPECT_EQ(kinds, 1u << shared::kKindVolume | 1u << shared::kKindVolume8);
  EXPECT_EQ(store.kinds, 63u);
  destroyAssetStore(device, store);
  assets = {assets.back()};
  load();
  EXPECT_EQ(store.kinds, 1u << shared::kKindVolume8);
}

TEST_F(Composite, BricksWithMoreObjectsThanTheirListHoldsStayExact) {
  load();
  std::mt19937 random(11);
  const GlobalGrid grid = cubeGrid(32, 2.0);
  std::vector<Placement> placements(180);
  for (Placement& p : placements) p = {random() % assets.size(), randomTransform(random, 0.02)};
  pass(grid, 180);
  pass(grid, 180, CompositeMethod::bruteForce);
  for (int frame = 0; frame < 2; ++frame) {
    run(passes[0], placements);
    run(passes[1], placements);
    EXPECT_EQ(bits(passes[0]), bits(passes[1]));
    placements[5].worldFromLocal = randomTransform(random, 0.5);
  }
  const std::vector<std::byte> counts = readBuffer(device, passes[0].counts, 0, 64 * sizeof(std::uint32_t)).value();
  std::uint32_t overflown = 0;
  for (std::size_t brick = 0; brick < 64; ++brick) {
    std::uint32_t count = 0;
    std::memcpy(&count, counts.data() + brick * sizeof count, sizeof count);
    overflown += count == shared::kBrickOverflow;
  }
  EXPECT_GT(overflown, 0u) << "the scene no longer reaches the case it is for";
}

TEST_F(Composite, AnObjectCutOffByItsBoxReachesBeyondIt) {
  assets = {sampled([](const glm::dvec3& p) { return sphereDistance(p, 0.3); }, 16, 0.5),
            sampled([](const glm::dvec3& p) { return sphereDistance(p, 5.0); }, 8, 0.5)};
  load();
  const GlobalGrid grid = cubeGrid(64, 4.0);
  const std::vector<Placement> placements{{0, glm::translate(glm::dmat4(1.0), glm::dvec3(3, 1.5, 0))},
                                          {1, glm::translate(glm::dmat4(1.0), glm::dvec3(-3.4, 0, 0))}};
  pass(grid, 2);
  pass(grid, 2, CompositeMethod::bruteForce);
  for (CompositePass& p : passes) run(p, placements);
  EXPECT_EQ(bits(passes[0]), bits(passes[1]));
}

/// Beside widely padded volumes the distance lies far above its lower bound: objects between the two must not be culled.
TEST_F(Composite, WidelyPaddedVolumesHideNothingThatIsNearer) {
  assets = {sampled([](const glm::dvec3& p) { return sphereDistance(p, 0.05); }, 24, 3.0),
            sampled([](const glm::dvec3& p) { return sphereDistance(p, 0.3); }, 16, 0.5)};
  load();
  const GlobalGrid grid = cubeGrid(64, 4.0);
  pass(grid, 2);
  pass(grid, 2, CompositeMethod::bruteForce);
  for (const glm::dvec3& other : {glm::dvec3(2, 6, 0), glm::dvec3(7.5, 0, 0), glm::dvec3(3, -3, 6), glm::dvec3(0, 8, 2)}) {
    for (CompositePass& p : passes)
      run(p, {{0, glm::translate(glm::dmat4(1.0), glm::dvec3(-4, 0, 0))}, {1, glm::translate(glm::dmat4(1.0), other)}});
    EXPECT_EQ(bits(passes[0]), bits(passes[1])) << other.x << ' ' << other.y << ' ' << other.z;
  }
}

TEST_F(Composite, AgreesWithBruteForceInDouble) {
  for (const auto& [storage, bits8] :
       {std::pair{AtlasBits::single, false}, std::pair{AtlasBits::half, false}, std::pair{AtlasBits::single, true}}) {
    for (std::size_t n = 0; n < 4 && bits8; ++n) assets[n] = asStored(std::get<Volume>(assets[n]), VolumeBits::snorm8);
    load(storage);
    std::mt19937 random(5);
    const GlobalGrid grid = cubeGrid(32, 4.0);
    std::vector<Placement> placements(12);
    std::vector<reference::PlacedVolume> placed;
    double filtering = 0.0;
    for (Placement& p : placements) {
      p = {random() % 4, randomTransform(random, 4.0)};
      const Volume& volume = std::get<Volume>(assets[p.asset]);
      placed.push_back(reference::place(volume, p.worldFromLocal));
      filtering = std::max(filtering, 2.0 * std::sqrt(3.0) / 256.0 * placed.back().sigmaMin * volume.voxelSize / grid.voxelSize);
    }
    run(pass(grid, 12), placements);
    const std::vector<std::uint16_t> halves = bits(passes.back());
    // What may differ: one unit in the last place of the volume's half floats (some devices truncate) and, where the atlas holds halves,
    // of the atlas; filter weights of 8 bits along three axes of slope below 2; single-precision coordinates.
    const double relative = storage == AtlasBits::half ? 0x1p-9 : 0x1p-10;
    std::size_t n = 0;
    double worst = 0.0;
    for (int k = 0; k < 32; ++k)
      for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i, ++n) {
          const glm::dvec3 at = grid.origin + grid.voxelSize * (glm::dvec3(i, j, k) + 0.5);
          const double expected = reference::compositeDistance(placed, at, 1e300) / grid.voxelSize;
          const double allowed = std::abs(expected) * relative + filtering + 1e-4;
          worst = std::max(worst, std::abs(glm::unpackHalf1x16(halves[n]) - expected) / allowed);
        }
    EXPECT_LT(worst, 1.0) << "filtering allows " << filtering << " voxels";
    destroyCompositePass(device, passes.back());
    destroyAssetStore(device, store);
  }
}

/// A floor of 2 m x 2 m x 0.1 m as bake samples it by default, in a scene four times as wide.
TEST_F(Composite, TheDistanceFarFromAFloorIsTheFloors) {
  const double voxel = 2.0 / 27.0;
  const glm::dvec3 half{1.0, 0.05, 1.0};
  Volume floor;
  floor.size = {32, 7, 32};
  floor.origin = -half - 2.0 * voxel;
  floor.voxelSize = voxel;
  for (int k = 0; k < floor.size.z; ++k)
    for (int j = 0; j < floor.size.y; ++j)
      for (int i = 0; i < floor.size.x; ++i)
        floor.distance.push_back(static_cast<float>(test::boxDistance(floor.origin + voxel * glm::dvec3(i, j, k), half)));
  assets = {floor};
  load();
  const GlobalGrid grid = cubeGrid(64, 4.0);
  run(pass(grid, 1), {{0, glm::dmat4(1.0)}});
  const std::vector<std::uint16_t> halves = bits(passes.back());
  std::size_t n = 0;
  for (int k = 0; k < 64; ++k)
    for (int j = 0; j < 64; ++j)
      for (int i = 0; i < 64; ++i, ++n) {
        const glm::dvec3 at = grid.origin + grid.voxelSize * (glm::dvec3(i, j, k) + 0.5);
        const double exact = test::boxDistance(at, half), value = grid.voxelSize * static_cast<double>(glm::unpackHalf1x16(halves[n]));
        const bool above = std::max(std::abs(at.x), std::abs(at.z)) < 0.8;
        if (exact < 0.2) continue;
        ASSERT_NEAR(value, exact, (above ? 0.02 : 0.05) * exact) << at.x << ' ' << at.y << ' ' << at.z;
      }
}

/// 100 volumes of 32 x 21 x 25 samples: one image takes them all, the other is a single texel.
TEST_F(Composite, VolumesOfEightBitsTakeHalfTheMemoryOfHalves) {
  Volume volume = sampled([](const glm::dvec3& p) { return sphereDistance(p, 0.5); }, 32, 1.0);
  volume.size = {32, 21, 25};
  volume.distance.resize(32 * 21 * 25);
  const auto bytes = [](const GpuImage& image) {
    return std::size_t{image.extent.width} * image.extent.height * image.extent.depth * texelBytes(image.format);
  };
  assets.assign(100, volume);
  load();
  const std::size_t halves = bytes(store.atlas.image);
  EXPECT_EQ(bytes(store.atlas.snorm8), 1u);
  destroyAssetStore(device, store);
  assets.assign(100, asStored(volume, VolumeBits::snorm8));
  load();
  EXPECT_EQ(2 * bytes(store.atlas.snorm8), halves);
  EXPECT_EQ(bytes(store.atlas.image), 2u);
}

TEST_F(Composite, NothingIsDispatchedWhenNothingMoves) {
  load();
  std::vector<Placement> placements{{0, glm::translate(glm::dmat4(1.0), glm::dvec3(-3, 0, 0))},
                                    {1, glm::translate(glm::dmat4(1.0), glm::dvec3(3, 0, 0))},
                                    {2, glm::translate(glm::dmat4(1.0), glm::dvec3(0, 3, 0))}};
  CompositePass& p = pass(cubeGrid(64, 5.0), 3);
  EXPECT_TRUE(run(p, placements));
  EXPECT_EQ(activeBricks(p), 512u) << "everything the first time";
  EXPECT_FALSE(run(p, placements));
  placements[1].worldFromLocal[3].x += 0.1;
  EXPECT_TRUE(run(p, placements));
  EXPECT_GT(activeBricks(p), 50u);
  EXPECT_LT(activeBricks(p), 400u) << "only where the object is or was the nearest";
  EXPECT_FALSE(run(p, placements));
  placements.pop_back();
  EXPECT_TRUE(run(p, placements)) << "an object that is gone counts as moved";
}

TEST_F(Composite, AnEmptySceneIsTheFarField) {
  load();
  CompositePass& p = pass(cubeGrid(16, 1.0), 4);
  EXPECT_TRUE(run(p, {}));
  for (const std::uint16_t half : bits(p)) ASSERT_EQ(glm::unpackHalf1x16(half), shared::kFarField);
  EXPECT_TRUE(run(p, {{0, glm::dmat4(1.0)}}));
  EXPECT_LT(glm::unpackHalf1x16(bits(p)[0]), 100.0f);
  EXPECT_TRUE(run(p, {{0, glm::dmat4(0.0)}}));
  for (const std::uint16_t half : bits(p)) ASSERT_EQ(glm::unpackHalf1x16(half), shared::kFarField);
}

TEST_F(Composite, AnObjectIsExactUnderRigidAndUniformTransforms) {
  assets = {sampled([](const glm::dvec3& p) { return sphereDistance(p, 0.5); }, 48, 1.0)};
  load();
  glm::dmat4 placed = glm::translate(glm::dmat4(1.0), glm::dvec3(0.2, -0.1, 0.3));
  placed = glm::scale(glm::rotate(placed, 0.7, glm::dvec3(1, 2, 3)), glm::dvec3(2.0, -2.0, 2.0));
  const GlobalGrid grid = cubeGrid(32, 2.5);
  CompositePass& p = pass(grid, 1);
  run(p, {{0, placed}});
  const std::vector<std::uint16_t> halves = bits(p);
  std::size_t n = 0;
  for (int k = 0; k < 32; ++k)
    for (int j = 0; j < 32; ++j)
      for (int i = 0; i < 32; ++i, ++n) {
        const glm::dvec3 at = grid.origin + grid.voxelSize * (glm::dvec3(i, j, k) + 0.5);
        const double exact = (glm::length(at - glm::dvec3(0.2, -0.1, 0.3)) - 1.0) / grid.voxelSize;
        const float value = glm::unpackHalf1x16(halves[n]);
        // Trilinear interpolation of a sphere's distance errs by voxel^2 / (4 radius) at most, more only at its centre. Beyond the box the
        // sphere's closest point is that of the box's closest point, which is the true one along the axes and the diagonals only.
        if (exact < -4.0) continue;
        const glm::dvec3 local = glm::dvec3(glm::inverse(placed) * glm::dvec4(at, 1.0));
        const bool beyond = std::max({std::abs(local.x), std::abs(local.y), std::abs(local.z)}) > 1.0;
        EXPECT_NEAR(value, exact, beyond ? 0.02 * exact : 0.05);
      }
}

}  // namespace
}  // namespace overcast
