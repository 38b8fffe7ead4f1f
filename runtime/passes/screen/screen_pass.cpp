#include "runtime/passes/screen/screen_pass.h"

#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace overcast {
namespace {

Result<Done> fill(const Device& device, const GeometryImages& images, const ComputeSettings& settings, ScreenPass& pass) {
  const Result<VkSampler> nearest = makeSampler(device, VK_FILTER_NEAREST);
  if (!nearest) return nearest.error();
  pass.nearest = nearest.value();
  Result<Pipeline> pipeline = makeComputePipeline(device, settings);
  if (!pipeline) return pipeline.error();
  pass.pipeline = std::move(pipeline).value();
  Result<DescriptorSet> set = makeDescriptorSet(device, pass.pipeline);
  if (!set) return set.error();
  pass.set = std::move(set).value();
  writeSampledImage(device, pass.set, 0, images.depth.view, pass.nearest);
  writeSampledImage(device, pass.set, 1, images.normal.view, pass.nearest);
  writeSampledImage(device, pass.set, 2, images.colour.view, pass.nearest);
  writeStorageImage(device, pass.set, 3, pass.light.mipViews[0]);
  return Done{};
}

}  // namespace

Result<GpuImage> makeLightImage(const Device& device, const GeometryImages& images) {
  ImageSettings settings;
  settings.extent = images.depth.extent;
  settings.format = VK_FORMAT_R16G16B16A16_SFLOAT;
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT;
  return makeImage(device, settings);
}

glm::mat4 voxelFromClip(const GlobalGrid& grid, const glm::dmat4& clipFromRelative, const glm::dvec3& eye) {
  return glm::mat4(voxelFromWorld(grid) * glm::translate(glm::dmat4(1.0), eye) * glm::inverse(clipFromRelative));
}

Result<ScreenPass> makeScreenPass(const Device& device, const GeometryImages& images, const GpuImage& light, const Shader& shader,
                                  const std::vector<Binding>& own, std::uint32_t pushBytes) {
  ComputeSettings settings{shader, {}, pushBytes};
  for (std::uint32_t i = 0; i + 1 < kFirstScreenBinding; ++i) settings.bindings.push_back({i, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  settings.bindings.push_back({kFirstScreenBinding - 1, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE});
  settings.bindings.insert(settings.bindings.end(), own.begin(), own.end());
  ScreenPass pass;
  pass.light = light;
  const Result<Done> filled = fill(device, images, settings, pass);
  if (filled) return pass;
  destroyScreenPass(device, pass);
  return filled.error();
}

void destroyScreenPass(const Device& device, ScreenPass& pass) {
  destroyDescriptorSet(device, pass.set);
  destroyPipeline(device, pass.pipeline);
  if (pass.nearest) vkDestroySampler(device.device, pass.nearest, nullptr);
  pass = {};
}

}  // namespace overcast
