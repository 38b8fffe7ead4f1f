// ErrorSplit: where the error of our settings comes from, by pictures that make one approximation more each.
#pragma once

#include <vector>

#include "formats/report.h"
#include "runtime/report/bench.h"

namespace overcast {

inline constexpr int kFinestVolume = 256;  ///< voxels of the volume that stands for the local occluders themselves

/// Writes the steps of our rows, in the order of the bench's candidates, whose fields are at the time of `truth` and hold
/// kFinestVolume; `pictures` are theirs of it. The chain of pictures, and what each step is called:
///   the reference
///   64 rays through the volume at kFinestVolume          representation (and what rays through any volume are off by)
///   64 rays through the volume at the setting's          composite: what fewer voxels lose
///   the setting, its taps reading that volume itself     estimator
///   the setting, its taps reading the pyramid            prefilter; settings that read none have 0
Result<Done> splitErrors(Bench& bench, const TruthPicture& truth, const std::vector<Image>& pictures, std::vector<ReportRow>& rows);

}  // namespace overcast
