// Timer: how long each named pass took on the device, by timestamps, for a ring of frames in flight.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "formats/result.h"
#include "runtime/vulkan/device.h"

namespace overcast {

/// What one pass took in one frame.
struct PassTime {
  std::string name;
  double milliseconds = 0.0;
  bool skipped = false;  ///< the pass did not run in that frame (or the device has no timestamps)
};

struct PassTimer {
  std::vector<std::string> names;
  std::uint32_t slots = 1;
  VkQueryPool pool = VK_NULL_HANDLE;
  std::vector<bool> ran;  ///< [slot * names.size() + pass], since beginTimedFrame of the slot
  double nanosecondsPerTick = 1.0;
  std::uint64_t tickMask = 0;  ///< 0: the device has no timestamps
};

/// A timer of these passes with `slots` frames in flight.
Result<PassTimer> makePassTimer(const Device& device, std::vector<std::string> names, std::uint32_t slots = 1);
void destroyPassTimer(const Device& device, PassTimer& timer);

/// Starts a frame in `slot`; outside of rendering, before any pass of that frame.
void beginTimedFrame(VkCommandBuffer commands, PassTimer& timer, std::uint32_t slot);
/// Around the commands of pass number `pass` (index into names), outside of rendering. Each pass at most once per frame.
void beginPass(VkCommandBuffer commands, PassTimer& timer, std::uint32_t slot, std::uint32_t pass);
void endPass(VkCommandBuffer commands, PassTimer& timer, std::uint32_t slot, std::uint32_t pass);

/// Times of the frame recorded in `slot`, one entry per name in order; the device must have finished it.
Result<std::vector<PassTime>> passTimes(const Device& device, const PassTimer& timer, std::uint32_t slot);

}  // namespace overcast
