// FLIP as its paper states it (Andersson et al. 2020), in double, with filters of two dimensions summed directly. Shares no code with the
// runtime.
#pragma once

#include <array>
#include <vector>

namespace overcast::reference {

using Rgb = std::array<double, 3>;

/// The error of each pixel. Both pictures hold width * height pixels of linear sRGB in [0, 1].
std::vector<double> flip(const std::vector<Rgb>& reference, const std::vector<Rgb>& test, int width, int height, double pixelsPerDegree);

}  // namespace overcast::reference
