#include <algorithm>
#include <array>
#include <cmath>

#include <Imath/half.h>
#include <glm/geometric.hpp>

#include "formats/aperture_map.h"
#include "formats/files.h"
#include "formats/shared/aperture.h"

namespace overcast {
namespace {

constexpr const char* kVersionKey = "overcast_version";
constexpr const char* kUsableKey = "overcast_usable_levels";
/// In the order of OpenEXR, which is alphabetical.
constexpr std::array<const char*, 6> kChannels{"ambient", "coverage", "direction.X", "direction.Y", "direction.Z", "radius"};

float half(float value) {
  return Imath::half(value);
}

std::array<float, 6> numbersOf(const ApertureTexel& texel) {
  const glm::vec3& d = texel.aperture.direction;
  return {
      half(texel.ambient), half(texel.coverage), half(d.x), half(d.y), half(d.z), half(texel.aperture.radius / shared::kApertureWidest)};
}

/// Out of range (isWhole) where the numbers are.
ApertureTexel texelOf(const std::array<float, 6>& numbers) {
  const glm::dvec3 direction(double{numbers[2]}, double{numbers[3]}, double{numbers[4]});
  const double length = glm::length(direction);
  const bool usable = std::abs(length - 1.0) < 0.01;
  return {{usable ? glm::vec3(direction / length) : glm::vec3(0.0f), numbers[5] * shared::kApertureWidest}, numbers[0], numbers[1]};
}

Error refused(const std::string& file, std::string place, std::string reason) {
  return Error{file, std::move(place), std::move(reason)};
}

/// A whole number from `low` to `high` out of the header.
Result<int> integerOf(const MipmappedImage& image, const char* key, int low, int high, const std::string& file) {
  const auto found = image.numbers.find(key);
  if (found == image.numbers.end()) return refused(file, key, "is missing, this is no aperture map");
  if (!(found->second >= low && found->second <= high) || found->second != std::floor(found->second))
    return refused(file, key, fmt::format("is {}, this program reads {} to {}", found->second, low, high));
  return static_cast<int>(found->second);
}

}  // namespace

ApertureMap asStored(ApertureMap map) {
  for (std::vector<ApertureTexel>& level : map.levels)
    for (ApertureTexel& texel : level) texel = texelOf(numbersOf(texel));
  return map;
}

MipmappedImage imageOf(const ApertureMap& map) {
  OVERCAST_REQUIRE(isWhole(map), "an aperture map of {} x {} texels is not whole", map.size.x, map.size.y);
  MipmappedImage image;
  image.numbers[kVersionKey] = kApertureMapVersion;
  image.numbers[kUsableKey] = map.usableLevels;
  for (int l = 0; l < static_cast<int>(map.levels.size()); ++l) {
    const glm::ivec2 size = levelSize(map, l);
    Image& level = image.levels.emplace_back(Image{size.x, size.y, {kChannels.begin(), kChannels.end()}, {}});
    for (const ApertureTexel& texel : map.levels[static_cast<std::size_t>(l)]) {
      const std::array<float, 6> numbers = numbersOf(texel);
      level.pixels.insert(level.pixels.end(), numbers.begin(), numbers.end());
    }
  }
  return image;
}

Result<ApertureMap> apertureMapOf(const MipmappedImage& image, const std::string& file) {
  const Image& finest = image.levels.front();
  if (const auto version = integerOf(image, kVersionKey, 1, kApertureMapVersion, file); !version) return version.error();
  const auto usable = integerOf(image, kUsableKey, 1, static_cast<int>(image.levels.size()), file);
  if (!usable) return usable.error();
  std::array<std::size_t, 6> channel{};
  for (std::size_t c = 0; c < channel.size(); ++c) {
    const int index = channelIndex(finest, kChannels[c]);
    if (index < 0) return refused(file, "channels", fmt::format("{} is missing", kChannels[c]));
    channel[c] = static_cast<std::size_t>(index);
  }
  if (std::max(finest.width, finest.height) > kLargestApertureMapSide)
    return refused(file, "dataWindow",
                   fmt::format("is {} x {} texels, at most {} per side are read", finest.width, finest.height, kLargestApertureMapSide));
  ApertureMap map{{finest.width, finest.height}, {}, usable.value()};
  for (const Image& level : image.levels) {
    std::vector<ApertureTexel>& texels = map.levels.emplace_back();
    for (std::size_t first = 0; first < level.pixels.size(); first += level.channels.size()) {
      std::array<float, 6> numbers{};
      for (std::size_t c = 0; c < numbers.size(); ++c) numbers[c] = level.pixels[first + channel[c]];
      texels.push_back(texelOf(numbers));
    }
  }
  if (!isWhole(map)) return refused(file, "", "a direction, radius, ambient visibility or coverage is out of range");
  return map;
}

std::vector<std::byte> encodeApertureMap(const ApertureMap& map) {
  return encodeMipmaps(imageOf(map));
}

Result<std::uint64_t> writeApertureMap(const std::filesystem::path& path, const ApertureMap& map) {
  return writeMipmaps(path, imageOf(map));
}

Result<ApertureMap> readApertureMap(const std::filesystem::path& path) {
  const Result<MipmappedImage> image = readMipmaps(path);
  if (!image) return image.error();
  return apertureMapOf(image.value(), path.string());
}

Result<ApertureMap> readApertureMap(const std::filesystem::path& folder, const ApertureLink& link) {
  const Result<std::filesystem::path> path = checkedFile(folder, link.uri, link.contentHash);
  if (!path) return path.error();
  return readApertureMap(path.value());
}

}  // namespace overcast
