// RestVisibility: what the sky estimator says of every object in the situation its apertures were baked in, for what is left of baked
// visibility in a frame (runtime/passes/shade/rest.h).
//
// That situation is all nodes that no animation moves, where they lie, for those of them that were baked with others
// (BakedAgainst::atRest), else the object alone as it stands at time 0.
#pragma once

#include <optional>

#include "runtime/asset_store.h"
#include "runtime/passes/composite/composite_pass.h"
#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/passes/pyramid/pyramid_pass.h"
#include "runtime/passes/shade/sky_estimator.h"
#include "runtime/scene.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// All that rests.
struct RestVolume {
  CompositePass composite;
  PyramidPass pyramid;
};

struct RestVisibility {
  RestBuffers buffers;               ///< for makeGeometryPass
  std::optional<RestVolume> volume;  ///< for makeShadePass; none where no object looks it up
};

/// Whether any pixel can see anything else than its apertures say: in scenes of one object, and where all objects rest and have apertures
/// that know of each other everywhere, none can.
bool canChange(const RuntimeScene& scene);

/// Of all objects of `scene`, which has apertures and whose assets are in `store`, by the estimator over volumes of `grid`. Waits. An Error
/// when the device has no room.
Result<RestVisibility> makeRestVisibility(const Device& device, const RuntimeScene& scene, const AssetStore& store, const GlobalGrid& grid,
                                          const SkyEstimator& estimator);
void destroyRestVisibility(const Device& device, RestVisibility& rest);

}  // namespace overcast
