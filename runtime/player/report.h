// Report: what a run of frames took, as a table for people and as JSON for programs.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "runtime/player/options.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/timer.h"

namespace overcast {

/// One pass over all measured frames.
struct PassStatistics {
  std::string name;
  std::size_t frames = 0;   ///< measured frames in which it ran
  std::size_t skipped = 0;  ///< measured frames in which it did not
  double median = 0.0;      ///< milliseconds over the frames in which it ran; 0 when there is none
  double p95 = 0.0;         ///< the smallest of these that 95 % of them do not exceed
};

/// Statistics of each pass and, last, of the whole frame ("frame", the sum of its passes). `frames` holds one list per frame, all of the
/// same passes. The first frame is a warm-up and left out when there are more than 4.
std::vector<PassStatistics> statistics(const std::vector<std::vector<PassTime>>& frames);

/// What a headless run did.
struct PlayResult {
  DeviceInfo device;
  std::vector<std::vector<PassTime>> frames;
  std::vector<std::uint64_t> triangles;  ///< drawn in each frame
  std::vector<std::string> pictures;     ///< files written, in order
};

/// A table in plain characters that ends with a line break.
std::string table(const PlayResult& result);
/// The same and more, as one JSON object that ends with a line break.
std::string json(const PlayerOptions& options, const PlayResult& result);
/// The devices as a table or as JSON.
std::string table(const std::vector<DeviceInfo>& devices);
std::string json(const std::vector<DeviceInfo>& devices);

}  // namespace overcast
