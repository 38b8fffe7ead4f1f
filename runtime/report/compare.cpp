#include "runtime/report/compare.h"

#include <algorithm>
#include <cmath>

#include "runtime/report/statistics.h"

namespace overcast {
namespace {

/// Compares one figure, of which less is better.
void compareFigure(Comparisons& all, Change change) {
  const double difference = change.after - change.before * change.common;
  if (std::abs(difference) <= change.noise) return;
  change.worse = difference > 0.0;
  all.changes.push_back(std::move(change));
}

double errorNoise(double before, double after) {
  return std::max(kErrorRounding, kErrorShare * std::max(before, after));
}

/// What is common to all times of a scene.
struct Speed {
  double factor = 1.0;
  double drift = 0.0;  ///< that is part of each time's noise
};

void compareRows(Comparisons& all, const std::string& scene, const ReportRow& before, const ReportRow& after, const Speed& speed) {
  ++all.compared;
  const auto compare = [&](const char* figure, double was, double is, double noise) {
    compareFigure(all, {scene, after.setting, figure, was, is, noise, 1.0, false});
  };
  const auto compareTimes = [&](const char* figure, const ReportTime& was, const ReportTime& is) {
    const double noise = was.noise * speed.factor + is.noise + speed.drift * is.median;
    compareFigure(all, {scene, after.setting, figure, was.median, is.median, noise, speed.factor, false});
  };
  compare("rmse", before.errors.rmse, after.errors.rmse, errorNoise(before.errors.rmse, after.errors.rmse));
  if (before.errors.flicker >= 0.0 && after.errors.flicker >= 0.0)
    compare("flicker", before.errors.flicker, after.errors.flicker, errorNoise(before.errors.flicker, after.errors.flicker));
  compare("bytes", static_cast<double>(before.gpuBytes + before.assetBytes), static_cast<double>(after.gpuBytes + after.assetBytes), 0.0);
  if (!all.sameDevice) return;
  compareTimes("frame ms", before.frame, after.frame);
  compareTimes("still ms", before.still, after.still);
}

/// Judges what all times of a scene have in common.
Speed compareSpeed(Comparisons& all, const ReportScene& before, const ReportScene& after, double drift) {
  std::vector<double> ratios;
  for (const ReportRow& row : after.rows)
    if (const ReportRow* was = rowNamed(before, row.setting); was != nullptr && was->still.median > 0.0 && row.still.median > 0.0)
      ratios.push_back(row.still.median / was->still.median);
  if (!all.sameDevice || ratios.size() < kEnoughSettings) return {1.0, drift};
  const double factor = median(ratios);
  compareFigure(all, {after.name, "all settings", "speed", 1.0, factor, std::expm1(drift), 1.0, false});
  return {factor, 0.0};
}

const ReportScene* sceneNamed(const Report& report, const std::string& name) {
  const auto found = std::find_if(report.scenes.begin(), report.scenes.end(), [&](const ReportScene& scene) { return scene.name == name; });
  return found == report.scenes.end() ? nullptr : &*found;
}

/// Rows of `from` that `in` lacks.
std::vector<std::string> lacking(const Report& from, const Report& in) {
  std::vector<std::string> names;
  for (const ReportScene& scene : from.scenes) {
    const ReportScene* same = sceneNamed(in, scene.name);
    for (const ReportRow& row : scene.rows)
      if (same == nullptr || rowNamed(*same, row.setting) == nullptr) names.push_back(scene.name + ": " + row.setting);
  }
  return names;
}

std::string number(const std::string& figure, double value) {
  if (figure == "bytes") return fmt::format("{:.0f}", value);
  return figure.ends_with("ms") ? fmt::format("{:.3f}", value) : fmt::format("{:.5f}", value);
}

}  // namespace

Comparisons compareReports(const Report& before, const Report& after) {
  Comparisons all;
  all.sameDevice = before.device == after.device && before.driver == after.driver && before.timedWidth == after.timedWidth &&
                   before.timedHeight == after.timedHeight;
  for (const ReportScene& scene : after.scenes) {
    const ReportScene* was = sceneNamed(before, scene.name);
    if (was == nullptr) continue;
    const Speed speed = compareSpeed(all, *was, scene, before.drift + after.drift);
    for (const ReportRow& row : scene.rows)
      if (const ReportRow* old = rowNamed(*was, row.setting)) compareRows(all, scene.name, *old, row, speed);
  }
  all.missing = lacking(before, after);
  all.added = lacking(after, before);
  return all;
}

bool regressed(const Comparisons& comparisons) {
  return !comparisons.missing.empty() ||
         std::any_of(comparisons.changes.begin(), comparisons.changes.end(), [](const Change& change) { return change.worse; });
}

std::string comparisonText(const Comparisons& comparisons) {
  std::string lines;
  for (const Change& change : comparisons.changes)
    lines += fmt::format("{} {}: {}: {} {} -> {} ({:+.1f} %{}, noise {})\n", change.worse ? "WORSE " : "better", change.scene,
                         change.setting, change.figure, number(change.figure, change.before), number(change.figure, change.after),
                         change.before > 0.0 ? 100.0 * (change.after / (change.before * change.common) - 1.0) : 0.0,
                         change.common == 1.0 ? "" : fmt::format(" beside a common factor of {:.2f}", change.common),
                         number(change.figure, change.noise));
  for (const std::string& name : comparisons.missing) lines += "GONE   " + name + "\n";
  for (const std::string& name : comparisons.added) lines += "new    " + name + "\n";
  if (!comparisons.sameDevice) lines += "times are of other devices, drivers or sizes and were not compared\n";
  const auto worse =
      std::count_if(comparisons.changes.begin(), comparisons.changes.end(), [](const Change& change) { return change.worse; });
  return lines + fmt::format("{} settings compared: {} figures worse and {} better beyond noise, {} settings gone, {} new\n",
                             comparisons.compared, worse, comparisons.changes.size() - static_cast<std::size_t>(worse),
                             comparisons.missing.size(), comparisons.added.size());
}

}  // namespace overcast
