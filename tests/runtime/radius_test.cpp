// Radius fields in the composite: the shared formula as C++ against formats' own in double, then on the device, placed and mixed.
#include "runtime/passes/composite/radius.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "runtime/passes/composite/composite_pass.h"
#include "tests/formats/radius_fields.h"
#include "tests/reference/radius.h"
#include "tests/reference/shapes.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

using test::fieldOf;

GlobalGrid cubeGrid(int side, double half) {
  return globalGrid({glm::dvec3(-half), glm::dvec3(half)}, side, 0);
}

glm::dmat4 placed(const glm::dvec3& where, double scale) {
  return glm::scale(glm::rotate(glm::translate(glm::dmat4(1.0), where), 0.7, glm::normalize(glm::dvec3(1, 2, 3))), glm::dvec3(scale));
}

int levelOf(const RadiusField& field, const shared::CompositeObject& object) {
  int level = 0;
  while (field.levels[static_cast<std::size_t>(level)].side != static_cast<int>(object.field.y)) ++level;
  return level;
}

TEST(RadiusFormula, AgreesWithFormatsAtEveryLevel) {
  const GlobalGrid grid = cubeGrid(32, 4.0);
  const RadiusField fields[] = {fieldOf(reference::bumpyRadius(), 32, {1.0, -2.0, 0.5}, 0.002f),
                                fieldOf(reference::cuboidRadius({1.0, 0.3, 0.5}), 16)};
  std::vector<glm::vec2> texels(17, glm::vec2(99.0f));  // something else first
  for (const RadiusField& field : fields) {
    const RadiusEntry entry = packRadius(field, texels);
    for (const RadiusLevelEntry& level : entry.levels) {
      shared::CompositeObject object = compositeObject(entry, glm::dmat4(1.0), grid);
      ASSERT_EQ(object.present, 1u);
      object.field = {level.first, static_cast<std::uint32_t>(level.side), 0u, 0u};
      object.parameters = glm::vec4(glm::dvec4(level.smallest, kRadiusCore * level.smallest, level.largest, level.gentlest));
      double worst = 0.0;
      for (const glm::dvec3& p : reference::randomPoints(level.box, 2000, 3)) {
        const double expected = sampleRadius(field, field.centre + entry.unit * p, levelOf(field, object)) / entry.unit;
        worst = std::max(worst, std::abs(shared::radiusDistance(texels.data(), object, glm::vec3(p)) - expected));
      }
      EXPECT_LT(worst, 4e-6 * level.lipschitz);
      EXPECT_NEAR(shared::radiusDistance(texels.data(), object, glm::vec3(0.0f)), -level.smallest, 1e-6);
    }
  }
}

TEST(RadiusObject, TakesCoarserLevelsWhenItIsSmallAndNoneWhenItIsDegenerate) {
  const RadiusField field = fieldOf(reference::bumpyRadius(), 64);
  std::vector<glm::vec2> texels;
  const RadiusEntry entry = packRadius(field, texels);
  std::size_t count = 0;
  for (const RadiusLevel& level : field.levels) count += 12 * static_cast<std::size_t>(level.side * level.side);
  EXPECT_EQ(texels.size(), count);
  const GlobalGrid grid = cubeGrid(64, 4.0);
  int before = -1;
  for (const double scale : {10.0, 1.0, 0.3, 0.1, 0.01}) {
    const shared::CompositeObject object = compositeObject(entry, placed({0.1, 0.2, 0.3}, scale), grid);
    const int level = levelOf(field, object);
    EXPECT_GE(level, before);
    // A texel of the finest level is at most half a voxel wide, or no coarser one would do.
    const double texel = 0.5 * 3.141592653589793 / (static_cast<int>(object.field.y) - 1) * scale * entry.unit / grid.voxelSize;
    EXPECT_TRUE(level == 0 || texel <= 0.5) << scale;
    before = level;
  }
  EXPECT_GT(before, 3);
  EXPECT_EQ(compositeObject(entry, glm::dmat4(0.0), grid).present, 0u);
  EXPECT_EQ(compositeObject(entry, glm::scale(glm::dmat4(1.0), glm::dvec3(1, 0, 1)), grid).present, 0u);
}

class RadiusOnDevice : public test::DeviceTest {
 protected:
  void TearDown() override {
    for (CompositePass& pass : passes) destroyCompositePass(device, pass);
    if (device.device) destroyAssetStore(device, store);
    DeviceTest::TearDown();
  }

