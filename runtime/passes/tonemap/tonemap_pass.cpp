#include "runtime/passes/tonemap/tonemap_pass.h"

#include <cstddef>

namespace overcast {
namespace {

using shared::TonemapPush;

static_assert(sizeof(TonemapPush) == 96 && offsetof(TonemapPush, sky) == 48 && offsetof(TonemapPush, size) == 80);

constexpr std::uint32_t kGroupSide = 8;
constexpr std::uint32_t kSkyBinding = 3;

Result<GpuImage> makeResult(const Device& device, VkExtent3D extent, VkFormat format) {
  ImageSettings settings;
  settings.extent = extent;
  settings.format = format;
  settings.usage = VK_IMAGE_USAGE_STORAGE_BIT;
  return makeImage(device, settings);
}

Result<Done> fillPass(const Device& device, TonemapPass& pass, VkExtent3D extent, const GpuBuffer* sky) {
  ComputeSettings settings;
  settings.shader = {"runtime/passes/tonemap/tonemap.comp.glsl", {}};
  settings.bindings = {
      {0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}, {1, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE}, {2, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE}};
  settings.pushBytes = sizeof(TonemapPush);
  if (sky) {
    settings.shader.defines.push_back({"OVERCAST_SKY", "1"});
    settings.bindings.push_back({kSkyBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  }
  Result<Pipeline> pipeline = makeComputePipeline(device, settings);
  if (!pipeline) return pipeline.error();
  pass.pipeline = std::move(pipeline).value();
  Result<DescriptorSet> set = makeDescriptorSet(device, pass.pipeline);
  if (!set) return set.error();
  pass.set = std::move(set).value();
  if (sky) writeBuffer(device, pass.set, kSkyBinding, *sky);
  Result<GpuImage> resolved = makeResult(device, extent, VK_FORMAT_R32G32B32A32_SFLOAT);
  if (!resolved) return resolved.error();
  pass.resolved = std::move(resolved).value();
  Result<GpuImage> display = makeResult(device, extent, VK_FORMAT_R8G8B8A8_UNORM);
  if (!display) return display.error();
  pass.display = std::move(display).value();
  const Result<VkSampler> sampler = makeSampler(device, VK_FILTER_NEAREST);
  if (!sampler) return sampler.error();
  pass.sampler = sampler.value();
  return Done{};
}

}  // namespace

Result<TonemapPass> makeTonemapPass(const Device& device, const GpuImage& light, int samplesPerSide, const GpuBuffer* sky) {
  const auto side = static_cast<std::uint32_t>(samplesPerSide);
  const VkExtent3D& full = light.extent;
  OVERCAST_REQUIRE(samplesPerSide > 0 && full.width % side == 0 && full.height % side == 0, "{}x{} by {}", full.width, full.height, side);
  TonemapPass pass;
  pass.samplesPerSide = samplesPerSide;
  const Result<Done> filled = fillPass(device, pass, {full.width / side, full.height / side, 1}, sky);
  if (!filled) {
    destroyTonemapPass(device, pass);
    return filled.error();
  }
  writeSampledImage(device, pass.set, 0, light.view, pass.sampler);
  writeStorageImage(device, pass.set, 1, pass.resolved.mipViews[0]);
  writeStorageImage(device, pass.set, 2, pass.display.mipViews[0]);
  return pass;
}

void destroyTonemapPass(const Device& device, TonemapPass& pass) {
  vkDestroySampler(device.device, pass.sampler, nullptr);
  destroyImage(device, pass.resolved);
  destroyImage(device, pass.display);
  destroyDescriptorSet(device, pass.set);
  destroyPipeline(device, pass.pipeline);
  pass = {};
}

void recordTonemap(VkCommandBuffer commands, const TonemapPass& pass, const TonemapView& view) {
  const auto width = static_cast<int>(pass.display.extent.width);
  const auto height = static_cast<int>(pass.display.extent.height);
  // The images are written whole, so what they held before may be lost; but its readers must be done.
  Access before = kTransferRead;
  before.layout = VK_IMAGE_LAYOUT_UNDEFINED;
  for (const GpuImage* image : {&pass.resolved, &pass.display}) transition(commands, *image, before, kComputeWrite);
  bind(commands, pass.pipeline, pass.set);
  push(commands, pass.pipeline, tonemapPush(view, width, height, pass.samplesPerSide));
  vkCmdDispatch(commands, groups(pass.display.extent.width, kGroupSide), groups(pass.display.extent.height, kGroupSide), 1);
  for (const GpuImage* image : {&pass.resolved, &pass.display}) transition(commands, *image, kComputeWrite, kTransferRead);
}

shared::TonemapPush tonemapPush(const TonemapView& view, int width, int height, int samplesPerSide) {
  // Reversed depth: 1 is the near plane, where positions relative to the eye are directions.
  const auto ray = [&](float x, float y) {
    const glm::vec4 point = view.relativeFromClip * glm::vec4(x, y, 1.0f, 1.0f);
    return glm::vec4(glm::vec3(point) / point.w, 0.0f);
  };
  TonemapPush constants;
  constants.cornerRay = ray(-1.0f, -1.0f);
  constants.rightRay = ray(1.0f, -1.0f) - constants.cornerRay;
  constants.downRay = ray(-1.0f, 1.0f) - constants.cornerRay;
  constants.sky = glm::vec4(view.skyColour, view.exposure);
  constants.up = glm::vec4(view.up, 0.0f);
  constants.size = glm::ivec4(width, height, samplesPerSide, 0);
  return constants;
}

}  // namespace overcast
