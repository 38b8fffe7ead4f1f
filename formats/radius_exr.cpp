#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Imath/half.h>

#include "formats/files.h"
#include "formats/image_mipmaps.h"
#include "formats/radius.h"
#include "formats/shared/cube_map.h"

namespace overcast {
namespace {

constexpr const char* kVersionKey = "overcast_version";
constexpr const char* kOffsetKey = "overcast_offset";
constexpr const char* kScaleKey = "overcast_scale";
constexpr std::array<const char*, 3> kCentreKeys{"overcast_centre_x", "overcast_centre_y", "overcast_centre_z"};
constexpr const char* kRadiusChannel = "radius";
constexpr const char* kVarianceChannel = "variance";

/// How radii become half floats: r = offset + scale * stored.
struct Scaling {
  double offset = 0.0;
  double scale = 0.0;

  float storedMean(float mean) const { return Imath::half(static_cast<float>((mean - offset) / scale)); }
  float storedVariance(float variance) const {
    constexpr double kLargestHalf = 65504.0;
    return Imath::half(static_cast<float>(std::min(variance / scale / scale, kLargestHalf)));
  }
  float mean(float stored) const { return static_cast<float>(offset + scale * stored); }
  float variance(float stored) const { return static_cast<float>(stored * scale * scale); }
};

Scaling scalingOf(const RadiusField& field) {
  constexpr double kLeast = 1e-4;  // of the radius: rounding of a sphere must not be blown up to the whole range
  double low = 1e300, high = 0.0;
  for (const RadiusLevel& level : field.levels)
    for (const RadiusTexel& texel : level.texel) {
      low = std::min(low, double{texel.mean});
      high = std::max(high, double{texel.mean});
    }
  const double offset = 0.5 * (low + high);
  return {offset, std::max(0.5 * (high - low), kLeast * offset)};
}

Image levelImage(const RadiusLevel& level, const Scaling& scaling) {
  Image image{level.side, 6 * level.side, {kRadiusChannel, kVarianceChannel}, {}};
  for (const glm::dvec3& direction : cubePixelDirections(level.side)) {
    const RadiusTexel& texel = level.texel[texelTowards(level.side, direction)];
    image.pixels.push_back(scaling.storedMean(texel.mean));
    image.pixels.push_back(scaling.storedVariance(texel.variance));
  }
  return image;
}

/// Levels below two texels a side exist in the file only because OpenEXR goes on to one pixel: the coarsest level's mean over all.
Image flatImage(int width, int height, const Image& coarsest) {
  std::array<double, 2> sum{};
  for (std::size_t i = 0; i < coarsest.pixels.size(); ++i) sum[i % 2] += coarsest.pixels[i];
  Image image{width, height, coarsest.channels, {}};
  const double pixels = static_cast<double>(coarsest.pixels.size()) / 2.0;
  for (int i = 0; i < width * height; ++i)
    for (const double total : sum) image.pixels.push_back(static_cast<float>(total / pixels));
  return image;
}

/// Texels of a level from the pixels of a cube map. Where several pixels stand for one shared texel the first counts.
RadiusLevel levelOf(const Image& image, const Scaling& scaling) {
  RadiusLevel level;
  level.side = image.width;
  level.texel.resize(texelCount(level.side));
  std::vector<char> known(level.texel.size());
  const std::vector<glm::dvec3> directions = cubePixelDirections(level.side);
  const auto radius = static_cast<std::size_t>(channelIndex(image, kRadiusChannel));
  const auto variance = static_cast<std::size_t>(channelIndex(image, kVarianceChannel));
  for (std::size_t pixel = 0; pixel < directions.size(); ++pixel) {
    const std::size_t at = texelTowards(level.side, directions[pixel]);
    if (known[at]) continue;
    known[at] = 1;
    const float* values = image.pixels.data() + pixel * image.channels.size();
    level.texel[at].mean = scaling.mean(values[radius]);
    level.texel[at].variance = scaling.variance(values[variance]);
  }
  for (unsigned face = 0; face < shared::kCubeFaces; ++face)
    for (int j = 0; j < level.side; ++j)
      for (int i = 0; i < level.side; ++i)
        level.texel[texelIndex(level.side, face, i, j)] = level.texel[texelTowards(level.side, texelDirection(level.side, face, i, j))];
  return level;
}

/// Reads the numbers; nothing when one is missing or not finite.
std::optional<Scaling> takeNumbers(const MipmappedImage& image, RadiusField& field) {
  const auto number = [&](const char* key) {
    const auto found = image.numbers.find(key);
    return found == image.numbers.end() ? std::nan("") : found->second;
  };
  for (int axis = 0; axis < 3; ++axis) field.centre[axis] = number(kCentreKeys[static_cast<std::size_t>(axis)]);
  const Scaling scaling{number(kOffsetKey), number(kScaleKey)};
  const double all = field.centre.x + field.centre.y + field.centre.z + scaling.offset + scaling.scale;
  if (!std::isfinite(all) || !std::isfinite(number(kVersionKey)) || !(scaling.scale > 0.0)) return std::nullopt;
  return scaling;
}

Result<Done> check(const MipmappedImage& image, const std::string& file) {
  const auto version = image.numbers.find(kVersionKey);
  if (version != image.numbers.end() && version->second > kRadiusVersion)
    return Error{file, kVersionKey, fmt::format("is {}, this program reads up to {}", version->second, kRadiusVersion)};
  const Image& finest = image.levels.front();
  const int side = finest.width;
  if (!image.cube || finest.height != 6 * side) return Error{file, "envmap", "is not a cube map with six faces one above another"};
  if (side < kSmallestRadiusSide || side > kLargestRadiusSide || (side & (side - 1)) != 0)
    return Error{file, "dataWindow",
                 fmt::format("a face has {} texels a side, not a power of two in {} to {}", side, kSmallestRadiusSide, kLargestRadiusSide)};
  for (const char* channel : {kRadiusChannel, kVarianceChannel})
    if (channelIndex(finest, channel) < 0) return Error{file, "channels", fmt::format("has no channel '{}'", channel)};
  return Done{};
}

/// Every mean positive, every variance not negative, all finite.
bool inRange(const RadiusLevel& level) {
  return std::all_of(level.texel.begin(), level.texel.end(), [](const RadiusTexel& t) {
    return std::isfinite(t.mean) && t.mean > 0.0f && std::isfinite(t.variance) && t.variance >= 0.0f;
  });
}

}  // namespace

RadiusField asStored(RadiusField field) {
  const Scaling scaling = scalingOf(field);
  for (RadiusLevel& level : field.levels)
    for (RadiusTexel& texel : level.texel) {
      texel.mean = scaling.mean(scaling.storedMean(texel.mean));
      texel.variance = scaling.variance(scaling.storedVariance(texel.variance));
    }
  derive(field);
  return field;
}

std::vector<std::byte> encodeRadius(const RadiusField& field) {
  OVERCAST_REQUIRE(isWhole(field), "a radius field of {} levels is not whole", field.levels.size());
  const Scaling scaling = scalingOf(field);
  MipmappedImage image;
  image.cube = true;
  image.numbers = {{kVersionKey, kRadiusVersion}, {kOffsetKey, scaling.offset}, {kScaleKey, scaling.scale}};
  for (int axis = 0; axis < 3; ++axis) image.numbers[kCentreKeys[static_cast<std::size_t>(axis)]] = field.centre[axis];
  for (const RadiusLevel& level : field.levels) image.levels.push_back(levelImage(level, scaling));
  const int side = field.levels.front().side;
  for (int l = static_cast<int>(field.levels.size()); l < mipmapLevels(side, 6 * side); ++l)
    image.levels.push_back(flatImage(std::max(1, side >> l), std::max(1, (6 * side) >> l), image.levels[field.levels.size() - 1]));
  return encodeMipmaps(image);
}

Result<std::uint64_t> writeRadius(const std::filesystem::path& path, const RadiusField& field) {
  const std::vector<std::byte> bytes = encodeRadius(field);
  if (const auto written = writeFileAtomically(path, bytes); !written) return written.error();
  return bytes.size();
}

Result<RadiusField> readRadius(const std::filesystem::path& path) {
  const std::string file = path.string();
  const Result<MipmappedImage> read = readMipmaps(path);
  if (!read) return read.error();
  const MipmappedImage& image = read.value();
  if (const auto checked = check(image, file); !checked) return checked.error();
  RadiusField field;
  const std::optional<Scaling> scaling = takeNumbers(image, field);
  if (!scaling) return Error{file, "", "has no version, centre, offset or scale, or one that is not finite"};
  for (std::size_t l = 0; image.levels[l].width >= 2; ++l) {
    field.levels.push_back(levelOf(image.levels[l], *scaling));
    if (!inRange(field.levels.back()))
      return Error{file, fmt::format("level {}", l), "has a radius that is not positive or a variance that is not finite"};
  }
  derive(field);
  if (!isWhole(field)) return Error{file, "", fmt::format("its radii differ by more than a factor of {}", kLargestRadiusRatio)};
  return field;
}

}  // namespace overcast
