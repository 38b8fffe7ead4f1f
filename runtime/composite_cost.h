// Composite cost: measures on a device what one evaluation of each kind of occluder takes in the composite (formats/composite_costs.h).
#pragma once

#include "formats/composite_costs.h"
#include "formats/result.h"
#include "runtime/vulkan/device.h"

namespace overcast {

/// What is measured and how often.
struct CostSettings {
  int objects = 16;   ///< that one asset is placed as, evaluated at every voxel
  int voxels = 64;    ///< along the side of the global volume, a multiple of 8
  int runs = 9;       ///< timed ones of each kind, after one that warms up
  int largest = 128;  ///< no larger sizes
};

/// For every kind, size and precision: composites one asset, placed `objects` times and turned at random (one seed) so that its box fills
/// about half of the volume, by brute force: the number of evaluations is known, and half of them lie beyond the box. The time is that
/// between timestamps around the pass over voxels^3 * objects. Each kind is a scene of its own; all take turns in every run, so that
/// a device that slows down slows all alike. An Error when the device has no timestamps or no room.
Result<CompositeCosts> measureCompositeCosts(const Device& device, const CostSettings& settings);

}  // namespace overcast
