#include "runtime/report/statistics.h"

#include <algorithm>
#include <cmath>

namespace overcast {
namespace {

constexpr double kDriftShare = 0.9;  // of settings or rounds
constexpr int kPolishes = 8;

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
  std::vector<double> distances;
  for (const double value : milliseconds) distances.push_back(std::abs(value - time.median));
  const double quartile = std::max(time.median - percentile(milliseconds, 0.25), percentile(milliseconds, 0.75) - time.median);
  time.noise = std::max(1.4826 * median(std::move(distances)), quartile * std::sqrt(time.rounds) / (kConfidence * kMedianSpread));
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

std::vector<double> roundFactors(const std::vector<std::vector<double>>& rounds) {
  const std::size_t count = rounds.empty() ? 0 : rounds[0].size();
  std::vector<double> own(rounds.size(), 0.0), slow(count, 0.0);
  const auto rest = [&](std::size_t i, std::size_t r) { return std::log(rounds[i][r]) - own[i] - slow[r]; };
  for (int polish = 0; polish < kPolishes; ++polish) {
    for (std::size_t i = 0; i < rounds.size(); ++i) {
      std::vector<double> rests;
      for (std::size_t r = 0; r < count; ++r)
        if (rounds[i][r] > 0.0) rests.push_back(rest(i, r));
      own[i] += median(std::move(rests));
    }
    for (std::size_t r = 0; r < count; ++r) {
      std::vector<double> rests;
      for (std::size_t i = 0; i < rounds.size(); ++i)
        if (rounds[i][r] > 0.0) rests.push_back(rest(i, r));
      slow[r] += median(std::move(rests));
    }
  }
  const double typical = median(slow);
  for (double& factor : slow) factor = std::exp(factor - typical);
  return slow;
}

void stateNoise(Report& report, const std::vector<double>& factors, const std::vector<double>& ratios) {
  const double common = ratios.empty() ? 1.0 : median(ratios);
  std::vector<double> drifts, differences, scatters;
  for (const double factor : factors) drifts.push_back(std::abs(std::log(factor)));
  for (const double ratio : ratios) differences.push_back(std::abs(std::log(ratio / common)));
  report.drift = std::max(percentile(drifts, kDriftShare), std::abs(std::log(common)));
  const double repeated = percentile(differences, kDriftShare);
  for (const ReportScene& scene : report.scenes)
    for (const ReportRow& row : scene.rows)
      if (row.still.median > 0.0) scatters.push_back(row.still.noise / row.still.median);
  const double typical = median(scatters);
  const auto state = [&](ReportTime& time) {
    const double scatter = std::max(time.noise, typical * time.median);
    const double ofMedian = kMedianSpread * scatter / std::sqrt(std::max(time.rounds, 1));
    time.noise = std::hypot(kConfidence * ofMedian, repeated * time.median);
  };
  for (ReportScene& scene : report.scenes) {
    for (ReportRow& row : scene.rows) {
      state(row.frame);
      state(row.still);
      for (ReportPass& pass : row.passes) state(pass.time);
    }
  }
}

}  // namespace overcast
