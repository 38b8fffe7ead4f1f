// Timing: how long the settings of a bench take, in rounds in which they take turns.
#pragma once

#include <vector>

#include "runtime/report/bench.h"
#include "runtime/report/statistics.h"

namespace overcast {

struct TimingSettings {
  int width = 640;  ///< pixels of the pictures that are timed
  int height = 360;
  int rounds = 15;       ///< of each setting at most
  int leastRounds = 3;   ///< and at least; so many when `seconds` are spent on it
  double seconds = 1.0;  ///< on the device, after which a setting is timed no more
};

/// Times of all candidates, in order, in the view of `truth`. In each round every setting that is not done draws one frame and every volume
/// is composited anew as if everything moved, in alternating order, so that a device that slows down slows all of them; one frame of each
/// before them warms up. A composite is timed once for all settings of its resolution. Renderers keep the size of the timed pictures.
Result<std::vector<RoundTimes>> timeCandidates(Bench& bench, const TruthPicture& truth, const TimingSettings& settings);

}  // namespace overcast
