// AsPrinted: what the published estimator makes of a picture when it is taken as its paper prints it (Evans 2006, 9.6; DESIGN 5.4):
// C = exp(-k sum f_i), at most 1. Ours of that name divides by what open ground gets and eases into the clamp (passes/shade/shade.h), which
// changes what it makes of the same taps: this tells how much, with the k that is best for each scene, which is generous.
#pragma once

#include <vector>

#include "formats/image.h"
#include "runtime/metrics.h"

namespace overcast {

inline constexpr const char* kAsPrinted = "as printed";  ///< ReportRow::technique

/// sum f_i / sum d_i of each pixel from the sky visibility that `published` with this k > 0 and alpha made of it; 0 where that is less.
Image missingShare(const Image& sky, float k, float alpha);

/// exp(-darkening * what is missing), channel sky.
Image asPrinted(const Image& missing, double darkening);

/// The darkening of the least square error over all pictures: `missing[i]` against `references[i]` (channel sky) where `masks[i]` is not 0.
double bestDarkening(const std::vector<Image>& missing, const std::vector<const Image*>& references, const std::vector<const Mask*>& masks);

}  // namespace overcast
