// Screen passes: compute passes with one thread for each pixel that read the geometry images and write the light image.
#pragma once

#include <vector>

#include <vulkan/vulkan.h>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "runtime/passes/composite/global_grid.h"
#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/passes/screen/screen.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// The last frame's light is no longer read by what shows or saves it.
inline constexpr Access kEarlierLight{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
    VK_ACCESS_2_NONE, VK_IMAGE_LAYOUT_UNDEFINED};
/// How the light image may be used after a screen pass.
inline constexpr Access kLightReady{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
    VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};

/// RGBA16F, as large as the images: rgb linear light, a sky visibility in [0, 1], or rgb 0 and a shared::kNoSurface where there is no
/// surface. In layout SHADER_READ_ONLY_OPTIMAL after a screen pass.
Result<GpuImage> makeLightImage(const Device& device, const GeometryImages& images);

/// Where a frame is seen from, and the light of its sky.
struct ScreenView {
  glm::dmat4 clipFromRelative{1.0};  ///< as the geometry pass had it: clip space from positions relative to the eye
  glm::dvec3 eye{0.0};               ///< world space
  glm::vec3 skyColour{1.0f};         ///< Lighting::skyColour
};

/// Voxel coordinates of `grid` from clip space, before the division by w.
glm::mat4 voxelFromClip(const GlobalGrid& grid, const glm::dmat4& clipFromRelative, const glm::dvec3& eye);

/// First binding that is a shader's own: those of screen.glsl come before.
inline constexpr std::uint32_t kFirstScreenBinding = 4;

struct ScreenPass {
  Pipeline pipeline;
  DescriptorSet set;
  VkSampler nearest = VK_NULL_HANDLE;
  GpuImage light;  ///< not owned
};

/// A pass of `shader`, which includes screen.glsl, over `images` into `light`; both must outlive it. `own` are bindings from
/// kFirstScreenBinding on: whoever makes the pass writes them.
Result<ScreenPass> makeScreenPass(const Device& device, const GeometryImages& images, const GpuImage& light, const Shader& shader,
                                  const std::vector<Binding>& own, std::uint32_t pushBytes);
void destroyScreenPass(const Device& device, ScreenPass& pass);

/// Records the pass; outside of rendering, after recordGeometry. The light image is in kLightReady afterwards. `overLight`: the shader
/// reads what another pass left in it.
template <class T>
void recordScreenPass(VkCommandBuffer commands, const ScreenPass& pass, const T& constants, bool overLight = false) {
  transition(commands, pass.light, overLight ? kLightReady : kEarlierLight, overLight ? kComputeReadWrite : kComputeWrite);
  bind(commands, pass.pipeline, pass.set);
  push(commands, pass.pipeline, constants);
  vkCmdDispatch(commands, groups(pass.light.extent.width, 8), groups(pass.light.extent.height, 8), 1);
  transition(commands, pass.light, kComputeWrite, kLightReady);
}

}  // namespace overcast
