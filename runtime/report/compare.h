// Compare: what changed between two reports, and whether it got worse beyond noise.
#pragma once

#include <string>
#include <vector>

#include "formats/report.h"

namespace overcast {

/// Errors differ from run to run by nothing on one device, and by rounding between devices: a change within this share of the error, or
/// within kErrorRounding, is none.
inline constexpr double kErrorShare = 0.005;
inline constexpr double kErrorRounding = 2e-5;

/// A device that is busier, or clocked lower, than in the other run slows all settings of a scene alike. Of scenes with at least so many
/// settings in both reports that common factor is told apart, as the median of the ratios of their times while nothing moves: it is judged
/// by what both reports state as drift, and the times of each setting beside it. Of others the drift counts as noise.
inline constexpr std::size_t kEnoughSettings = 8;

struct Change {
  std::string scene;
  std::string setting;
  std::string figure;  ///< "rmse", "flicker", "frame ms", "still ms", "bytes", or of all settings together "speed", a factor
  double before = 0.0;
  double after = 0.0;
  double noise = 0.0;   ///< a difference up to this is no change; of times the sum of what both reports state
  double common = 1.0;  ///< of times, what `before` was multiplied by before it was compared
  bool worse = false;
};

struct Comparisons {
  std::vector<Change> changes;       ///< beyond noise, in the order of the later report
  std::vector<std::string> missing;  ///< "scene: setting" of the earlier report that the later one lacks
  std::vector<std::string> added;
  std::size_t compared = 0;  ///< settings that both have
  bool sameDevice = true;    ///< and the same driver and size of the timed pictures: else times are not compared
};

Comparisons compareReports(const Report& before, const Report& after);

/// Whether anything got worse, or is gone.
bool regressed(const Comparisons& comparisons);

/// What changed, as lines for people that end with the verdict.
std::string comparisonText(const Comparisons& comparisons);

}  // namespace overcast
