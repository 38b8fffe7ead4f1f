#include "runtime/compared_channels.h"

#include <algorithm>
#include <cmath>

namespace overcast {
namespace {

Result<std::vector<std::size_t>> indices(const Image& image, const char* which, std::span<const std::string> channels) {
  std::vector<std::size_t> found;
  for (const std::string& channel : channels) {
    const int index = channelIndex(image, channel);
    if (index < 0) return Error{"", "", fmt::format("the {} has no channel {}", which, channel)};
    found.push_back(static_cast<std::size_t>(index));
  }
  return found;
}

Result<Done> checkFinite(const Image& image, const char* which, const std::vector<std::size_t>& channels, const Mask& mask) {
  for (std::size_t pixel = 0; pixel < mask.size(); ++pixel) {
    if (!mask[pixel]) continue;
    for (const std::size_t channel : channels)
      if (!std::isfinite(image.pixels[pixel * image.channels.size() + channel]))
        return Error{"", "",
                     fmt::format("the {} is not finite at pixel ({}, {}), channel {}", which, pixel % static_cast<std::size_t>(image.width),
                                 pixel / static_cast<std::size_t>(image.width), image.channels[channel])};
  }
  return Done{};
}

}  // namespace

Result<ComparedChannels> comparedChannels(const Comparison& comparison) {
  const Image &picture = comparison.picture, &reference = comparison.reference;
  const auto pixels = static_cast<std::size_t>(reference.width) * static_cast<std::size_t>(reference.height);
  OVERCAST_REQUIRE(comparison.mask.size() == pixels, "a mask of {} pixels for {}", comparison.mask.size(), pixels);
  OVERCAST_REQUIRE(!comparison.channels.empty(), "no channels to compare");
  if (picture.width != reference.width || picture.height != reference.height)
    return Error{
        "", "", fmt::format("the picture is {}x{}, the reference {}x{}", picture.width, picture.height, reference.width, reference.height)};
  auto inPicture = indices(picture, "picture", comparison.channels), inReference = indices(reference, "reference", comparison.channels);
  if (!inPicture) return inPicture.error();
  if (!inReference) return inReference.error();
  if (std::all_of(comparison.mask.begin(), comparison.mask.end(), [](std::uint8_t counts) { return counts == 0; }))
    return Error{"", "", "no pixel shows a surface"};
  if (const auto finite = checkFinite(picture, "picture", inPicture.value(), comparison.mask); !finite) return finite.error();
  if (const auto finite = checkFinite(reference, "reference", inReference.value(), comparison.mask); !finite) return finite.error();
  return ComparedChannels{std::move(inPicture).value(), std::move(inReference).value()};
}

}  // namespace overcast
