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

/// Median, 95th percentile, and as noise the scatter of one round, of which stateNoise makes what a report states: 1.4826 times the median
/// distance from the median, which is the standard deviation of normal values and does not see the odd round that something else
/// disturbed; but so much that the noise reaches from the median to either quartile (of three values to either end), because so many rounds
/// may have been disturbed.
ReportTime timeOf(const std::vector<double>& milliseconds);

/// Of two things that happen one after the other; their scatter is independent.
ReportTime sumOf(const ReportTime& a, const ReportTime& b);

/// What one setting took: `rounds` holds one list per timed frame, all of the same passes; skipped passes count nothing. `composites` are
/// the times of a composite that the frames did without; none: they need none.
struct RoundTimes {
  ReportTime frame;                ///< sum of `still` and the passes that rest
  ReportTime still;                ///< all but composite and pyramid, which rest while nothing moves
  std::vector<ReportPass> passes;  ///< the composite, then those that ran in every round, in order
};
RoundTimes timesOf(const std::vector<std::vector<PassTime>>& rounds, const std::vector<double>& composites = {});

/// By what factor each round was slower than the typical one, of what took turns in them: `rounds[i]` are the times of one thing, 0 in
/// rounds that it did not draw in. Found by taking medians over things and rounds in turns (Tukey's median polish, of logarithms). 1 for
/// rounds of nothing.
std::vector<double> roundFactors(const std::vector<std::vector<double>>& rounds);

/// Makes the noise of all times of a report from their scatter: by how much the median of another run may differ, beside those of other
/// settings.
///   scatter   of a round, at least the report's typical one: few rounds may lie together by chance
///   median    of n rounds: kMedianSpread scatter / sqrt(n), and kConfidence times that, because a report has hundreds of times, none of
///   which
///             may differ by more
///   repeated  what medians differed by, beside each other, when they were taken again at the end (`ratios` to what they were): the share
///   that
///             9 of 10 kept within
/// The noise is the root of the sum of the squares of the last two. Sets Report::drift too, which is common to all settings: the share that
/// 9 of 10 of the `factors` of all rounds kept within, or by what all of `ratios` differed, whichever is more.
void stateNoise(Report& report, const std::vector<double>& factors, const std::vector<double>& ratios);

inline constexpr double kMedianSpread = 1.2533;  ///< of a median by that of a mean, for normal values
inline constexpr double kConfidence = 3.5;       ///< standard errors: 1 in 2,000 differs by more

}  // namespace overcast
