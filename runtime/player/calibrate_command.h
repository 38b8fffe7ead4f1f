// overcast-player calibrate: fits a scene's sky estimator to its reference.
#pragma once

namespace overcast {

/// Runs `overcast-player calibrate` with the arguments from "calibrate" on; the exit code.
int calibrateCommand(int argc, char** argv);

}  // namespace overcast
