#include "runtime/report/statistics.h"

#include <algorithm>
#include <cmath>

namespace overcast {
namespace {

constexpr double kLeastNoise = 0.05;  // of the median
constexpr double kDriftShare = 0.9;   // of the settings

bool restsWhileStill(const std::string& pass) {
  return pass == "composite" || pass == "pyramid";
}

}  // namespace

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const auto place = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::clamp<std::size_t>(place, 1, values.size()) - 1];
}

ReportTime timeOf(const std::vector<double>& milliseconds) {
  ReportTime time{median(milliseconds), percentile(milliseconds, 0.95), 0.0, static_cast<int>(milliseconds.size())};
  time.noise = std::max(time.p95 - percentile(milliseconds, 0.05), kLeastNoise * time.median);
  return time;
}

ReportTime sumOf(const ReportTime& a, const ReportTime& b) {
  if (a.rounds == 0 || b.rounds == 0) return a.rounds == 0 ? b : a;
  return {a.median + b.median, a.p95 + b.p95, std::hypot(a.noise, b.noise), std::min(a.rounds, b.rounds)};
}

RoundTimes timesOf(const std::vector<std::vector<PassTime>>& rounds, const std::vector<double>& composites) {
  RoundTimes times;
  if (rounds.empty()) return times;
  if (!composites.empty()) times.passes.push_back({"composite", timeOf(composites)});
  std::vector<double> stills(rounds.size(), 0.0);
  for (std::size_t pass = 0; pass < rounds[0].size(); ++pass) {
    std::vector<double> own;
    for (std::size_t round = 0; round < rounds.size(); ++round) {
      const PassTime& time = rounds[round][pass];
      if (time.skipped) continue;
      own.push_back(time.milliseconds);
      if (!restsWhileStill(time.name)) stills[round] += time.milliseconds;
    }
    if (own.size() == rounds.size()) times.passes.push_back({rounds[0][pass].name, timeOf(own)});
  }
  times.still = timeOf(stills);
  times.frame = times.still;
  for (const ReportPass& pass : times.passes)
    if (restsWhileStill(pass.name)) times.frame = sumOf(times.frame, pass.time);
  return times;
}

void addDrift(Report& report, const std::vector<double>& ratios) {
  std::vector<double> differences;
  for (const double ratio : ratios) differences.push_back(std::abs(std::log(ratio)));
  report.drift = percentile(differences, kDriftShare);
  const auto widen = [&](ReportTime& time) { time.noise = std::hypot(time.noise, report.drift * time.median); };
  for (ReportScene& scene : report.scenes) {
    for (ReportRow& row : scene.rows) {
      widen(row.frame);
      widen(row.still);
      for (ReportPass& pass : row.passes) widen(pass.time);
    }
  }
}

}  // namespace overcast
