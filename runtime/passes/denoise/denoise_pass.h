// The denoise pass: gives every pixel the mean of its neighbours' sets of samples (denoise.h has the formulas).
#pragma once

#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/passes/screen/screen_pass.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

struct DenoisePass {
  GpuImage raw;    ///< makeLightImage; the pass before writes visibility as alpha and, where it is wide, nearness as red and a guide
                   ///< as blue
  GpuImage other;  ///< of a wide pattern: steps read one of the two and write the other
  std::vector<ScreenPass> steps;
  int rays = 0;
};

struct DenoiseSettings {
  bool wide = false;               ///< the pattern is that of 16x16
  bool few = false;                ///< pixels have one sample each
  int rays = 8;                    ///< of a pixel, where it is wide
  const GpuBuffer* sky = nullptr;  ///< a shared::SkyLight; null: the sky is uniform
};

/// Denoises `raw` into `light`, for pixels of `images`; both must outlive the pass, as must the sky.
Result<DenoisePass> makeDenoisePass(const Device& device, const GeometryImages& images, const GpuImage& light,
                                    const DenoiseSettings& settings = {});
void destroyDenoisePass(const Device& device, DenoisePass& pass);

/// Records the pass; outside of rendering, after the pass that writes `raw`.
void recordDenoise(VkCommandBuffer commands, const DenoisePass& pass, const ScreenView& view);

}  // namespace overcast
