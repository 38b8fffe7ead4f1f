// The program's own constants of `calibrated` (shade.h), fitted to the generated scenes 1 to 96; `./run calibrate` fits such anew.
#pragma once

#include <vector>

#include "formats/lighting.h"

namespace overcast {

/// For 4 to 6 taps; of other numbers the nearest of these.
std::vector<SkyStep> ownSteps(int taps);

}  // namespace overcast
