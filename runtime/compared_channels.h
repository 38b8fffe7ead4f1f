// Compared channels: where the values of a Comparison are, once it is known that it can be made. For metrics.cpp and flip.cpp.
#pragma once

#include <vector>

#include "runtime/metrics.h"

namespace overcast {

/// Of each compared channel its index within a pixel of either image.
struct ComparedChannels {
  std::vector<std::size_t> inPicture;
  std::vector<std::size_t> inReference;
};

/// An Error as Comparison says. A mask of another size than the reference, or no channels at all, stops the program.
Result<ComparedChannels> comparedChannels(const Comparison& comparison);

/// `channel` counts through comparison.channels.
inline float pictureValue(const ComparedChannels& compared, const Comparison& comparison, std::size_t pixel, std::size_t channel) {
  return comparison.picture.pixels[pixel * comparison.picture.channels.size() + compared.inPicture[channel]];
}
inline float referenceValue(const ComparedChannels& compared, const Comparison& comparison, std::size_t pixel, std::size_t channel) {
  return comparison.reference.pixels[pixel * comparison.reference.channels.size() + compared.inReference[channel]];
}

}  // namespace overcast
