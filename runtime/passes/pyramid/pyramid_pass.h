// The pyramid pass: low-passed copies of the global volume for the far taps (pyramid.h has the filter).
#pragma once

#include <vector>

#include <vulkan/vulkan.h>

#include "runtime/passes/pyramid/pyramid.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

struct PyramidPass {
  std::vector<GpuImage> built;         ///< levels 1, 2, ...: R16F, voxels of level 0, always in layout GENERAL
  std::vector<VkImageView> views;      ///< of all levels, level 0 (the volume given) first
  VkExtent3D volumeExtent{};           ///< voxels of level 0
  VkSampler sampler = VK_NULL_HANDLE;  ///< trilinear, clamped to the edge: for all levels
  Pipeline filter;
  std::vector<DescriptorSet> sets;  ///< one for each built level
};

/// A pyramid of `levels` levels (1 to shared::kMaxPyramidLevels, as many as taps read) over `volume` (R16F, layout GENERAL), which must
/// outlive it. Waits for the device once.
Result<PyramidPass> makePyramidPass(const Device& device, const GpuImage& volume, int levels);
void destroyPyramidPass(const Device& device, PyramidPass& pass);

/// Records all levels above 0. The volume must be visible to sampling in compute shaders, as recordComposite leaves it; needed only when
/// that changed it. Afterwards the levels may be sampled by compute and fragment shaders.
void recordPyramid(VkCommandBuffer commands, const PyramidPass& pass);

}  // namespace overcast
