// The denoise pass: gives every pixel the mean of the sixteen sets of samples of its neighbours (denoise.h has the formulas).
#pragma once

#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/passes/screen/screen_pass.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

struct DenoisePass {
  GpuImage raw;  ///< makeLightImage; the pass before writes it, alpha alone is read
  ScreenPass screen;
};

/// Denoises `raw` into `light`, for pixels of `images`; both must outlive the pass, as must `sky`, a shared::SkyLight, without which the
/// sky is uniform.
Result<DenoisePass> makeDenoisePass(const Device& device, const GeometryImages& images, const GpuImage& light,
                                    const GpuBuffer* sky = nullptr);
void destroyDenoisePass(const Device& device, DenoisePass& pass);

/// Records the pass; outside of rendering, after the pass that writes `raw`.
void recordDenoise(VkCommandBuffer commands, const DenoisePass& pass, const ScreenView& view);

}  // namespace overcast
