// The aperture pass: light of a scene with apertures, over what the shade pass made of its pixels (aperture.h has the formulas).
#pragma once

#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/lighting.h"
#include "runtime/passes/aperture/aperture.h"
#include "runtime/passes/composite/global_grid.h"
#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/passes/pyramid/pyramid_pass.h"
#include "runtime/passes/screen/screen_pass.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// How lights and apertures are intersected; aperture.h says what each does. In the order of shared::kAperture....
enum class ApertureMode { exact, smoothstep, fast, accurate };

struct AperturePass {
  ScreenPass screen;
  GpuBuffer lights;        ///< shared::ApertureLight[shared::kMaxApertureLights], mapped
  bool overLight = false;  ///< the light image holds the sky visibility of the frame
};

/// What a pass reads and writes; all must outlive it.
struct ApertureInputs {
  const GeometryImages& images;         ///< made with apertures; with visibility at rest, that of the frame is in the light image
  const GpuImage& light;                ///< makeLightImage
  const PyramidPass* others = nullptr;  ///< over the global volume, which alone is read; null: the scene has one object
  const GpuBuffer* sky = nullptr;       ///< a shared::SkyLight, the frame's; null: the sky is uniform
};
Result<AperturePass> makeAperturePass(const Device& device, const ApertureInputs& inputs, ApertureMode mode);
void destroyAperturePass(const Device& device, AperturePass& pass);

/// The lights of a scene as the pass takes them, seen from `eye`: the sun first, then the spheres, where `worldFromNode` (one matrix for
/// each node) takes those that move with one. Those without colour or size give no light and are left out; at most
/// shared::kMaxApertureLights are returned.
std::vector<shared::ApertureLight> apertureLights(const Lighting& lighting, std::span<const glm::dmat4> worldFromNode,
                                                  const glm::dvec3& eye);

/// What the frame's camera and sky are.
struct ApertureView {
  glm::dmat4 clipFromRelative{1.0};  ///< as the geometry pass had it
  glm::dvec3 eye{0.0};
  glm::vec3 skyColour{1.0f};  ///< of a uniform sky
};

/// Records the pass; outside of rendering, after recordGeometry and recordComposite. `grid` is the composite's. Afterwards the light image
/// is as recordShade leaves it: rgb linear light of sun, spheres and sky, a what own shape and others leave of the sky. The device must not
/// be reading the lights of an earlier frame.
void recordAperture(VkCommandBuffer commands, AperturePass& pass, const GlobalGrid& grid, const std::vector<shared::ApertureLight>& lights,
                    const ApertureView& view);

}  // namespace overcast
