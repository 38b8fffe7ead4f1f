#include "runtime/passes/pyramid/pyramid_pass.h"

#include <cstddef>
#include <utility>

namespace overcast {

static_assert(sizeof(shared::PyramidPush) == 32 && offsetof(shared::PyramidPush, texel) == 16);

namespace {

/// Earlier frames still sample the levels that are about to be written.
constexpr Access kEarlierUse{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_NONE,
                             VK_IMAGE_LAYOUT_GENERAL};
constexpr Access kLevelReady{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                             VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_LAYOUT_GENERAL};

VkExtent3D halved(const VkExtent3D& extent) {
  return {groups(extent.width, 2), groups(extent.height, 2), groups(extent.depth, 2)};
}

Result<Done> addLevel(const Device& device, PyramidPass& pass, const VkExtent3D& extent) {
  ImageSettings settings;
  settings.extent = extent;
  settings.volume = true;
  settings.format = VK_FORMAT_R16_SFLOAT;
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT;
  Result<GpuImage> image = makeImage(device, settings);
  if (!image) return image.error();
  pass.built.push_back(std::move(image).value());
  Result<DescriptorSet> set = makeDescriptorSet(device, pass.filter);
  if (!set) return set.error();
  pass.sets.push_back(std::move(set).value());
  writeSampledImage(device, pass.sets.back(), 0, pass.views.back(), pass.sampler, VK_IMAGE_LAYOUT_GENERAL);
  writeStorageImage(device, pass.sets.back(), 1, pass.built.back().mipViews[0]);
  pass.views.push_back(pass.built.back().view);
  return Done{};
}

Result<Done> fill(const Device& device, const GpuImage& volume, int levels, PyramidPass& pass) {
  Result<VkSampler> sampler = makeSampler(device, VK_FILTER_LINEAR);
  if (!sampler) return sampler.error();
  pass.sampler = sampler.value();
  Result<Pipeline> filter =
      makeComputePipeline(device, {{"runtime/passes/pyramid/pyramid.comp.glsl", {}},
                                   {{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}, {1, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE}},
                                   sizeof(shared::PyramidPush)});
  if (!filter) return filter.error();
  pass.filter = std::move(filter).value();
  pass.views.push_back(volume.view);
  pass.volumeExtent = volume.extent;
  VkExtent3D extent = volume.extent;
  for (int level = 1; level < levels; ++level) {
    extent = halved(extent);
    Result<Done> added = addLevel(device, pass, extent);
    if (!added) return added;
  }
  return runCommands(device, [&](VkCommandBuffer commands) {
    for (const GpuImage& image : pass.built) transition(commands, image, kNothingYet, kComputeWrite);
  });
}

}  // namespace

Result<PyramidPass> makePyramidPass(const Device& device, const GpuImage& volume, int levels) {
  OVERCAST_REQUIRE(levels >= 1 && levels <= shared::kMaxPyramidLevels, "{} levels", levels);
  PyramidPass pass;
  const Result<Done> filled = fill(device, volume, levels, pass);
  if (filled) return pass;
  destroyPyramidPass(device, pass);
  return filled.error();
}

void destroyPyramidPass(const Device& device, PyramidPass& pass) {
  for (DescriptorSet& set : pass.sets) destroyDescriptorSet(device, set);
  for (GpuImage& image : pass.built) destroyImage(device, image);
  destroyPipeline(device, pass.filter);
  if (pass.sampler) vkDestroySampler(device.device, pass.sampler, nullptr);
  pass = {};
}

void recordPyramid(VkCommandBuffer commands, const PyramidPass& pass) {
  if (pass.built.empty()) return;
  barrier(commands, kEarlierUse, kComputeWrite);
  VkExtent3D below = pass.volumeExtent;
  for (std::size_t level = 0; level < pass.built.size(); ++level) {
    const VkExtent3D size = pass.built[level].extent;
    bind(commands, pass.filter, pass.sets[level]);
    push(commands, pass.filter,
         shared::PyramidPush{glm::ivec4(size.width, size.height, size.depth, 0),
                             glm::vec4(1.0f / glm::vec3(below.width, below.height, below.depth), 0.0f)});
    vkCmdDispatch(commands, groups(size.width, 8), groups(size.height, 4), groups(size.depth, 2));
    barrier(commands, kComputeWrite, kLevelReady);
    below = size;
  }
}

}  // namespace overcast
