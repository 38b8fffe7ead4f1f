// Heightfields: the formula as C++ against formats and against the reference, then through the device.
#include "runtime/passes/composite/heightfield.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "runtime/passes/composite/composite_pass.h"
#include "tests/reference/heightfield.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

using test::bumps;

/// The distance in global voxels as the shader computes it.
float shaderDistance(const std::vector<glm::vec2>& texels, const shared::CompositeObject& object, const glm::vec3& p) {
  const glm::vec3 local = shared::localPoint(object, p), closest = shared::closestInBox(object, local);
  if (shared::isSearched(object)) {
    const float distance = shared::sheetDistance(texels.data(), object, local) * object.axisScale.w;
    return std::max(distance, shared::gapBeyondBox(object, local, closest));
  }
  const float phi = shared::heightFieldDistance(texels.data(), object, closest) * object.axisScale.w;
  const float gap = shared::gapBeyondBox(object, local, closest);
  if (!(gap > 0.0f && phi > 0.0f)) return shared::extendedDistance(phi, gap, 0.0f);
  const glm::vec3 direction = shared::outwardStep(local, closest);
  const float inner = shared::heightFieldDistance(texels.data(), object, closest - direction) * object.axisScale.w;
  return shared::extendedDistance(phi, gap, shared::slopeAlong(object, direction, inner, phi));
}

/// Rotation, uniform scale 1.5, translation.
glm::dmat4 placement() {
  const glm::dmat4 moved = glm::translate(glm::dmat4(1.0), glm::dvec3(0.3, -0.2, 0.1));
  return glm::scale(glm::rotate(moved, 0.8, glm::dvec3(1, -2, 3)), glm::dvec3(1.5));
}

glm::dvec3 voxelCentre(const GlobalGrid& grid, int i, int j, int k) {
  return grid.origin + grid.voxelSize * (glm::dvec3(i, j, k) + 0.5);
}

TEST(HeightFieldFormula, IsTheReference) {
  for (const bool pair : {false, true}) {
    const HeightField field = bumps({32, 16}, pair);
    const GlobalGrid grid = globalGrid({glm::dvec3(-2.0), glm::dvec3(2.0)}, 256, 0);
    std::vector<glm::vec2> texels(7, glm::vec2(9e9f));  // something before it
    const HeightFieldEntry entry = addHeightField(field, texels);
    ASSERT_EQ(entry.levels.size(), 2u);
    const shared::CompositeObject object = compositeObject(entry, placement(), grid);
    ASSERT_EQ(object.present, 1u);
    const glm::dmat4 localFromWorld = glm::inverse(placement());
    double worst = 0.0;
    for (int k = 0; k < 256; k += 17)
      for (int j = 0; j < 256; j += 13)
        for (int i = 0; i < 256; i += 11) {
          const glm::dvec3 world = voxelCentre(grid, i, j, k);
          const double expected =
              1.5 / grid.voxelSize * reference::heightFieldDistance(field, glm::dvec3(localFromWorld * glm::dvec4(world, 1.0)));
          const float value = shaderDistance(texels, object, glm::vec3((world - centre(grid)) / grid.voxelSize));
          worst = std::max(worst, std::abs(double{value} - expected));
        }
    EXPECT_LT(worst, 1e-3) << "voxels";
    EXPECT_LE(2.0 * worst, double{object.slack} + 1e-4);
  }
}

TEST(HeightFieldFormula, CoarseVolumesReadCoarseLevels) {
  const HeightField field = bumps({64, 32}, false);
  std::vector<glm::vec2> texels;
  const HeightFieldEntry entry = addHeightField(field, texels);
  ASSERT_EQ(entry.levels.size(), 3u);
  EXPECT_EQ(texels.size(), 66u * 34 + 34 * 18 + 18 * 10 + 10 * 6 + 6 * 4);
  EXPECT_EQ(heightFieldLevel(entry, 4.0), 0u);
  EXPECT_EQ(heightFieldLevel(entry, 0.51), 0u);
  EXPECT_EQ(heightFieldLevel(entry, 0.5), 1u);
  EXPECT_EQ(heightFieldLevel(entry, 0.1), 2u);
  const GlobalGrid grid = globalGrid({glm::dvec3(-2.0), glm::dvec3(2.0)}, 32, 0);
  const shared::CompositeObject object = compositeObject(entry, glm::dmat4(1.0), grid);
  EXPECT_EQ(object.field.z, 16u);
  for (int n = 0; n < 32; ++n) {
    const glm::dvec3 world = voxelCentre(grid, n, 31 - n, (n * 7) % 32);
    const double expected = sampleHeightField(field, world, 2) / grid.voxelSize;
    EXPECT_NEAR(shaderDistance(texels, object, glm::vec3((world - centre(grid)) / grid.voxelSize)), expected, 1e-3);
  }
}

class HeightFieldOnDevice : public test::DeviceTest {};

TEST_F(HeightFieldOnDevice, IsWhatFormatsSamples) {
  for (const bool pair : {false, true}) {
    const HeightField field = bumps({32, 16}, pair);
    const std::vector<Asset> assets{field};
    AssetStore store = makeAssetStore(device, assets).value();
    const GlobalGrid grid = globalGrid({glm::dvec3(-2.0), glm::dvec3(2.0)}, 64, 0);
    CompositePass pass = makeCompositePass(device, grid, store, 1).value();
    const shared::CompositeObject object = compositeObject(store.entries[0], placement(), grid);
    const int level = object.field.z == 32u ? 0 : 1;
    ASSERT_TRUE(runCommands(device, [&](VkCommandBuffer commands) { recordComposite(commands, pass, std::span(&object, 1)); }).ok());
    const std::vector<std::byte> bytes = readImage(device, pass.volume, kComputeWrite).value();
    const glm::dmat4 localFromWorld = glm::inverse(placement());
    std::size_t n = 0;
    double worst = 0.0;
    for (int k = 0; k < 64; ++k)
      for (int j = 0; j < 64; ++j)
        for (int i = 0; i < 64; ++i, ++n) {
          std::uint16_t half = 0;
          std::memcpy(&half, bytes.data() + n * sizeof half, sizeof half);
          const glm::dvec3 local(localFromWorld * glm::dvec4(voxelCentre(grid, i, j, k), 1.0));
          const double expected = 1.5 / grid.voxelSize * sampleHeightField(field, local, level);
          // One step of half floats, and what single floats lose.
          worst = std::max(worst, std::abs(double{glm::unpackHalf1x16(half)} - expected) / (0x1p-10 * std::abs(expected) + 1e-3));
        }
    EXPECT_LT(worst, 1.0);
    destroyCompositePass(device, pass);
    destroyAssetStore(device, store);
  }
}

}  // namespace
}  // namespace overcast
