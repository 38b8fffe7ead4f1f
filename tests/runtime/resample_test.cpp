// Resampled occluders: against distances in closed form, against the fields they are made of, and through the composite in double.
#include "runtime/resample.h"

#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/matrix.hpp>

#include "runtime/passes/composite/composite_pass.h"
#include "runtime/passes/composite/heightfield_object.h"
#include "runtime/passes/composite/radius_object.h"
#include "tests/reference/radius.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
}

glm::dvec3 pointWithin(std::mt19937& random, double reach) {
  return {uniform(random, -reach, reach), uniform(random, -reach, reach), uniform(random, -reach, reach)};
}

double sample(const Resampled& made, const glm::dvec3& p) {
  return sampleVolume(made.volume, glm::transpose(made.localFromVolume) * p);
}

/// The asset's distance at the level that suits the scene.
double distanceOf(const Asset& asset, const glm::dvec3& p, double voxel) {
  if (const auto* field = std::get_if<HeightField>(&asset)) return sampleHeightField(*field, p, heightFieldLevel(*field, voxel));
  if (const auto* field = std::get_if<RadiusField>(&asset)) return sampleRadius(*field, p, radiusLevel(*field, voxel));
  return sampleAsset(asset, p);
}

/// What is left between `made` and `truth`, in global voxels: near the surface as it is, from 4 voxels on as a share of the distance.
struct Off {
  double nearRms = 0.0, nearMost = 0.0, farRms = 0.0, farMost = 0.0;
};

template <class Truth>
Off compare(const Resampled& made, const Truth& truth, double voxel, double reach) {
  Off off;
  std::mt19937 random(11);
  int near = 0, far = 0;
  for (int n = 0; n < 20000; ++n) {
    const glm::dvec3 p = pointWithin(random, reach * (n % 2 ? 1.0 : 3.0));
    const double expected = truth(p) / voxel, difference = std::abs(sample(made, p) / voxel - expected);
    if (expected < -1.0) continue;  // deep inside nothing reads it
    const double share = difference / expected;
    if (expected < 4.0) {
      off.nearRms += difference * difference;
      off.nearMost = std::max(off.nearMost, difference);
      ++near;
    } else {
      off.farRms += share * share;
      off.farMost = std::max(off.farMost, share);
      ++far;
    }
  }
  off.nearRms = std::sqrt(off.nearRms / near);
  off.farRms = std::sqrt(off.farRms / far);
  return off;
}

RadiusField radiusField(const reference::RadiusFunction& radius, int side, double scale = 1.0) {
  RadiusField field;
  for (; side >= 2; side /= 2) {
    RadiusLevel& level = field.levels.emplace_back();
    level.side = side;
    for (unsigned face = 0; face < 6; ++face)
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i)
          level.texel.push_back({static_cast<float>(scale * radius(glm::normalize(texelDirection(side, face, i, j)))), 0.0f, {}});
  }
  derive(field);
  return field;
}

/// A plane over a rectangle, turned in space: heights rise by `slope` along x.
HeightField tilted(double slope, double scale) {
  HeightField field;
  field.size = {32, 16};
  field.halfExtent = scale * glm::dvec3(1.0, 0.5, std::max(slope, 0.05));
  field.origin = scale * glm::dvec3(0.2, -0.1, 0.3);
  field.localFromField = glm::mat3_cast(glm::normalize(glm::dquat(0.8, 0.3, -0.2, 0.4)));
  const double rise = slope * scale / field.halfExtent.z, cell = 2.0 / 32.0;
  std::vector<HeightTexel> texels;
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 32; ++i)
      texels.push_back({static_cast<float>(rise * ((i + 0.5) * cell - 1.0)), static_cast<float>(rise * rise * cell * cell / 12.0)});
  field.front = {texels};
  buildLevels(field);
  return field;
}

