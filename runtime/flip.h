// FLIP: how different two pictures look to someone who flips between them (P. Andersson, J. Nilsson, T. Akenine-Moller, M. Oskarsson,
// K. Astrom, M. Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG 2020), for pictures in display range.
#pragma once

#include <vector>

#include "runtime/metrics.h"

namespace overcast {

/// Pixels per degree of visual angle: a monitor 0.7 m wide with 3840 pixels, seen from 0.7 m (section 6 of the paper, and its program).
inline constexpr double kFlipPixelsPerDegree = 3840.0 * 3.14159265358979323846 / 180.0;

struct FlipMap {
  std::vector<float> errors;  ///< per pixel, [0, 1]; 0 where it does not count
  double mean = 0.0;          ///< over the pixels that count
};

/// `comparison` names one channel, shown as grey, or three, taken as R, G, B; linear with the primaries of sRGB, clamped to [0, 1]: whoever
/// compares radiance exposes it first. Where a pixel does not count, both pictures are taken to show the reference (0 where that is not
/// finite), so that a background that differs does not reach the pixels next to it through the eye's blur.
/// `pixelsPerDegree` within 1 and 1000. Takes about half a second for a picture of 960 x 540.
Result<FlipMap> flip(const Comparison& comparison, double pixelsPerDegree = kFlipPixelsPerDegree);

/// The map as a grey picture for writePng, `width` pixels wide: black where nothing differs, white where the error is 1.
Image flipPicture(const FlipMap& map, int width);

}  // namespace overcast
