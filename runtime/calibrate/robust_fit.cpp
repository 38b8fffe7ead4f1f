#include "runtime/calibrate/robust_fit.h"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <Eigen/Dense>

#include "formats/result.h"

namespace overcast {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kStep = 0x1p-8;       // of differences, relative to the parameter: predictions are single floats
constexpr double kSettled = 1e-6;      // relative fall of the loss that ends the fit
constexpr double kMostDamping = 1e12;  // beyond it nothing is better
constexpr double kLeastScale = 1e-9;   // of a parameter's curvature beside the largest

/// The loss at some parameters, with what a step needs to know about it.
struct State {
  std::vector<double> parameters;
  std::vector<float> predicted;
  double loss = 0.0;
};

double huber(double error, double outlier) {
  const double size = std::abs(error);
  return size <= outlier ? 0.5 * error * error : outlier * (size - 0.5 * outlier);
}

State stateAt(const FitProblem& problem, std::vector<double> parameters, std::span<const double> start) {
  State state{std::move(parameters), std::vector<float>(problem.truth.size()), 0.0};
  problem.predict(state.parameters, state.predicted);
  for (std::size_t row = 0; row < state.predicted.size(); ++row)
    state.loss += huber(double{state.predicted[row]} - double{problem.truth[row]}, problem.outlier);
  state.loss /= static_cast<double>(problem.truth.size());
  for (std::size_t i = 0; i < start.size(); ++i) state.loss += 0.5 * problem.pull * std::pow(state.parameters[i] - start[i], 2.0);
  return state;
}

/// Gradient of the loss and Gauss and Newton's approximation of its curvature.
struct Slopes {
  VectorXd gradient;
  MatrixXd curvature;
};

Slopes slopesAt(const FitProblem& problem, const State& state, std::span<const double> start) {
  const auto rows = static_cast<Index>(state.predicted.size()), count = static_cast<Index>(start.size());
  Eigen::MatrixXf jacobian(rows, count);
  tbb::parallel_for(Index{0}, count, [&](Index i) {
    std::vector<double> moved = state.parameters;
    std::vector<float> predicted(state.predicted.size());
    const auto at = static_cast<std::size_t>(i);
    const double size = kStep * std::max(1.0, std::abs(state.parameters[at]));
    const double step = state.parameters[at] + size > problem.high[at] ? -size : size;
    moved[at] = state.parameters[at] + step;
    problem.predict(moved, predicted);
    for (Index row = 0; row < rows; ++row) {
      const auto r = static_cast<std::size_t>(row);
      jacobian(row, i) = (predicted[r] - state.predicted[r]) / static_cast<float>(step);
    }
  });
  VectorXd pulls(rows), weights(rows);
  for (Index row = 0; row < rows; ++row) {
    const double error = double{state.predicted[static_cast<std::size_t>(row)]} - double{problem.truth[static_cast<std::size_t>(row)]};
    weights(row) = (std::abs(error) <= problem.outlier ? 1.0 : problem.outlier / std::abs(error)) / static_cast<double>(rows);
    pulls(row) = weights(row) * error;
  }
  const MatrixXd j = jacobian.cast<double>();
  Slopes slopes{j.transpose() * pulls, j.transpose() * weights.asDiagonal() * j};
  for (Index i = 0; i < count; ++i) {
    slopes.gradient(i) += problem.pull * (state.parameters[static_cast<std::size_t>(i)] - start[static_cast<std::size_t>(i)]);
    slopes.curvature(i, i) += problem.pull;
  }
  return slopes;
}

/// Parameters that a bound does not hold back from going downhill.
std::vector<Index> freeParameters(const FitProblem& problem, const State& state, const VectorXd& gradient) {
  std::vector<Index> free;
  for (std::size_t i = 0; i < state.parameters.size(); ++i) {
    const double slope = gradient(static_cast<Index>(i));
    const bool held = (state.parameters[i] <= problem.low[i] && slope > 0.0) || (state.parameters[i] >= problem.high[i] && slope < 0.0);
    if (!held) free.push_back(static_cast<Index>(i));
  }
  return free;
}

std::vector<double> stepped(const FitProblem& problem, const State& state, const Slopes& slopes, const std::vector<Index>& free,
                            double damping) {
  MatrixXd curvature = slopes.curvature(free, free);
  const double least = kLeastScale * std::max(curvature.diagonal().maxCoeff(), 1e-300);
  curvature.diagonal() += damping * curvature.diagonal().cwiseMax(least) + VectorXd::Constant(curvature.rows(), least);
  const VectorXd step = curvature.ldlt().solve(slopes.gradient(free));
  std::vector<double> parameters = state.parameters;
  for (std::size_t i = 0; i < free.size(); ++i) {
    const auto at = static_cast<std::size_t>(free[i]);
    parameters[at] = std::clamp(parameters[at] - step(static_cast<Index>(i)), problem.low[at], problem.high[at]);
  }
  return parameters;
}

}  // namespace

std::vector<double> fitRobustly(const FitProblem& problem, std::vector<double> start) {
  OVERCAST_REQUIRE(start.size() == problem.low.size() && start.size() == problem.high.size(), "{} parameters, {} and {} bounds",
                   start.size(), problem.low.size(), problem.high.size());
  for (std::size_t i = 0; i < start.size(); ++i) start[i] = std::clamp(start[i], problem.low[i], problem.high[i]);
  if (problem.truth.empty() || start.empty()) return start;
  State state = stateAt(problem, start, start);
  double damping = 1e-2;
  for (int round = 0; round < problem.rounds && damping < kMostDamping; ++round) {
    const Slopes slopes = slopesAt(problem, state, start);
    const std::vector<Index> free = freeParameters(problem, state, slopes.gradient);
    if (free.empty()) break;
    double fall = 0.0;
    while (fall <= 0.0 && damping < kMostDamping) {
      State next = stateAt(problem, stepped(problem, state, slopes, free, damping), start);
      fall = state.loss - next.loss;
      damping = fall > 0.0 ? std::max(damping / 5.0, 1e-9) : damping * 4.0;
      if (fall > 0.0) state = std::move(next);
    }
    if (fall < kSettled * state.loss) break;
  }
  return state.parameters;
}

double rootMeanSquare(std::span<const float> predicted, std::span<const float> truth) {
  double squares = 0.0;
  for (std::size_t row = 0; row < truth.size(); ++row) squares += std::pow(double{predicted[row]} - double{truth[row]}, 2.0);
  return truth.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(truth.size()));
}

}  // namespace overcast