/// Distance to that parallelogram, which is a rectangle.
double tiltedDistance(const HeightField& field, double slope, const glm::dvec3& p) {
  const glm::dvec3 q = glm::transpose(field.localFromField) * (p - field.origin);
  const glm::dvec3 along = glm::normalize(glm::dvec3(1.0, 0.0, slope)), across(0.0, 1.0, 0.0);
  const double length = field.halfExtent.x * std::hypot(1.0, slope);
  const double a = glm::clamp(glm::dot(q, along), -length, length), b = glm::clamp(q.y, -field.halfExtent.y, field.halfExtent.y);
  return glm::length(q - a * along - b * across);
}

TEST(Resample, BallsAreBallsAtAnyScale) {
  const glm::dvec3 middle(0.15, -0.1, 0.2);
  for (const double scale : {1e-4, 1.0, 1e4})
    for (const double voxels : {5.0, 24.0}) {
      const RadiusField field = radiusField(reference::sphereRadius(middle, 0.8), 64, scale);
      const double voxel = 1.6 * scale / voxels;
      const auto made = resampled(field, voxel);
      ASSERT_TRUE(made.has_value());
      const Off off = compare(
          *made, [&](const glm::dvec3& p) { return glm::length(p - scale * middle) - 0.8 * scale; }, voxel, scale);
      EXPECT_LT(off.nearRms, 0.02) << scale << ' ' << voxels;
      EXPECT_LT(off.nearMost, 0.1) << scale << ' ' << voxels;
      EXPECT_LT(off.farRms, 0.02) << scale << ' ' << voxels;
      EXPECT_LT(off.farMost, 0.06) << scale << ' ' << voxels;
    }
}

/// At an edge of a quarter of a voxel, half of it; beyond the box its corners, empty where a sheet is tilted, count as its closest point.
TEST(Resample, ThinSheetsAreOffByAnEighthOfAVoxelAtMost) {
  for (const double scale : {1e-4, 1.0, 1e4})
    for (const double slope : {0.0, 0.3, 1.2})
      for (const double voxels : {8.0, 30.0}) {
        const HeightField field = tilted(slope, scale);
        const double voxel = 2.0 * scale / voxels;
        const auto made = resampled(field, voxel);
        ASSERT_TRUE(made.has_value());
        const Off off = compare(
            *made, [&](const glm::dvec3& p) { return tiltedDistance(field, slope, p); }, voxel, 1.2 * scale);
        EXPECT_LT(off.nearRms, 0.03) << scale << ' ' << slope << ' ' << voxels;
        EXPECT_LT(off.nearMost, 0.13) << scale << ' ' << slope << ' ' << voxels;
        EXPECT_LT(off.farRms, 0.04) << scale << ' ' << slope << ' ' << voxels;
        EXPECT_LT(off.farMost, 0.15) << scale << ' ' << slope << ' ' << voxels;
      }
}

/// Rough and steep fields too: within the padded box the volume is the field, give or take what its slope does within a sample.
TEST(Resample, IsTheFieldWithinItsBox) {
  for (const Asset& asset : test::variedAssets()) {
    constexpr double kVoxel = 0.1;
    const auto made = resampled(asset, kVoxel);
    if (!made) continue;
    const double slope = lipschitzBound(made->volume), spacing = made->volume.voxelSize;
    const Box box = bounds(made->volume);
    std::mt19937 random(3);
    double squares = 0.0;
    int points = 0;
    for (int n = 0; n < 5000; ++n) {
      const glm::dvec3 p = pointWithin(random, 1.3), own = glm::transpose(made->localFromVolume) * p;
      if (own != glm::clamp(own, box.min, box.max)) continue;
      const double off = (sample(*made, p) - distanceOf(asset, p, kVoxel)) / kVoxel;
      ASSERT_LE(std::abs(off) * kVoxel, 2.0 * slope * spacing) << name(representationOf(asset));
      squares += off * off;
      ++points;
    }
    EXPECT_GT(points, 500);
    EXPECT_LT(std::sqrt(squares / points), 0.05) << name(representationOf(asset)) << ", voxels";
  }
}

