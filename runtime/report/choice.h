// Choice: what a report says about settings: the fronts, the best under a budget, and where another technique wins.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/report.h"

namespace overcast {

/// A setting as a point of a chart.
struct Tradeoff {
  std::size_t row = 0;  ///< index into the scene's rows
  double cost = 0.0;
  double error = 0.0;
};

/// Those that no other one beats in one figure without losing in the other, by rising cost and falling error. Of equal ones the first
/// stays.
std::vector<Tradeoff> paretoFront(std::vector<Tradeoff> points);

enum class Cost { frame, still, bytes };
/// A scene's rows, in order: RMSE against milliseconds of a frame (median) or bytes on the device and of assets.
std::vector<Tradeoff> tradeoffs(const ReportScene& scene, Cost cost);

/// What a user asks for: one of both.
struct Wish {
  std::optional<double> budget;    ///< milliseconds of a frame (median) while everything moves: the least error within them
  std::optional<double> maxError;  ///< RMSE: the fastest within it
};

/// The row that fits the wish best among those a scene can hold, or null when none does. Of equal ones the one of fewer bytes, then the
/// first.
const ReportRow* chooseRow(const ReportScene& scene, const Wish& wish);

/// A setting of another technique with less error than everything of ours that is as fast.
struct Loss {
  std::string setting;
  double rmse = 0.0;
  double milliseconds = 0.0;
  std::string ours;      ///< our setting of the least error that is as fast; empty: none is
  double ourRmse = 0.0;  ///< of it
};
/// Further bakes count nowhere here.
std::vector<Loss> losses(const ReportScene& scene, Cost cost);

/// Whether `row` has less error than every other technique of equal or less cost.
bool leads(const ReportScene& scene, const ReportRow& row, Cost cost);

/// Our setting of an estimator with so many taps at 128^3, apertures in the best mode where it reads some; null when there is none.
const ReportRow* plainRow(const ReportScene& scene, const std::string& estimator, int taps);

/// In how many scenes we come out ahead.
struct Standing {
  int scenes = 0;
  int matched = 0;  ///< no other technique but the constant has a Loss: one of ours is as good and as fast as each
  int hybrids = 0;  ///< that have a hybrid at four taps
  int leading = 0;  ///< of them, where it leads
};
Standing standingOf(const Report& report, Cost cost);

/// The settings that all scenes have, over all scenes: RMSE and the other mean errors as the root of the mean of their squares or as means,
/// times as geometric means, bytes as means. An empty name where the report has no scenes.
ReportScene overall(const Report& report);

/// The same settings with every scene weighing the same: RMSE as a share of what the best single grey would be off by in the scene, as far
/// as its row `constant` tells (1 where there is none); geometric means of that, of times and of bytes.
ReportScene normalised(const Report& report);

}  // namespace overcast
