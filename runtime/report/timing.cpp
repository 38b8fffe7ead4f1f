#include "runtime/report/timing.h"

#include <algorithm>
#include <map>

namespace overcast {
namespace {

/// A candidate or field and what its frames took.
struct Timed {
  Candidate* candidate;
  bool field;  ///< only its composite counts
  std::vector<std::vector<PassTime>> rounds;
  double milliseconds = 0.0;
};

bool isDone(const Timed& timed, const TimingSettings& settings) {
  const auto rounds = static_cast<int>(timed.rounds.size());
  return rounds >= settings.rounds || (rounds >= settings.leastRounds && timed.milliseconds >= 1e3 * settings.seconds);
}

Result<Done> drawOne(Bench& bench, Timed& timed, const ReferenceInfo& info, bool counts) {
  if (timed.field) timed.candidate->renderer.composite.fresh = true;
  auto frame = renderCandidate(bench.device, *timed.candidate, bench.scene, info.time, info.view);
  if (!frame) return frame.error();
  if (!counts) return Done{};
  for (const PassTime& pass : frame.value())
    if (!pass.skipped) timed.milliseconds += pass.milliseconds;
  timed.rounds.push_back(std::move(frame).value());
  return Done{};
}

/// A round of all that are not done; false where there was none.
Result<bool> drawRound(Bench& bench, std::vector<Timed>& all, const ReferenceInfo& info, const TimingSettings& settings, int round) {
  bool drew = false;
  for (std::size_t step = 0; step < all.size(); ++step) {
    Timed& timed = all[round % 2 == 0 ? step : all.size() - 1 - step];
    if (isDone(timed, settings)) continue;
    drew = true;
    if (const auto drawn = drawOne(bench, timed, info, true); !drawn) return drawn.error();
  }
  return drew;
}

std::vector<double> compositeTimes(const Timed& timed) {
  std::vector<double> times;
  for (const auto& round : timed.rounds)
    for (const PassTime& pass : round)
      if (pass.name == "composite" && !pass.skipped) times.push_back(pass.milliseconds);
  return times;
}

}  // namespace

Result<std::vector<RoundTimes>> timeCandidates(Bench& bench, const TruthPicture& truth, const TimingSettings& settings) {
  const ReferenceInfo& info = truth.reference.info;
  std::vector<Timed> all;
  for (auto& [resolution, field] : bench.fields) all.push_back({&field, true, {}, 0.0});
  for (Candidate& candidate : bench.candidates) {
    const auto resized = resizeFrames(bench.device, candidate.renderer, settings.width, settings.height);
    if (!resized) return resized.error();
    all.push_back({&candidate, false, {}, 0.0});
  }
  if (const auto moved = moveFields(bench, truth); !moved) return moved.error();
  for (Timed& timed : all)
    if (!timed.field)
      if (const auto warm = drawOne(bench, timed, info, false); !warm) return warm.error();
  for (int round = 0;; ++round) {
    const auto drew = drawRound(bench, all, info, settings, round);
    if (!drew) return drew.error();
    if (!drew.value()) break;
  }
  std::map<int, std::vector<double>> composites;
  std::vector<RoundTimes> times;
  for (const Timed& timed : all) {
    const SweepSetting& setting = timed.candidate->setting;
    if (timed.field)
      composites[setting.resolution] = compositeTimes(timed);
    else
      times.push_back(timesOf(timed.rounds, readsVolume(setting.technique) ? composites[setting.resolution] : std::vector<double>()));
  }
  return times;
}

}  // namespace overcast
