#include "runtime/passes/shade/sky_points_pass.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "runtime/passes/shade/estimator_inputs.h"

namespace overcast {

using shared::SkyPoint;

static_assert(sizeof(SkyPoint) == 32 && offsetof(SkyPoint, normal) == 16);
static_assert(sizeof(shared::SkyPointsPush) == 32 && sizeof(SkySeen) == 8);

namespace {

/// Points of one dispatch.
constexpr std::size_t kMostPoints = 65536;

Result<Done> fill(const Device& device, const PyramidPass& pyramid, const SkyEstimator& estimator, SkyPointsPass& pass) {
  ComputeSettings settings{estimatorShader("runtime/passes/shade/sky_points.comp.glsl", estimator), estimatorBindings(),
                           sizeof(shared::SkyPointsPush)};
  for (const std::uint32_t binding : {0u, 1u}) settings.bindings.push_back({binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  Result<Pipeline> pipeline = makeComputePipeline(device, settings);
  if (!pipeline) return pipeline.error();
  pass.pipeline = std::move(pipeline).value();
  Result<DescriptorSet> set = makeDescriptorSet(device, pass.pipeline);
  if (!set) return set.error();
  pass.set = std::move(set).value();
  const Result<GpuBuffer> constants = makeEstimatorConstants(device, estimator);
  if (!constants) return constants.error();
  pass.constants = constants.value();
  const auto storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  const Result<GpuBuffer> points = makeBuffer(device, kMostPoints * sizeof(SkyPoint), storage, MemoryUse::upload);
  if (!points) return points.error();
  pass.points = points.value();
  const Result<GpuBuffer> seen = makeBuffer(device, kMostPoints * sizeof(SkySeen), storage, MemoryUse::readback);
  if (!seen) return seen.error();
  pass.seen = seen.value();
  writeEstimator(device, pass.set, pyramid, pass.constants);
  writeBuffer(device, pass.set, 0, pass.points);
  writeBuffer(device, pass.set, 1, pass.seen);
  return Done{};
}

}  // namespace

Result<SkyPointsPass> makeSkyPointsPass(const Device& device, const PyramidPass& pyramid, const SkyEstimator& estimator) {
  SkyPointsPass pass;
  pass.skyWeight = estimator.skyWeight;
  const Result<Done> filled = fill(device, pyramid, estimator, pass);
  if (filled) return pass;
  destroySkyPointsPass(device, pass);
  return filled.error();
}

void destroySkyPointsPass(const Device& device, SkyPointsPass& pass) {
  destroyDescriptorSet(device, pass.set);
  destroyPipeline(device, pass.pipeline);
  for (GpuBuffer* buffer : {&pass.constants, &pass.points, &pass.seen}) destroyBuffer(device, *buffer);
  pass = {};
}

Result<std::vector<SkySeen>> seenAt(const Device& device, const SkyPointsPass& pass, std::span<const SkyPoint> points,
                                    const glm::vec3& up) {
  std::vector<SkySeen> seen(points.size());
  for (std::size_t first = 0; first < points.size(); first += kMostPoints) {
    const std::size_t count = std::min(kMostPoints, points.size() - first);
    std::memcpy(pass.points.mapped, points.data() + first, count * sizeof(SkyPoint));
    const Result<Done> done = runCommands(device, [&](VkCommandBuffer commands) {
      bind(commands, pass.pipeline, pass.set);
      push(commands, pass.pipeline,
           shared::SkyPointsPush{glm::vec4(pass.skyWeight * up, pass.skyWeight), glm::ivec4(static_cast<int>(count), 0, 0, 0)});
      vkCmdDispatch(commands, groups(static_cast<std::uint32_t>(count), 64), 1, 1);
      barrier(commands, kComputeWrite, kHostRead);
    });
    if (!done) return done.error();
    std::memcpy(seen.data() + first, pass.seen.mapped, count * sizeof(SkySeen));
  }
  return seen;
}

}  // namespace overcast
