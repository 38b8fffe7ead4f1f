// The shade pass: light of every pixel from the geometry images and the distance pyramid (shade.h has the formulas).
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "runtime/passes/composite/global_grid.h"
#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/passes/pyramid/pyramid_pass.h"
#include "runtime/passes/screen/screen_pass.h"
#include "runtime/passes/shade/sky_estimator.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

struct ShadePass {
  ScreenPass screen;
  SkyEstimator estimator;
  GpuBuffer constants;  ///< shared::SkyConstants
};

/// Shades the pixels of `images` into `light` with a pyramid of at least estimator.levels; all must outlive the pass, as must `sky`, a
/// shared::SkyLight, without which the sky is uniform. Over images with visibility at rest the light image's alpha is what an aperture pass
/// goes on with (rest.h); `atRest` is the pyramid of the volume at rest, null where no pixel looks that up.
Result<ShadePass> makeShadePass(const Device& device, const GeometryImages& images, const GpuImage& light, const PyramidPass& pyramid,
                                const SkyEstimator& estimator, const GpuBuffer* sky = nullptr, const PyramidPass* atRest = nullptr);
void destroyShadePass(const Device& device, ShadePass& pass);

/// What the frame's camera and light are. Positions in world space.
struct ShadeView {
  glm::dmat4 clipFromRelative{1.0};  ///< as the geometry pass had it: clip space from positions relative to the eye
  glm::dvec3 eye{0.0};
  glm::vec3 skyColour{1.0f};       ///< of a uniform sky
  glm::vec3 up{0.0f, 1.0f, 0.0f};  ///< Lighting::up
};

/// Records the pass; outside of rendering, after recordGeometry, recordComposite and recordPyramid. `grid` is the composite's.
void recordShade(VkCommandBuffer commands, const ShadePass& pass, const GlobalGrid& grid, const ShadeView& view);

}  // namespace overcast
