#include "runtime/composite_cost.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "runtime/passes/composite/composite_pass.h"
#include "runtime/vulkan/timer.h"

namespace overcast {
namespace {

constexpr double kHalf = 1.0;  ///< half the side of every asset's box, local units

/// A sphere with waves: neither flat nor symmetric.
double bumpyRadius(const glm::dvec3& direction) {
  return kHalf * (0.7 + 0.1 * std::sin(5.0 * direction.x) * std::cos(4.0 * direction.y + 3.0 * direction.z));
}

Asset volumeOf(int size, VolumeBits bits) {
  Volume volume;
  volume.size = glm::ivec3(size);
  volume.origin = glm::dvec3(-kHalf);
  volume.voxelSize = 2.0 * kHalf / (size - 1);
  for (int k = 0; k < size; ++k)
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const glm::dvec3 p = volume.origin + volume.voxelSize * glm::dvec3(i, j, k);
        const double length = glm::length(p);
        volume.distance.push_back(static_cast<float>(length - bumpyRadius(length > 0.0 ? p / length : p)));
      }
  return asStored(std::move(volume), bits);
}

Asset radiusOf(int size) {
  RadiusField field;
  for (int side = size; side >= 2; side /= 2) {
    RadiusLevel& level = field.levels.emplace_back();
    level.side = side;
    for (unsigned face = 0; face < 6; ++face)
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i)
          level.texel.push_back({static_cast<float>(bumpyRadius(glm::normalize(texelDirection(side, face, i, j)))), 1e-4f, {}});
  }
  derive(field);
  return field;
}

Asset heightFieldOf(int size, bool pair) {
  HeightField field;
  field.size = glm::ivec2(size);
  field.halfExtent = glm::dvec3(kHalf);
  const auto layer = [&](double middle) {
    std::vector<HeightTexel> texels;
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i) {
        const glm::dvec2 p = (glm::dvec2(i, j) + 0.5) / static_cast<double>(size) * 2.0 * std::numbers::pi;
        texels.push_back({static_cast<float>(middle + 0.2 * std::sin(p.x) * std::cos(p.y)), 1e-4f});
      }
    return texels;
  };
  field.front = {layer(0.5)};
  if (pair) field.back = {layer(-0.5)};
  buildLevels(field);
  return field;
}

/// One line of the table and what it is measured on.
struct Kind {
  CompositeCost cost;
  Asset asset;
  std::vector<double> times;  ///< nanoseconds of an evaluation, one per run
};

Kind kindOf(std::string variant, int size, int bits, Asset asset) {
  Kind kind;
  kind.cost.representation = representationOf(asset);
  kind.cost.variant = std::move(variant);
  kind.cost.size = size;
  kind.cost.bits = bits;
  kind.asset = std::move(asset);
  return kind;
}

std::vector<Kind> kindsOf(int largest) {
  std::vector<Kind> kinds;
  for (const PrimitiveShape shape : {PrimitiveShape::cuboid, PrimitiveShape::ellipsoid})
    kinds.push_back(kindOf(name(shape), 0, 0, Primitive{shape, glm::dvec3(0.0), {1.0, 0.0, 0.0, 0.0}, kHalf * glm::dvec3(1.0, 0.8, 0.6)}));
  for (int size = kSmallestRadiusSide; size <= std::min(largest, kLargestRadiusSide); size *= 2)
    kinds.push_back(kindOf("", size, 0, radiusOf(size)));
  for (const bool pair : {false, true})
    for (int size = kMinHeightFieldSide; size <= std::min(largest, kMaxHeightFieldSide); size *= 2)
      kinds.push_back(kindOf(pair ? "pair" : "single", size, 0, heightFieldOf(size, pair)));
  for (const VolumeBits bits : {VolumeBits::snorm8, VolumeBits::half})
    for (int size = 8; size <= largest; size *= 2) kinds.push_back(kindOf("", size, bitCount(bits), volumeOf(size, bits)));
  return kinds;
}

/// A share of one from a counter, the same everywhere.
double share(std::uint32_t n) {
  n = (n ^ 61u ^ (n >> 16)) * 9u;
  n = (n ^ (n >> 4)) * 0x27d4eb2du;
  return (n ^ (n >> 15)) / 4294967296.0;
}

