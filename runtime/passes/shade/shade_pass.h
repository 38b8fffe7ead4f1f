// The shade pass: light of every pixel from the geometry images and the distance pyramid (shade.h has the formulas).
#pragma once

#include <array>
#include <string>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/lighting.h"
#include "runtime/passes/composite/global_grid.h"
#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/passes/pyramid/pyramid_pass.h"
#include "runtime/passes/shade/shade.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// A sky estimator for one volume: visibility = exp(-(constant + sum weights[i] f_i)).
struct SkyTaps {
  std::string estimator;  ///< which shader
  int count = 0;          ///< taps, and pyramid levels they read, 1 to shared::kMaxTaps
  float constant = 0.0f;
  std::array<float, shared::kMaxTaps> weights{};  ///< per voxel of the global volume
  float skyWeight = 0.0f;                         ///< alpha
};

/// The estimator at `resolution` voxels along the longest side: `taps` reach as far in the world at any resolution, so that each doubling
/// above 128 adds a tap and each halving leaves one out (rounded, 1 to 8). An Error names an estimator we do not have.
Result<SkyTaps> skyTaps(const Estimator& estimator, int resolution);

/// The last frame's light is no longer read by what shows or saves it.
inline constexpr Access kEarlierLight{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
    VK_ACCESS_2_NONE, VK_IMAGE_LAYOUT_UNDEFINED};
/// How the light image may be used after recordShade.
inline constexpr Access kLightReady{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
    VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};

struct ShadePass {
  /// RGBA16F: rgb linear light, a sky visibility in [0, 1], or rgb 0 and a shared::kNoSurface where there is no surface. In layout
  /// SHADER_READ_ONLY_OPTIMAL after recordShade.
  GpuImage light;
  SkyTaps taps;
  Pipeline pipeline;
  DescriptorSet set;
  VkSampler nearest = VK_NULL_HANDLE;
};

/// Shades the pixels of `images` with a pyramid of at least taps.count levels; both must outlive the pass.
Result<ShadePass> makeShadePass(const Device& device, const GeometryImages& images, const PyramidPass& pyramid, const SkyTaps& taps);
void destroyShadePass(const Device& device, ShadePass& pass);

/// What the frame's camera and light are. Positions in world space.
struct ShadeView {
  glm::dmat4 clipFromRelative{1.0};  ///< as the geometry pass had it: clip space from positions relative to the eye
  glm::dvec3 eye{0.0};
  glm::vec3 skyColour{1.0f};       ///< Lighting::skyColour
  glm::vec3 up{0.0f, 1.0f, 0.0f};  ///< Lighting::up
};

/// Records the pass; outside of rendering, after recordGeometry, recordComposite and recordPyramid. `grid` is the composite's.
void recordShade(VkCommandBuffer commands, const ShadePass& pass, const GlobalGrid& grid, const ShadeView& view);

}  // namespace overcast
