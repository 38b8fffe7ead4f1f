// The tonemap pass: from the shaded picture to linear and display images of the size asked for (tonemap.h has the formulas).
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "runtime/passes/tonemap/tonemap.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

struct TonemapPass {
  Pipeline pipeline;
  DescriptorSet set;
  VkSampler sampler = VK_NULL_HANDLE;
  GpuImage resolved;  ///< RGBA32F: rgb linear radiance with the backdrop, a sky visibility (1 on the backdrop)
  GpuImage display;   ///< RGBA8: display-encoded sRGB, opaque
  int samplesPerSide = 1;
};

/// What the picture is seen with.
struct TonemapView {
  glm::mat4 relativeFromClip{1.0f};  ///< positions relative to the eye from clip space
  glm::vec3 skyColour{1.0f};
  glm::vec3 up{0.0f, 1.0f, 0.0f};  ///< unit vector
  float exposure = 1.0f;
};

/// A pass from `light` (makeLightImage: RGBA16F; rgb radiance, a sky visibility or shared::kNoSurface; layout SHADER_READ_ONLY_OPTIMAL),
/// `samplesPerSide` times as wide and high as the picture. Behind the scene lies the sky of `sky`, a shared::SkyLight, or without one
/// shared::backdrop. Both must outlive the pass.
Result<TonemapPass> makeTonemapPass(const Device& device, const GpuImage& light, int samplesPerSide, const GpuBuffer* sky = nullptr);
void destroyTonemapPass(const Device& device, TonemapPass& pass);

/// Reads what earlier commands made visible to sampling in compute shaders. Afterwards both images may be copied from
/// (kTransferRead).
void recordTonemap(VkCommandBuffer commands, const TonemapPass& pass, const TonemapView& view);

/// The push constants of a view, for a picture of `width` x `height`.
shared::TonemapPush tonemapPush(const TonemapView& view, int width, int height, int samplesPerSide);

}  // namespace overcast