/// Object n of a scene: turned, its middle near that of the volume.
glm::dmat4 placement(std::uint32_t n) {
  const std::uint32_t at = 8 * n + 1;
  const auto within = [&](std::uint32_t i) { return 2.0 * share(at + i) - 1.0; };
  const glm::dquat turn = glm::normalize(glm::dquat(within(0), within(1), within(2), within(3) + 1e-3));
  glm::dmat4 world = glm::mat4_cast(turn);
  world[3] = glm::dvec4(0.2 * within(4), 0.2 * within(5), 0.2 * within(6), 1.0);
  return world;
}

/// A global volume in which an asset's box of side 2 kHalf takes half of the room.
GlobalGrid gridOf(int voxels) {
  const double half = kHalf * std::cbrt(2.0);
  return globalGrid({glm::dvec3(-half), glm::dvec3(half)}, voxels, 0);
}

/// What composites one kind: a scene of that kind alone, whose shaders hold no other.
struct Bench {
  AssetStore store;
  CompositePass pass;
  PassTimer timer;
};

void destroyBench(const Device& device, Bench& bench) {
  destroyPassTimer(device, bench.timer);
  destroyCompositePass(device, bench.pass);
  destroyAssetStore(device, bench.store);
}

Result<Done> fillBench(const Device& device, const CostSettings& settings, const Asset& asset, Bench& bench) {
  auto store = makeAssetStore(device, std::span(&asset, 1));
  if (!store) return store.error();
  bench.store = std::move(store).value();
  const auto objects = static_cast<std::uint32_t>(settings.objects);
  auto pass = makeCompositePass(device, gridOf(settings.voxels), bench.store, objects, CompositeMethod::bruteForce);
  if (!pass) return pass.error();
  bench.pass = std::move(pass).value();
  auto timer = makePassTimer(device, {"composite"});
  if (!timer) return timer.error();
  bench.timer = std::move(timer).value();
  return Done{};
}

/// Nanoseconds of one evaluation.
Result<double> timeOnce(const Device& device, Bench& bench) {
  std::vector<shared::CompositeObject> objects;
  for (std::uint32_t n = 0; n < bench.pass.objectCapacity; ++n)
    objects.push_back(compositeObject(bench.store.entries[0], placement(n), bench.pass.grid));
  bench.pass.fresh = true;
  const Result<Done> ran = runCommands(device, [&](VkCommandBuffer commands) {
    beginTimedFrame(commands, bench.timer, 0);
    beginPass(commands, bench.timer, 0, 0);
    recordComposite(commands, bench.pass, objects);
    endPass(commands, bench.timer, 0, 0);
  });
  if (!ran) return ran.error();
  const auto times = passTimes(device, bench.timer, 0);
  if (!times) return times.error();
  const glm::dvec3 size(bench.pass.grid.size);
  return times.value()[0].milliseconds * 1e6 / (size.x * size.y * size.z * static_cast<double>(objects.size()));
}

/// Times every kind in every run, after one that warms up.
Result<Done> timeKinds(const Device& device, const CostSettings& settings, std::vector<Kind>& kinds, std::vector<Bench>& benches) {
  for (const Kind& kind : kinds)
    if (auto filled = fillBench(device, settings, kind.asset, benches.emplace_back()); !filled) return filled;
  for (int run = -1; run < settings.runs; ++run)
    for (std::size_t n = 0; n < kinds.size(); ++n) {
      const Result<double> time = timeOnce(device, benches[n]);
      if (!time) return time.error();
      if (run >= 0) kinds[n].times.push_back(time.value());
    }
  return Done{};
}

}  // namespace

Result<CompositeCosts> measureCompositeCosts(const Device& device, const CostSettings& settings) {
  OVERCAST_REQUIRE(settings.objects > 0 && settings.voxels % 8 == 0 && settings.runs > 0, "{} objects, {} voxels, {} runs",
                   settings.objects, settings.voxels, settings.runs);
  if (device.timestampBits == 0) return Error{"", device.info.name, "has no timestamps to measure by"};
  std::vector<Kind> kinds = kindsOf(settings.largest);
  std::vector<Bench> benches;
  const Result<Done> timed = timeKinds(device, settings, kinds, benches);
  for (Bench& bench : benches) destroyBench(device, bench);
  if (!timed) return timed.error();
  CompositeCosts costs{device.info.name, device.info.kind, device.info.driver, settings.objects, settings.voxels, settings.runs, {}};
  for (Kind& kind : kinds) {
    std::sort(kind.times.begin(), kind.times.end());
    kind.cost.median = kind.times[kind.times.size() / 2];
    kind.cost.least = kind.times.front();
    kind.cost.most = kind.times.back();
    costs.costs.push_back(kind.cost);
  }
  return costs;
}

}  // namespace overcast
