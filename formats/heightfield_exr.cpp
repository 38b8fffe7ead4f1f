#include <algorithm>
#include <array>

#include "formats/files.h"
#include "formats/heightfield.h"
#include "formats/image_mipmaps.h"

namespace overcast {
namespace {

constexpr std::array kFrontChannels = {"front.mean", "front.variance"};
constexpr std::array kBackChannels = {"back.mean", "back.variance"};
constexpr const char* kVersionKey = "overcast_version";
constexpr std::array kAxisKeys = {"overcast_axisX", "overcast_axisY", "overcast_axisZ"};
constexpr const char* kOriginKey = "overcast_origin";
constexpr const char* kExtentKey = "overcast_halfExtent";
constexpr std::array kComponents = {".x", ".y", ".z"};

Error refused(const std::filesystem::path& path, std::string place, std::string reason) {
  return Error{path.string(), std::move(place), std::move(reason)};
}

void putVector(MipmappedImage& image, const std::string& key, const glm::dvec3& value) {
  for (std::size_t axis = 0; axis < 3; ++axis) image.numbers[key + kComponents[axis]] = value[static_cast<int>(axis)];
}

glm::dvec3 takeVector(const MipmappedImage& image, const std::string& key) {
  return {image.numbers.at(key + kComponents[0]), image.numbers.at(key + kComponents[1]), image.numbers.at(key + kComponents[2])};
}

void put(MipmappedImage& image, const HeightLevels& layer, const std::array<const char*, 2>& names) {
  const auto mean = static_cast<std::size_t>(channelIndex(image.levels[0], names[0]));
  const auto variance = static_cast<std::size_t>(channelIndex(image.levels[0], names[1]));
  for (std::size_t l = 0; l < layer.size(); ++l)
    for (std::size_t n = 0; n < layer[l].size(); ++n) {
      const std::size_t first = n * image.levels[l].channels.size();
      image.levels[l].pixels[first + mean] = layer[l][n].mean;
      image.levels[l].pixels[first + variance] = layer[l][n].variance;
    }
}

HeightLevels take(const MipmappedImage& image, const std::array<const char*, 2>& names) {
  const auto mean = static_cast<std::size_t>(channelIndex(image.levels[0], names[0]));
  const auto variance = static_cast<std::size_t>(channelIndex(image.levels[0], names[1]));
  HeightLevels layer;
  for (const Image& level : image.levels) {
    std::vector<HeightTexel>& texels = layer.emplace_back();
    for (std::size_t first = 0; first < level.pixels.size(); first += level.channels.size())
      texels.push_back({level.pixels[first + mean], level.pixels[first + variance]});
  }
  return layer;
}

bool has(const MipmappedImage& image, const std::array<const char*, 2>& names) {
  return channelIndex(image.levels[0], names[0]) >= 0 && channelIndex(image.levels[0], names[1]) >= 0;
}

Result<Done> check(const MipmappedImage& image, const std::filesystem::path& path) {
  const auto version = image.numbers.find(kVersionKey);
  if (version == image.numbers.end()) return refused(path, kVersionKey, "is missing, this is no heightfield");
  if (!(version->second >= 1.0 && version->second <= kHeightFieldVersion))
    return refused(path, kVersionKey, fmt::format("is {}, this program reads 1 to {}", version->second, kHeightFieldVersion));
  for (const char* key : {kAxisKeys[0], kAxisKeys[1], kAxisKeys[2], kOriginKey, kExtentKey})
    for (const char* component : kComponents)
      if (!image.numbers.contains(std::string(key) + component)) return refused(path, fmt::format("{}{}", key, component), "is missing");
  if (!has(image, kFrontChannels)) return refused(path, "channels", "front.mean or front.variance is missing");
  const Image& finest = image.levels[0];
  if (std::max(finest.width, finest.height) > kMaxHeightFieldSide)
    return refused(path, "dataWindow",
                   fmt::format("is {} x {} texels, at most {} per side are read", finest.width, finest.height, kMaxHeightFieldSide));
  return Done{};
}

}  // namespace

std::vector<std::byte> encodeHeightField(const HeightField& field) {
  OVERCAST_REQUIRE(isWhole(field), "a heightfield of {} x {} texels is not whole", field.size.x, field.size.y);
  MipmappedImage image;
  image.numbers[kVersionKey] = kHeightFieldVersion;
  for (std::size_t axis = 0; axis < 3; ++axis) putVector(image, kAxisKeys[axis], field.localFromField[static_cast<int>(axis)]);
  putVector(image, kOriginKey, field.origin);
  putVector(image, kExtentKey, field.halfExtent);
  std::vector<std::string> channels;
  if (!field.back.empty()) channels.assign(kBackChannels.begin(), kBackChannels.end());
  channels.insert(channels.end(), kFrontChannels.begin(), kFrontChannels.end());
  for (int level = 0; level < levelCount(field); ++level) {
    const glm::ivec2 size = levelSize(field, level);
    const std::size_t values = field.front[static_cast<std::size_t>(level)].size() * channels.size();
    image.levels.push_back({size.x, size.y, channels, std::vector<float>(values)});
  }
  put(image, field.front, kFrontChannels);
  if (!field.back.empty()) put(image, field.back, kBackChannels);
  return encodeMipmaps(image);
}

Result<std::uint64_t> writeHeightField(const std::filesystem::path& path, const HeightField& field) {
  const std::vector<std::byte> bytes = encodeHeightField(field);
  if (const auto written = writeFileAtomically(path, bytes); !written) return written.error();
  return bytes.size();
}

Result<HeightField> readHeightField(const std::filesystem::path& path) {
  const Result<MipmappedImage> read = readMipmaps(path);
  if (!read) return read.error();
  const MipmappedImage& image = read.value();
  if (const auto checked = check(image, path); !checked) return checked.error();
  HeightField field;
  for (std::size_t axis = 0; axis < 3; ++axis) field.localFromField[static_cast<int>(axis)] = takeVector(image, kAxisKeys[axis]);
  field.origin = takeVector(image, kOriginKey);
  field.halfExtent = takeVector(image, kExtentKey);
  field.size = {image.levels[0].width, image.levels[0].height};
  field.front = take(image, kFrontChannels);
  if (has(image, kBackChannels)) field.back = take(image, kBackChannels);
  if (!isWhole(field)) return refused(path, "", "a size, axis or texel is out of range for a heightfield");
  return field;
}

}  // namespace overcast