  std::vector<float> composite(const GlobalGrid& grid, const std::vector<shared::CompositeObject>& objects, CompositeMethod method) {
    Result<CompositePass> made = makeCompositePass(device, grid, store, static_cast<std::uint32_t>(objects.size()), method);
    OVERCAST_REQUIRE(made.ok(), "{}", message(made.error()));
    CompositePass& pass = passes.emplace_back(std::move(made).value());
    EXPECT_TRUE(runCommands(device, [&](VkCommandBuffer commands) { recordComposite(commands, pass, objects); }).ok());
    const std::vector<std::byte> bytes = readImage(device, pass.volume, kComputeWrite).value();
    std::vector<std::uint16_t> halves(bytes.size() / 2);
    std::memcpy(halves.data(), bytes.data(), bytes.size());
    std::vector<float> values;
    for (const std::uint16_t half : halves) values.push_back(glm::unpackHalf1x16(half));
    return values;
  }

  AssetStore store;
  std::vector<CompositePass> passes;
};

TEST_F(RadiusOnDevice, PlacedFieldsAreWhatFormatsSays) {
  const std::vector<Asset> assets{fieldOf(reference::bumpyRadius(), 32, {0.5, 0.0, 0.0}, 0.001f),
                                  fieldOf(reference::sphereRadius({0.3, 0.2, -0.1}, 0.9), 8)};
  Result<AssetStore> made = makeAssetStore(device, assets);
  ASSERT_TRUE(made.ok()) << message(made.error());
  store = std::move(made).value();
  const int n = 40;
  const GlobalGrid grid = cubeGrid(n, 3.0);
  for (std::size_t a = 0; a < assets.size(); ++a) {
    const glm::dmat4 worldFromLocal = placed({0.2, -0.3, 0.1}, a == 0 ? 1.3 : 0.4);
    const double scale = glm::length(glm::dvec3(worldFromLocal[0]));
    const shared::CompositeObject object = compositeObject(store.entries[a], worldFromLocal, grid);
    const RadiusField& field = std::get<RadiusField>(assets[a]);
    const std::vector<float> values = composite(grid, {object}, CompositeMethod::culled);
    const glm::dmat4 localFromWorld = glm::inverse(worldFromLocal);
    double worst = 0.0;
    std::size_t at = 0;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i, ++at) {
          const glm::dvec3 p = grid.origin + grid.voxelSize * (glm::dvec3(i, j, k) + 0.5);
          const double expected =
              sampleRadius(field, glm::dvec3(localFromWorld * glm::dvec4(p, 1.0)), levelOf(field, object)) * scale / grid.voxelSize;
          // One unit in the last place of a half float, and single-precision coordinates.
          worst = std::max(worst, std::abs(double{values[at]} - expected) / (std::abs(expected) * 0x1p-10 + 2e-4));
        }
    EXPECT_LT(worst, 1.0) << "asset " << a;
  }
}

TEST_F(RadiusOnDevice, CulledEqualsBruteForceForSteepFields) {
  // Long bodies, sharp edges and a centre near the surface: the steepest gradients there are.
  const std::vector<Asset> assets{fieldOf(reference::cuboidRadius({1.5, 0.2, 0.3}), 16),
                                  fieldOf(reference::sphereRadius({0.8, 0.0, 0.0}, 1.0), 32),
                                  fieldOf(reference::ellipsoidRadius({0.2, 1.0, 1.0}), 8, glm::dvec3(0.0), 0.01f),
                                  Primitive{PrimitiveShape::cuboid, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}, {0.6, 0.1, 0.4}}};
  Result<AssetStore> made = makeAssetStore(device, assets);
  ASSERT_TRUE(made.ok()) << message(made.error());
  store = std::move(made).value();
  const GlobalGrid grid = cubeGrid(48, 4.0);
  std::vector<shared::CompositeObject> objects;
  const std::vector<glm::dvec3> places = reference::randomPoints({glm::dvec3(-4.0), glm::dvec3(4.0)}, 60, 17);
  for (std::size_t i = 0; i < places.size(); ++i)
    objects.push_back(compositeObject(store.entries[i % 4], placed(places[i], 0.3 + 0.02 * static_cast<double>(i)), grid));
  const std::vector<float> culled = composite(grid, objects, CompositeMethod::culled);
  const std::vector<float> brute = composite(grid, objects, CompositeMethod::bruteForce);
  EXPECT_EQ(culled, brute);
}

}  // namespace
}  // namespace overcast
