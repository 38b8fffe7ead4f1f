#include "runtime/report/timing.h"

#include <algorithm>
#include <map>

namespace overcast {
namespace {

/// A candidate or field and what its frames took.
struct Timed {
  Candidate* candidate;
  bool field;                                 ///< only its composite counts
  std::vector<std::vector<PassTime>> rounds;  ///< empty where it does not draw
  int wanted = 0;                             ///< rounds
};

/// Of all passes, or of a field's composite.
double milliseconds(const std::vector<PassTime>& passes, bool field) {
  double sum = 0.0;
  for (const PassTime& pass : passes)
    if (!pass.skipped && (!field || pass.name == "composite")) sum += pass.milliseconds;
  return sum;
}

Result<std::vector<PassTime>> drawOne(Bench& bench, Timed& timed, const ReferenceInfo& info) {
  if (timed.field) timed.candidate->renderer.composite.fresh = true;
  return renderCandidate(bench.device, *timed.candidate, bench.scene, info.time, info.view);
}

/// A frame that does not count but tells how many will.
Result<Done> warmUp(Bench& bench, Timed& timed, const ReferenceInfo& info, const TimingSettings& settings) {
  const auto frame = drawOne(bench, timed, info);
  if (!frame) return frame.error();
  timed.wanted = roundsOf(milliseconds(frame.value(), timed.field), settings);
  timed.rounds.resize(static_cast<std::size_t>(settings.rounds));
  return Done{};
}

Result<Done> drawRound(Bench& bench, std::vector<Timed>& all, const ReferenceInfo& info, int round) {
  for (std::size_t step = 0; step < all.size(); ++step) {
    Timed& timed = all[round % 2 == 0 ? step : all.size() - 1 - step];
    std::vector<PassTime>& passes = timed.rounds[static_cast<std::size_t>(round)];
    if (!drawsIn(round, timed.wanted, static_cast<int>(timed.rounds.size()))) continue;
    auto frame = drawOne(bench, timed, info);
    if (!frame) return frame.error();
    passes = std::move(frame).value();
  }
  return Done{};
}

/// Divides all times by the factor of their round, drops rounds in which a candidate did not draw, and returns the factors.
std::vector<double> evenOut(std::vector<Timed>& all) {
  std::vector<std::vector<double>> rounds;
  for (const Timed& timed : all) {
    rounds.emplace_back();
    for (const auto& passes : timed.rounds) rounds.back().push_back(milliseconds(passes, timed.field));
  }
  const std::vector<double> factors = roundFactors(rounds);
  for (Timed& timed : all) {
    for (std::size_t round = 0; round < factors.size(); ++round)
      for (PassTime& pass : timed.rounds[round]) pass.milliseconds /= factors[round];
    std::erase_if(timed.rounds, [](const auto& passes) { return passes.empty(); });
  }
  return factors;
}

std::vector<double> compositeTimes(const Timed& timed) {
  std::vector<double> times;
  for (const auto& round : timed.rounds)
    for (const PassTime& pass : round)
      if (pass.name == "composite" && !pass.skipped) times.push_back(pass.milliseconds);
  return times;
}

}  // namespace

int roundsOf(double milliseconds, const TimingSettings& settings) {
  const int most = std::max(settings.rounds, 1), least = std::min(settings.leastRounds, most);
  const double within = 1e3 * settings.seconds / std::max(milliseconds, 1e-6);
  return within >= most ? most : std::max(static_cast<int>(within), least);
}

bool drawsIn(int round, int wanted, int rounds) {
  return (round + 1) * wanted / rounds > round * wanted / rounds;
}

Result<Timing> timeCandidates(Bench& bench, const TruthPicture& truth, const TimingSettings& settings) {
  const ReferenceInfo& info = truth.reference.info;
  std::vector<Timed> all;
  for (auto& [resolution, field] : bench.fields) all.push_back({&field, true, {}});
  for (Candidate& candidate : bench.candidates) {
    const auto resized = resizeFrames(bench.device, candidate.renderer, settings.width, settings.height);
    if (!resized) return resized.error();
    all.push_back({&candidate, false, {}});
  }
  for (Timed& timed : all)
    if (const auto warm = warmUp(bench, timed, info, settings); !warm) return warm.error();
  for (int round = 0; round < settings.rounds; ++round)
    if (const auto drawn = drawRound(bench, all, info, round); !drawn) return drawn.error();
  Timing timing{{}, evenOut(all)};
  std::map<int, std::vector<double>> composites;
  for (const Timed& timed : all) {
    const SweepSetting& setting = timed.candidate->setting;
    if (timed.field)
      composites[setting.resolution] = compositeTimes(timed);
    else
      timing.times.push_back(
          timesOf(timed.rounds, readsVolume(setting.technique) ? composites[setting.resolution] : std::vector<double>()));
  }
  return timing;
}

}  // namespace overcast
