#include "runtime/passes/shade/shade_pass.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace overcast {

static_assert(sizeof(shared::ShadePush) == 128 && offsetof(shared::ShadePush, skew) == 64 && offsetof(shared::ShadePush, weights) == 96);

namespace {

/// The resolution at which Estimator::taps counts (formats/lighting.h).
constexpr double kTapResolution = 128.0;

constexpr std::uint32_t kFirstLevelBinding = 4;

std::vector<Binding> bindings() {
  std::vector<Binding> all{{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
                           {1, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
                           {2, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER},
                           {3, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE}};
  for (std::uint32_t level = 0; level < shared::kMaxPyramidLevels; ++level)
    all.push_back({kFirstLevelBinding + level, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  return all;
}

Shader shaderOf(const SkyTaps& taps) {
  std::string upper = taps.estimator;
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return {"runtime/passes/shade/shade.comp.glsl", {{"OVERCAST_ESTIMATOR_" + upper, "1"}, {"OVERCAST_TAPS", fmt::format("{}", taps.count)}}};
}

Result<Done> fill(const Device& device, const GeometryImages& images, const PyramidPass& pyramid, ShadePass& pass) {
  ImageSettings settings;
  settings.extent = images.depth.extent;
  settings.format = VK_FORMAT_R16G16B16A16_SFLOAT;
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT;
  Result<GpuImage> light = makeImage(device, settings);
  if (!light) return light.error();
  pass.light = std::move(light).value();
  Result<VkSampler> nearest = makeSampler(device, VK_FILTER_NEAREST);
  if (!nearest) return nearest.error();
  pass.nearest = nearest.value();
  Result<Pipeline> pipeline = makeComputePipeline(device, {shaderOf(pass.taps), bindings(), sizeof(shared::ShadePush)});
  if (!pipeline) return pipeline.error();
  pass.pipeline = std::move(pipeline).value();
  Result<DescriptorSet> set = makeDescriptorSet(device, pass.pipeline);
  if (!set) return set.error();
  pass.set = std::move(set).value();
  writeSampledImage(device, pass.set, 0, images.depth.view, pass.nearest);
  writeSampledImage(device, pass.set, 1, images.normal.view, pass.nearest);
  writeSampledImage(device, pass.set, 2, images.colour.view, pass.nearest);
  writeStorageImage(device, pass.set, 3, pass.light.mipViews[0]);
  for (std::size_t level = 0; level < shared::kMaxPyramidLevels; ++level)
    writeSampledImage(device, pass.set, kFirstLevelBinding + static_cast<std::uint32_t>(level),
                      pyramid.views[std::min(level, pyramid.views.size() - 1)], pyramid.sampler, VK_IMAGE_LAYOUT_GENERAL);
  return Done{};
}

}  // namespace

Result<SkyTaps> skyTaps(const Estimator& estimator, int resolution) {
  if (estimator.name != "published")
    return Error{"", "estimator", fmt::format("unknown estimator '{}' (known: published)", estimator.name)};
  SkyTaps taps;
  taps.estimator = estimator.name;
  const int added = static_cast<int>(std::lround(std::log2(resolution / kTapResolution)));
  taps.count = std::clamp(estimator.taps + added, 1, shared::kMaxTaps);
  taps.skyWeight = estimator.skyWeight;
  taps.constant = estimator.k * estimator.skyWeight;
  float sum = 0.0f;
  for (int tap = 0; tap < taps.count; ++tap) sum += shared::tapDistance(tap);
  for (int tap = 0; tap < taps.count; ++tap) taps.weights[static_cast<std::size_t>(tap)] = estimator.k / sum;
  return taps;
}

Result<ShadePass> makeShadePass(const Device& device, const GeometryImages& images, const PyramidPass& pyramid, const SkyTaps& taps) {
  OVERCAST_REQUIRE(static_cast<int>(pyramid.views.size()) >= taps.count, "{} levels for {} taps", pyramid.views.size(), taps.count);
  ShadePass pass;
  pass.taps = taps;
  const Result<Done> filled = fill(device, images, pyramid, pass);
  if (filled) return pass;
  destroyShadePass(device, pass);
  return filled.error();
}

void destroyShadePass(const Device& device, ShadePass& pass) {
  destroyDescriptorSet(device, pass.set);
  destroyPipeline(device, pass.pipeline);
  if (pass.nearest) vkDestroySampler(device.device, pass.nearest, nullptr);
  destroyImage(device, pass.light);
  pass = {};
}

void recordShade(VkCommandBuffer commands, const ShadePass& pass, const GlobalGrid& grid, const ShadeView& view) {
  const glm::dmat4 worldFromClip = glm::translate(glm::dmat4(1.0), view.eye) * glm::inverse(view.clipFromRelative);
  shared::ShadePush constants;
  constants.voxelFromClip = glm::mat4(voxelFromWorld(grid) * worldFromClip);
  constants.skew = glm::vec4(pass.taps.skyWeight * view.up, pass.taps.constant);
  constants.sky = glm::vec4(view.skyColour, 0.0f);
  for (int half = 0; half < 2; ++half)
    for (int i = 0; i < 4; ++i) constants.weights[half][i] = pass.taps.weights[static_cast<std::size_t>(4 * half + i)];

  transition(commands, pass.light, kEarlierLight, kComputeWrite);
  bind(commands, pass.pipeline, pass.set);
  push(commands, pass.pipeline, constants);
  vkCmdDispatch(commands, groups(pass.light.extent.width, 8), groups(pass.light.extent.height, 8), 1);
  transition(commands, pass.light, kComputeWrite, kLightReady);
}

}  // namespace overcast
