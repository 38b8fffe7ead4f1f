// Pairs of caps for tests and the bench, and the methods of cap_methods.h on a device.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/result.h"
#include "runtime/vulkan/device.h"
#include "tests/bench/cap_methods.h"

namespace overcast {

/// What two caps are to each other. Radii are in [1e-4, pi/2]; all kinds but the last two overlap partly.
enum class PairKind {
  generic,        ///< radii 0.1 to pi/2
  small,          ///< both radii 1e-4 to pi/2, evenly in their logarithm
  sun,            ///< one of 0.00465 rad (the sun), the other as generic
  tangent,        ///< about to part or to be one in the other: within 1e-6 to 1e-2 of the smaller radius
  hemispherical,  ///< one is a hemisphere, or both nearly
  nested,         ///< one within the other, down to the border
  apart,          ///< nothing in common, from the border on
};

/// `count` pairs of a kind, the same for the same seed; axes with exactly that distance to rounding, normals anywhere.
std::vector<shared::CapPair> makePairs(PairKind kind, std::size_t count, std::uint32_t seed);

struct DeviceRun {
  std::vector<float> results;  ///< one per pair: the sum over the repeats
  double milliseconds = 0.0;   ///< by timestamps; 0 where the device has none
};

/// Evaluates `method` (shared::kMethod...) for all pairs.
Result<DeviceRun> evaluateOnDevice(const Device& device, const std::vector<shared::CapPair>& pairs, int method, int repeats = 1);

}  // namespace overcast