TEST(Resample, LeavesAloneWhatItCannotMakeOrNeedNot) {
  const RadiusField field = radiusField(reference::bumpyRadius(), 16);
  EXPECT_TRUE(resampled(field, 0.1).has_value());
  for (const double voxel : {0.0, -1.0, std::nan(""), 1e-6}) EXPECT_FALSE(resampled(field, voxel).has_value());
  EXPECT_FALSE(resampled(field, 0.1, 1000).has_value());
  EXPECT_FALSE(resampled(field, 0.1, kMostResamples, 20).has_value());
  EXPECT_FALSE(resampled(Primitive{}, 0.1).has_value());
  EXPECT_FALSE(resampled(test::variedVolumes()[0], 0.1).has_value());
}

TEST(Resample, TheSmallestComeFirstAndTheRestStays) {
  const RadiusField field = radiusField(reference::bumpyRadius(), 8);
  const std::uint64_t each = resampled(field, 0.2)->volume.distance.size(), small = resampled(field, 1.0)->volume.distance.size();
  ASSERT_LT(small, each);
  const std::vector<Asset> assets(5, Asset(field));
  const std::vector<double> voxels{0.2, 0.2, 0.2, 0.2, 1.0};
  for (const std::uint64_t room : {small, small + each, small + 2 * each - 1, small + 4 * each}) {
    const auto all = resampledAll(assets, voxels, kMaxVolumeSide, room);
    std::size_t made = 0;
    for (const auto& one : all) made += one.has_value();
    EXPECT_TRUE(all[4].has_value());
    EXPECT_EQ(made, 1 + (room - small) / each);
  }
}

TEST(Resample, LargeAssetsHaveFewerSamplesToAVoxel) {
  const RadiusField field = radiusField(reference::sphereRadius(glm::dvec3(0.0), 1.0), 16);
  for (const auto& [voxel, density] : {std::pair{0.2, 4.0}, std::pair{0.12, 4.0}, std::pair{0.09, 3.0}, std::pair{0.05, 2.0}}) {
    const auto made = resampled(field, voxel);
    EXPECT_DOUBLE_EQ(voxel / made->volume.voxelSize, density);
    EXPECT_TRUE(density == 2.0 || made->volume.distance.size() <= kFineResamples);
  }
}

TEST(Resample, DoesNotDependOnTheNumberOfThreads) {
  const HeightField field = test::bumps({32, 16}, true);
  const auto many = resampled(field, 0.05);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(resampled(field, 0.05)->volume.distance, many->volume.distance);
}

/// One object of a random scene: an asset, its uniform scale and where it is.
struct Placed {
  std::size_t asset = 0;
  double scale = 1.0;
  glm::dmat4 worldFromLocal{1.0};
};

class ResampledScenes : public test::DeviceTest, public ::testing::WithParamInterface<int> {
 protected:
  /// Assets of all kinds that are smooth enough for a truth: no noise.
  static std::vector<Asset> smoothAssets() {
    std::vector<Asset> assets = test::variedAssets();
    assets.erase(assets.begin() + 4);
    assets.push_back(tilted(0.7, 1.0));
    assets.push_back(radiusField(reference::ellipsoidRadius({0.9, 0.6, 0.5}), 32));
    return assets;
  }

  std::vector<std::uint16_t> composite(const AssetStore& store, const std::vector<Placed>& scene, const GlobalGrid& grid,
                                       CompositeMethod method) {
    CompositePass pass = makeCompositePass(device, grid, store, static_cast<std::uint32_t>(scene.size()), method).value();
    std::vector<shared::CompositeObject> objects;
    for (const Placed& placed : scene) objects.push_back(compositeObject(store.entries[placed.asset], placed.worldFromLocal, grid));
    EXPECT_TRUE(runCommands(device, [&](VkCommandBuffer commands) { recordComposite(commands, pass, objects); }).ok());
    const std::vector<std::byte> bytes = readImage(device, pass.volume, kComputeWrite).value();
    std::vector<std::uint16_t> halves(bytes.size() / 2);
    std::memcpy(halves.data(), bytes.data(), bytes.size());
    destroyCompositePass(device, pass);
    return halves;
  }
};

