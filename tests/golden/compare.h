// Compare: how far a picture is from its golden one, and a picture of where.
#pragma once

#include <string>

#include "formats/image.h"

namespace overcast {

/// What a picture may differ from its golden by. Values are display-encoded, in [0, 1].
struct Tolerance {
  double rmse = 0.0;   ///< root mean square over all pixels and channels, at most
  double off = 0.0;    ///< a pixel is off when one of its channels differs by more than this
  double share = 0.0;  ///< share of pixels that are off, at most
};

struct Difference {
  double rmse = 0.0;
  double max = 0.0;
  double share = 0.0;  ///< of pixels that are off
};

/// Differences over the channels R, G, B of two images of the same size. An Error when the sizes differ.
Result<Difference> compare(const Image& picture, const Image& golden, double off);

bool within(const Difference& difference, const Tolerance& tolerance);

/// "rmse 0.0012, max 0.031, 0.4 % of the pixels off by more than 0.02"
std::string describe(const Difference& difference, double off);

/// |picture - golden| eight times brighter, for looking at. Both of the same size.
Image differenceImage(const Image& picture, const Image& golden);

}  // namespace overcast
