#include "bake/sky_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>

#include "formats/files.h"

namespace overcast {

constexpr double kPi = std::numbers::pi;

Result<SkyImage> makeSkyImage(const Image& image) {
  constexpr float kLargestHalf = 65504.0f;
  if (image.width != 2 * image.height) return Error{"", "", fmt::format("is {}x{}, not twice as wide as high", image.width, image.height)};
  std::array<int, 3> channels{channelIndex(image, "R"), channelIndex(image, "G"), channelIndex(image, "B")};
  if (*std::min_element(channels.begin(), channels.end()) < 0) channels.fill(channelIndex(image, "Y"));
  if (channels[0] < 0) return Error{"", "", "has neither channels R, G and B nor Y"};
  SkyImage sky{image.width, image.height, {}, glm::dvec3(0.0), ""};
  for (int y = 0; y < image.height; ++y) {
    // Share of all directions in one pixel of the row.
    const double share = 0.5 * (std::cos(kPi * y / image.height) - std::cos(kPi * (y + 1) / image.height)) / image.width;
    for (int x = 0; x < image.width; ++x) {
      const glm::vec3 read(at(image, x, y, channels[0]), at(image, x, y, channels[1]), at(image, x, y, channels[2]));
      if (std::isnan(read.x) || std::isnan(read.y) || std::isnan(read.z))
        return Error{"", fmt::format("pixel {}, {}", x, y), "is not a number"};
      sky.radiance.push_back(glm::clamp(read, 0.0f, kLargestHalf));
      sky.mean += share * glm::dvec3(sky.radiance.back());
    }
  }
  return sky;
}

Result<SkyImage> readSkyImage(const std::filesystem::path& path) {
  const auto image = readExr(path);
  if (!image) return image.error();
  auto sky = makeSkyImage(image.value());
  if (!sky) return Error{path.string(), sky.error().place, sky.error().reason};
  auto hash = fileHash(path);
  if (!hash) return hash.error();
  sky.value().hash = std::move(hash).value();
  return sky;
}

glm::dvec3 radianceFrom(const SkyImage& sky, const glm::dvec3& direction) {
  const double longitude = std::atan2(direction.x, direction.z), fromTop = std::acos(std::clamp(direction.y, -1.0, 1.0));
  const int x = static_cast<int>((0.5 - longitude / (2.0 * kPi)) * sky.width), y = static_cast<int>(fromTop / kPi * sky.height);
  const auto column = static_cast<std::size_t>(std::clamp(x, 0, sky.width - 1)),
             row = static_cast<std::size_t>(std::clamp(y, 0, sky.height - 1));
  return glm::dvec3(sky.radiance[row * static_cast<std::size_t>(sky.width) + column]);
}

}  // namespace overcast
