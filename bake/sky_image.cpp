#include "bake/sky_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>

#include "formats/files.h"
#include "formats/image_mipmaps.h"
#include "formats/radius.h"
#include "formats/shared/cube_map.h"
#include "formats/sky.h"

namespace overcast {

namespace {

constexpr double kPi = std::numbers::pi;

bool isCube(const SkyImage& sky) {
  return sky.height == 6 * sky.width;
}

/// Gives texels on the edges of a cube what the one has that stands for all of the place.
void shareEdges(SkyImage& sky) {
  for (unsigned face = 0; face < shared::kCubeFaces; ++face)
    for (int j = 0; j < sky.width; ++j)
      for (int i = 0; i < sky.width; ++i)
        sky.radiance[texelIndex(sky.width, face, i, j)] = sky.radiance[texelTowards(sky.width, texelDirection(sky.width, face, i, j))];
}

}  // namespace

Result<SkyImage> makeSkyImage(const Image& image) {
  const auto harmonics = skyHarmonics(image);
  if (!harmonics) return harmonics.error();
  const std::array<int, 3> channels = radianceChannels(image);
  SkyImage sky{image.width, image.height, {}, meanRadiance(harmonics.value()), ""};
  const std::vector<glm::dvec3> directions = isCube(sky) ? cubePixelDirections(image.width) : std::vector<glm::dvec3>();
  sky.radiance.resize(isCube(sky) ? texelCount(image.width)
                                  : static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x);
      const glm::vec3 read(at(image, x, y, channels[0]), at(image, x, y, channels[1]), at(image, x, y, channels[2]));
      sky.radiance[isCube(sky) ? texelTowards(image.width, directions[pixel]) : pixel] =
          glm::clamp(read, 0.0f, static_cast<float>(kBrightestSky));
    }
  }
  if (isCube(sky)) shareEdges(sky);
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
  if (isCube(sky)) return glm::dvec3(sky.radiance[texelTowards(sky.width, direction)]);
  const double longitude = std::atan2(direction.x, direction.z), fromTop = std::acos(std::clamp(direction.y, -1.0, 1.0));
  const int x = static_cast<int>((0.5 - longitude / (2.0 * kPi)) * sky.width), y = static_cast<int>(fromTop / kPi * sky.height);
  const auto column = static_cast<std::size_t>(std::clamp(x, 0, sky.width - 1)),
             row = static_cast<std::size_t>(std::clamp(y, 0, sky.height - 1));
  return glm::dvec3(sky.radiance[row * static_cast<std::size_t>(sky.width) + column]);
}

}  // namespace overcast
