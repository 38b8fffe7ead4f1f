// The program's own constants of `calibrated` (shade.h), fitted to the generated scenes 1 to 96; `./run calibrate` fits such anew.
#pragma once

#include <vector>

#include "formats/lighting.h"

namespace overcast {

struct CalibratedConstants {
  std::vector<float> weights;  ///< as many as taps
  std::vector<SkyStep> steps;
};

/// For 4 to 6 taps; of other numbers the nearest of these. They go with Estimator::skyWeight of 0.5.
CalibratedConstants ownConstants(int taps);

}  // namespace overcast
