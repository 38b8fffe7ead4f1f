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

/// Of two things that happen one after the other; their noise is independent.
ReportTime sumOf(const ReportTime& a, const ReportTime& b);

/// What one setting took: `rounds` holds one list per timed frame, all of the same passes; skipped passes count nothing. `composites` are
/// the times of a composite that the frames did without; none: they need none.
struct RoundTimes {
  ReportTime frame;                ///< sum of `still` and the passes that rest
  ReportTime still;                ///< all but composite and pyramid, which rest while nothing moves
  std::vector<ReportPass> passes;  ///< the composite, then those that ran in every round, in order
};
RoundTimes timesOf(const std::vector<std::vector<PassTime>>& rounds, const std::vector<double>& composites = {});

/// Sets the report's drift from the ratios that times had to what they were when they were taken again, and adds it to the noise of all its
/// times.
void addDrift(Report& report, const std::vector<double>& ratios);

}  // namespace overcast
