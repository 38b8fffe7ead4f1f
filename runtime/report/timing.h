// Timing: how long the settings of a bench take, in rounds in which they take turns.
#pragma once

#include <vector>

#include "runtime/report/bench.h"
#include "runtime/report/statistics.h"

namespace overcast {

struct TimingSettings {
  int width = 640;  ///< pixels of the pictures that are timed
  int height = 360;
  int rounds = 9;        ///< of the fastest settings
  int leastRounds = 3;   ///< of the slowest
  double seconds = 0.5;  ///< on the device for each setting: how many rounds it takes, within these limits
};

/// Rounds of a setting whose frame takes so many milliseconds.
int roundsOf(double milliseconds, const TimingSettings& settings);
/// Whether a setting of `wanted` rounds draws in one of `rounds`, numbered from 0: evenly spread, so that a device that drifts does not
/// favour those of few rounds or of many.
bool drawsIn(int round, int wanted, int rounds);

struct Timing {
  std::vector<RoundTimes> times;  ///< of all candidates, in order
  std::vector<double> factors;    ///< by which each round was slower than the typical one
};

/// Times all candidates in the view of `truth`. In each round settings draw one frame each and every volume is composited anew as if
/// everything moved, in alternating order; one frame of each before them warms up. A composite is timed once for all settings of its
/// resolution. Times are divided by the factor of their round (roundFactors): a device that slows down, or has other things to do, slows
/// all settings of a round. Renderers keep the size of the timed pictures.
Result<Timing> timeCandidates(Bench& bench, const TruthPicture& truth, const TimingSettings& settings);

}  // namespace overcast
