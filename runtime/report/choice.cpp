#include "runtime/report/choice.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "runtime/passes/shade/sky_estimator.h"
#include "runtime/report/sweep.h"
#include "runtime/technique.h"

namespace overcast {
namespace {

double costOf(const ReportRow& row, Cost cost) {
  switch (cost) {
    case Cost::frame:
      return row.frame.median;
    case Cost::still:
      return row.still.median;
    case Cost::bytes:
      break;
  }
  return static_cast<double>(row.gpuBytes + row.assetBytes);
}

bool isOurs(const ReportRow& row) {
  return row.technique == nameOf(Technique::overcast);
}

bool isOfFurtherBake(const ReportRow& row) {
  return !row.bake.empty();
}

/// Our row of the least error among those at most as slow as `theirs`, or null.
const ReportRow* oursAsFastAs(const ReportScene& scene, const ReportRow& theirs, Cost cost) {
  const ReportRow* best = nullptr;
  for (const ReportRow& row : scene.rows) {
    if (!isOurs(row) || isOfFurtherBake(row) || costOf(row, cost) > costOf(theirs, cost)) continue;
    if (best == nullptr || row.errors.rmse < best->errors.rmse) best = &row;
  }
  return best;
}

/// Of one figure over several rows.
struct Means {
  double squares = 0.0;
  double sum = 0.0;
  double logarithms = 0.0;
  int count = 0;

