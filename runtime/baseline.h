// Baseline: the passes of a technique other than Overcast's own, over the geometry images and, where it reads one, the global volume.
#pragma once

#include <vector>

#include "runtime/passes/composite/global_grid.h"
#include "runtime/passes/screen/screen_pass.h"
#include "runtime/passes/surfels/surfel_pass.h"
#include "runtime/technique.h"
#include "runtime/vulkan/device.h"

namespace overcast {

struct Baseline {
  TechniqueSettings settings;
  std::uint32_t surfels = 0;  ///< placed nodes of Technique::surfels
  ScreenPass light;
  VkSampler trilinear = VK_NULL_HANDLE;  ///< of techniques that read the volume
};

/// What the passes read and write; all must outlive them.
struct BaselineInputs {
  const GeometryImages& images;
  const GpuImage& light;                ///< makeLightImage; DenoisePass::raw where denoises(technique)
  const GpuImage& volume;               ///< CompositePass::volume; looked at where readsVolume(technique)
  const SurfelPass* surfels = nullptr;  ///< of Technique::surfels
};

/// The passes of a technique, which is not Technique::overcast.
Result<Baseline> makeBaseline(const Device& device, const TechniqueSettings& settings, const BaselineInputs& inputs);
void destroyBaseline(const Device& device, Baseline& baseline);

/// Records the pass that finds visibility, and light where recordDenoise need not follow; after recordGeometry, and after recordComposite
/// of the volume in `grid` or recordSurfels where the technique reads their work.
void recordBaseline(VkCommandBuffer commands, const Baseline& baseline, const GlobalGrid& grid, const ScreenView& view);

}  // namespace overcast
