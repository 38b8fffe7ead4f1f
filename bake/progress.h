// Progress: how long jobs tell their caller how far they are, and learn that they should stop.
#pragma once

#include <functional>

namespace overcast {

/// Called now and then from any thread with the share done in [0, 1]; returning false asks the job to stop. Empty: nobody listens.
using Progress = std::function<bool(double)>;

}  // namespace overcast