  void add(double value) {
    squares += value * value;
    sum += value;
    logarithms += std::log(std::max(value, 1e-12));
    ++count;
  }
  double rms() const { return std::sqrt(squares / count); }
  double mean() const { return sum / count; }
  double geometric() const { return sum > 0.0 ? std::exp(logarithms / count) : 0.0; }
};

template <class Get>
Means meansOf(const std::vector<const ReportRow*>& rows, const Get& get) {
  Means means;
  for (const ReportRow* row : rows) means.add(get(*row));
  return means;
}

ReportTime overallTime(const std::vector<const ReportRow*>& rows, ReportTime ReportRow::*member) {
  ReportTime time;
  for (double ReportTime::*figure : {&ReportTime::median, &ReportTime::p95, &ReportTime::noise})
    time.*figure = meansOf(rows, [&](const ReportRow& row) { return row.*member.*figure; }).geometric();
  return time;
}

ReportRow overallRow(const std::vector<const ReportRow*>& rows) {
  ReportRow row = *rows.front();
  row.passes.clear();
  row.steps.clear();
  row.occluders.clear();
  row.storable = false;
  row.errors.views.clear();
  row.frame.rounds = row.still.rounds = 0;
  for (double ReportErrors::*error : {&ReportErrors::rmse, &ReportErrors::rmseCorrected, &ReportErrors::p95, &ReportErrors::p99})
    row.errors.*error = meansOf(rows, [&](const ReportRow& one) { return one.errors.*error; }).rms();
  for (double ReportErrors::*error : {&ReportErrors::bias, &ReportErrors::mae, &ReportErrors::ssim, &ReportErrors::flip})
    row.errors.*error = meansOf(rows, [&](const ReportRow& one) { return one.errors.*error; }).mean();
  row.errors.max = 0.0;
  for (const ReportRow* one : rows) row.errors.max = std::max(row.errors.max, one->errors.max);
  const bool clips = std::all_of(rows.begin(), rows.end(), [](const ReportRow* one) { return one->errors.flicker >= 0.0; });
  row.errors.flicker = clips ? meansOf(rows, [](const ReportRow& one) { return one.errors.flicker; }).rms() : -1.0;
  row.frame = overallTime(rows, &ReportRow::frame);
  row.still = overallTime(rows, &ReportRow::still);
  row.gpuBytes = static_cast<std::uint64_t>(meansOf(rows, [](const ReportRow& one) { return static_cast<double>(one.gpuBytes); }).mean());
  row.assetBytes =
      static_cast<std::uint64_t>(meansOf(rows, [](const ReportRow& one) { return static_cast<double>(one.assetBytes); }).mean());
  return row;
}

}  // namespace

std::vector<Tradeoff> paretoFront(std::vector<Tradeoff> points) {
  std::stable_sort(points.begin(), points.end(),
                   [](const Tradeoff& a, const Tradeoff& b) { return std::tie(a.cost, a.error) < std::tie(b.cost, b.error); });
  std::vector<Tradeoff> front;
  for (const Tradeoff& point : points)
    if (front.empty() || point.error < front.back().error) front.push_back(point);
  return front;
}

std::vector<Tradeoff> tradeoffs(const ReportScene& scene, Cost cost) {
  std::vector<Tradeoff> points;
  for (std::size_t i = 0; i < scene.rows.size(); ++i) points.push_back({i, costOf(scene.rows[i], cost), scene.rows[i].errors.rmse});
  return points;
}

const ReportRow* chooseRow(const ReportScene& scene, const Wish& wish) {
  OVERCAST_REQUIRE(wish.budget.has_value() != wish.maxError.has_value(), "a wish is a budget or an error");
  const auto key = [&](const ReportRow& row) {
    const double bytes = costOf(row, Cost::bytes);
    return wish.budget ? std::tuple(row.errors.rmse, row.frame.median, bytes) : std::tuple(row.frame.median, row.errors.rmse, bytes);
  };
  const ReportRow* best = nullptr;
  for (const ReportRow& row : scene.rows) {
    const bool fits = wish.budget ? row.frame.median <= *wish.budget : row.errors.rmse <= *wish.maxError;
    if (row.storable && fits && (best == nullptr || key(row) < key(*best))) best = &row;
  }
  return best;
}

std::vector<Loss> losses(const ReportScene& scene, Cost cost) {
  std::vector<Loss> found;
  for (const ReportRow& row : scene.rows) {
    if (isOurs(row) || isOfFurtherBake(row)) continue;
    const ReportRow* ours = oursAsFastAs(scene, row, cost);
    if (ours != nullptr && ours->errors.rmse <= row.errors.rmse) continue;
    found.push_back({row.setting, row.errors.rmse, costOf(row, cost), ours ? ours->setting : "", ours ? ours->errors.rmse : 0.0});
  }
  return found;
}

bool leads(const ReportScene& scene, const ReportRow& row, Cost cost) {
  return std::none_of(scene.rows.begin(), scene.rows.end(), [&](const ReportRow& other) {
    return !isOurs(other) && !isOfFurtherBake(other) && costOf(other, cost) <= costOf(row, cost) && other.errors.rmse <= row.errors.rmse;
  });
}

const ReportRow* plainRow(const ReportScene& scene, const std::string& estimator, int taps) {
  const auto found = std::find_if(scene.rows.begin(), scene.rows.end(), [&](const ReportRow& row) {
    return isOurs(row) && !isOfFurtherBake(row) && row.estimator == estimator && row.taps == taps && row.cones == 0 &&
           row.resolution == 128 && row.apertureMode == (isHybrid(estimator) ? nameOf(ApertureMode::accurate) : "");
  });
  return found == scene.rows.end() ? nullptr : &*found;
}

Standing standingOf(const Report& report, Cost cost) {
  Standing standing;
  for (const ReportScene& scene : report.scenes) {
    ++standing.scenes;
    const std::vector<Loss> lost = losses(scene, cost);
    const auto counts = [](const Loss& loss) { return loss.setting != nameOf(Technique::constant); };
    if (std::none_of(lost.begin(), lost.end(), counts)) ++standing.matched;
    const ReportRow* hybrid = plainRow(scene, "hybrid", 4);
    if (hybrid != nullptr) ++standing.hybrids;
    if (hybrid != nullptr && leads(scene, *hybrid, cost)) ++standing.leading;
  }
  return standing;
}

namespace {

/// The settings that all scenes have, each made one row.
template <class Merge>
ReportScene merged(const Report& report, const Merge& merge) {
  ReportScene all;
  if (report.scenes.empty()) return all;
  all.name = "all scenes";
  for (const ReportRow& row : report.scenes.front().rows) {
    std::vector<const ReportRow*> rows;
    for (const ReportScene& scene : report.scenes)
      if (const ReportRow* same = rowNamed(scene, row.setting)) rows.push_back(same);
    if (rows.size() == report.scenes.size()) all.rows.push_back(merge(rows));
  }
  return all;
}

/// RMSE of the best single grey: what is left of a constant's without its bias.
double greyError(const ReportScene& scene) {
  const ReportRow* constant = rowNamed(scene, nameOf(Technique::constant));
  if (constant == nullptr) return 1.0;
  const ReportErrors& e = constant->errors;
  const double square = e.rmse * e.rmse - e.bias * e.bias;
  return square > 0.0 ? std::sqrt(square) : 1.0;
}

}  // namespace

ReportScene overall(const Report& report) {
  return merged(report, overallRow);
}

ReportScene normalised(const Report& report) {
  return merged(report, [&](const std::vector<const ReportRow*>& rows) {
    ReportRow row = overallRow(rows);
    Means errors, device, assets;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      errors.add(rows[i]->errors.rmse / greyError(report.scenes[i]));
      device.add(static_cast<double>(rows[i]->gpuBytes));
      assets.add(static_cast<double>(rows[i]->assetBytes));
    }
    row.errors.rmse = errors.geometric();
    row.gpuBytes = static_cast<std::uint64_t>(device.geometric());
    row.assetBytes = static_cast<std::uint64_t>(assets.geometric());
    return row;
  });
}

}  // namespace overcast
