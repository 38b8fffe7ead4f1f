#include "runtime/report/choice.h"

#include <algorithm>
#include <cmath>
#include <tuple>

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

/// Our row of the least error among those at most as slow as `theirs`, or null.
const ReportRow* oursAsFastAs(const ReportScene& scene, const ReportRow& theirs, Cost cost) {
  const ReportRow* best = nullptr;
  for (const ReportRow& row : scene.rows) {
    if (!isOurs(row) || costOf(row, cost) > costOf(theirs, cost)) continue;
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

bool dominates(const ReportScene& scene, const std::string& ours, const ReportRow& theirs, Cost cost) {
  const ReportRow* row = rowNamed(scene, ours);
  return row != nullptr && row->errors.rmse <= theirs.errors.rmse && costOf(*row, cost) <= costOf(theirs, cost);
}

std::vector<Loss> losses(const Report& report) {
  std::vector<Loss> found;
  for (const ReportScene& scene : report.scenes) {
    for (const ReportRow& row : scene.rows) {
      if (isOurs(row)) continue;
      const ReportRow* ours = oursAsFastAs(scene, row, Cost::frame);
      if (ours != nullptr && ours->errors.rmse <= row.errors.rmse) continue;
      const ReportRow* still = oursAsFastAs(scene, row, Cost::still);
      found.push_back({scene.name, row.setting, row.errors.rmse, row.frame.median, ours ? ours->setting : "",
                       ours ? ours->errors.rmse : 0.0, still == nullptr || still->errors.rmse > row.errors.rmse});
    }
  }
  return found;
}

ReportScene overall(const Report& report) {
  ReportScene all;
  if (report.scenes.empty()) return all;
  all.name = "all scenes";
  for (const ReportRow& row : report.scenes.front().rows) {
    std::vector<const ReportRow*> rows;
    for (const ReportScene& scene : report.scenes)
      if (const ReportRow* same = rowNamed(scene, row.setting)) rows.push_back(same);
    if (rows.size() == report.scenes.size()) all.rows.push_back(overallRow(rows));
  }
  return all;
}

}  // namespace overcast