TEST_P(ResampledScenes, AgreeWithBruteForceInDouble) {
  const int count = GetParam();
  std::mt19937 random(static_cast<unsigned>(count));
  const std::vector<Asset> assets = smoothAssets();
  const double world = std::pow(10.0, uniform(random, -4.0, 4.0));
  const GlobalGrid grid = globalGrid({-4.0 * world * glm::dvec3(1.0), 4.0 * world * glm::dvec3(1.0, 0.6, 0.8)}, 48);
  std::vector<Placed> scene;
  std::vector<double> voxels(assets.size(), 0.0), largest(assets.size(), 0.0);
  for (int n = 0; n < count; ++n) {
    Placed placed{random() % assets.size(), world * uniform(random, 0.4, 1.6)};
    largest[placed.asset] = std::max(largest[placed.asset], placed.scale);
    const glm::dvec3 axis = pointWithin(random, 1.0);
    placed.worldFromLocal =
        glm::scale(glm::rotate(glm::translate(glm::dmat4(1.0), pointWithin(random, 4.0 * world)), uniform(random, 0.0, 6.0), axis),
                   glm::dvec3(placed.scale));
    scene.push_back(placed);
  }
  for (std::size_t i = 0; i < assets.size(); ++i) voxels[i] = largest[i] > 0.0 ? grid.voxelSize / largest[i] : 0.0;
  AssetStore store = makeAssetStore(device, assets, AtlasBits::half, voxels).value();
  const std::vector<std::uint16_t> culled = composite(store, scene, grid, CompositeMethod::culled);
  EXPECT_EQ(culled, composite(store, scene, grid, CompositeMethod::bruteForce));
  std::vector<glm::dmat4> localFromWorld;
  for (const Placed& placed : scene) localFromWorld.push_back(glm::inverse(placed.worldFromLocal));
  double near = 0.0, nearMost = 0.0, far = 0.0;
  std::size_t at = 0, nears = 0, fars = 0;
  for (int k = 0; k < grid.size.z; ++k)
    for (int j = 0; j < grid.size.y; ++j)
      for (int i = 0; i < grid.size.x; ++i, ++at) {
        if (random() % 32 != 0) continue;
        const glm::dvec4 p(grid.origin + grid.voxelSize * (glm::dvec3(i, j, k) + 0.5), 1.0);
        double expected = 1e300;
        for (std::size_t n = 0; n < scene.size(); ++n)
          expected = std::min(expected, scene[n].scale * distanceOf(assets[scene[n].asset], glm::dvec3(localFromWorld[n] * p),
                                                                    grid.voxelSize / scene[n].scale));
        expected /= grid.voxelSize;
        const double off = static_cast<double>(glm::unpackHalf1x16(culled[at])) - expected;
        if (expected < -2.0) continue;
        if (expected < 4.0) {
          near += off * off;
          nearMost = std::max(nearMost, std::abs(off));
          ++nears;
        } else {
          far += off * off / (expected * expected);
          ++fars;
        }
      }
  EXPECT_LT(std::sqrt(near / static_cast<double>(std::max<std::size_t>(nears, 1))), 0.08) << world << ' ' << nears;
  EXPECT_LT(nearMost, 1.0) << world;
  EXPECT_LT(std::sqrt(far / static_cast<double>(std::max<std::size_t>(fars, 1))), 0.06) << world << ' ' << fars;
  destroyAssetStore(device, store);
}

INSTANTIATE_TEST_SUITE_P(Objects, ResampledScenes, ::testing::Values(1, 3, 12, 50, 300));

TEST_F(ResampledScenes, ShadersHoldNoSearchWhereAllIsResampled) {
  const std::vector<Asset> assets = smoothAssets();
  AssetStore store = makeAssetStore(device, assets, AtlasBits::half, std::vector<double>(assets.size(), 0.2)).value();
  const std::uint32_t searches = 1u << shared::kKindRadius | 1u << shared::kKindHeightField;
  EXPECT_EQ(store.kinds & searches, 0u);
  EXPECT_NE(store.kinds & 1u << shared::kKindVolume, 0u);
  destroyAssetStore(device, store);
  store = makeAssetStore(device, assets).value();
  EXPECT_EQ(store.kinds & searches, searches);
  destroyAssetStore(device, store);
}

}  // namespace
}  // namespace overcast
