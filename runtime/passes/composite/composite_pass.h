// The composite pass: the global distance volume of a frame from its placed objects (composite.h has the formulas).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <vulkan/vulkan.h>

#include "runtime/asset_store.h"
#include "runtime/passes/composite/composite_object.h"
#include "runtime/passes/composite/global_grid.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

enum class CompositeMethod {
  culled,      ///< lists per brick, only bricks that something moved in (DESIGN 5.2)
  bruteForce,  ///< every object for every voxel; the same bits, for tests
};

struct CompositePass {
  GlobalGrid grid;
  CompositeMethod method = CompositeMethod::culled;
  std::uint32_t objectCapacity = 0;
  /// R16F, grid.size voxels, signed distance in voxels (shared::kFarField where there is no object), always in layout GENERAL.
  GpuImage volume;
  Pipeline cull;
  Pipeline composite;
  DescriptorSet set;
  GpuBuffer objects;
  GpuBuffer counts;
  GpuBuffer lists;
  GpuBuffer masks;
  GpuBuffer active;
  glm::vec3 atlasTexel{1.0f};                     ///< 1 / extent of the atlas of floats
  glm::vec3 texel8{1.0f};                         ///< and of that of 8 bits
  bool fresh = true;                              ///< nothing composited yet
  std::vector<shared::CompositeObject> previous;  ///< of the last recorded frame
};

/// A pass for at most `objectCapacity` objects whose assets are in `store`, which must outlive it. Waits for the device once. An Error
/// when the device has no room or the grid is larger than its 3D images.
Result<CompositePass> makeCompositePass(const Device& device, const GlobalGrid& grid, const AssetStore& store, std::uint32_t objectCapacity,
                                        CompositeMethod method = CompositeMethod::culled);
void destroyCompositePass(const Device& device, CompositePass& pass);

/// Records the composite of `objects` (from compositeObject() with pass.grid; each keeps its index from frame to frame) and returns true;
/// records nothing and returns false when nothing differs from the last recorded frame. Recorded commands must be submitted, in order.
/// Outside of rendering. Afterwards the volume may be sampled by compute and fragment shaders.
bool recordComposite(VkCommandBuffer commands, CompositePass& pass, std::span<const shared::CompositeObject> objects);

}  // namespace overcast
