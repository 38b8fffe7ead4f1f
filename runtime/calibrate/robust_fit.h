// RobustFit: bounded least squares that outliers do not pull away.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace overcast {

/// What is fitted: predicted(parameters) to `truth`, row by row.
struct FitProblem {
  std::span<const float> truth;
  std::vector<double> low, high;  ///< bounds, one for each parameter
  /// Fills one value for each row; smooth in the parameters. Called from several threads.
  std::function<void(std::span<const double> parameters, std::span<float> predicted)> predict;
  /// Errors beyond this count linearly, not squared (P. Huber, "Robust Estimation of a Location Parameter", 1964).
  double outlier = 0.25;
  /// Pull towards the start, as a share of a row's weight per row: keeps parameters where they were that the rows say nothing about.
  double pull = 0.0;
  int rounds = 100;  ///< at most
};

/// Parameters within the bounds that minimise the mean loss, or a local minimum of it: Levenberg and Marquardt's steps (J. More, "The
/// Levenberg-Marquardt Algorithm: Implementation and Theory", 1978) over those parameters that a bound does not hold back, on weights that
/// are renewed each round. Never worse than `start`, which is moved into the bounds first. No rows: the start.
std::vector<double> fitRobustly(const FitProblem& problem, std::vector<double> start);

/// Root of the mean squared error, 0 without rows.
double rootMeanSquare(std::span<const float> predicted, std::span<const float> truth);

}  // namespace overcast
