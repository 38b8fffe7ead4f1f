#include "runtime/report/statistics.h"

#include <algorithm>
#include <cmath>

namespace overcast {
namespace {

constexpr double kLeastNoise = 0.05;  // of the median

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
  ReportTime time{median(milliseconds), percentile(milliseconds, 0.95), 0.0};
  time.noise = std::max(time.p95 - percentile(milliseconds, 0.05), kLeastNoise * time.median);
  return time;
}

RoundTimes timesOf(const std::vector<std::vector<PassTime>>& rounds) {
  RoundTimes times;
  if (rounds.empty()) return times;
  std::vector<double> frames(rounds.size(), 0.0), stills(rounds.size(), 0.0);
  for (std::size_t pass = 0; pass < rounds[0].size(); ++pass) {
    std::vector<double> own;
    for (std::size_t round = 0; round < rounds.size(); ++round) {
      const PassTime& time = rounds[round][pass];
      if (time.skipped) continue;
      own.push_back(time.milliseconds);
      frames[round] += time.milliseconds;
      if (!restsWhileStill(time.name)) stills[round] += time.milliseconds;
    }
    if (own.size() == rounds.size()) times.passes.push_back({rounds[0][pass].name, timeOf(own)});
  }
  times.frame = timeOf(frames);
  times.still = timeOf(stills);
  return times;
}

}  // namespace overcast
