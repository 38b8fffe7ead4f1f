// Statistics of timed rounds.
#pragma once

#include <string>
#include <vector>

#include "formats/report.h"
#include "runtime/vulkan/timer.h"

namespace overcast {

/// The middle of the sorted values, of an even number the mean of the middle two; 0 of none.
double median(std::vector<double> values);

/// The smallest of the values that a share of them, above 0 and at most 1, do not exceed; 0 of none.
double percentile(std::vector<double> values, double share);

/// Median, 95th percentile and noise. Noise is the range from the 5th to the 95th percentile, at least 5 % of the median: a clock drifts
/// between runs by more than within one.
ReportTime timeOf(const std::vector<double>& milliseconds);

/// What one setting took: `rounds` holds one list per timed frame, all of the same passes. Skipped passes count nothing.
struct RoundTimes {
  ReportTime frame;                ///< all passes
  ReportTime still;                ///< all but composite and pyramid, which rest while nothing moves
  std::vector<ReportPass> passes;  ///< those that ran in every round, in order
};
RoundTimes timesOf(const std::vector<std::vector<PassTime>>& rounds);

}  // namespace overcast
