#include "formats/image.h"

#include <algorithm>

#include "formats/files.h"
#include "formats/image_parse.h"
#include "formats/packing.h"
#include "formats/sandbox.h"

namespace overcast {
namespace {

std::size_t pixelIndex(const Image& image, int x, int y, int channel) {
  return (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)) * image.channels.size() +
         static_cast<std::size_t>(channel);
}

}  // namespace

float& at(Image& image, int x, int y, int channel) {
  return image.pixels[pixelIndex(image, x, y, channel)];
}
float at(const Image& image, int x, int y, int channel) {
  return image.pixels[pixelIndex(image, x, y, channel)];
}

int channelIndex(const Image& image, const std::string& name) {
  const auto found = std::find(image.channels.begin(), image.channels.end(), name);
  return found == image.channels.end() ? -1 : static_cast<int>(found - image.channels.begin());
}

bool sidesFit(std::int64_t width, std::int64_t height) {
  return width >= 1 && height >= 1 && width <= kMaxImageSide && height <= kMaxImageSide;
}

bool isWhole(const Image& image) {
  std::vector<std::string> names = image.channels;
  std::sort(names.begin(), names.end());
  const bool distinct = std::adjacent_find(names.begin(), names.end()) == names.end();
  return sidesFit(image.width, image.height) && distinct && !names.empty() && !names.front().empty() &&
         names.size() <= static_cast<std::size_t>(kMaxImageChannels) && image.pixels.size() == pixelIndex(image, 0, image.height, 0);
}

bool isWhole(const MipmappedImage& image) {
  if (image.levels.empty() || !isWhole(image.levels.front())) return false;
  const Image& finest = image.levels.front();
  if (image.levels.size() != static_cast<std::size_t>(mipmapLevels(finest.width, finest.height))) return false;
  for (std::size_t l = 0; l < image.levels.size(); ++l) {
    const Image& level = image.levels[l];
    if (!isWhole(level) || level.channels != finest.channels || level.width != std::max(1, finest.width >> l) ||
        level.height != std::max(1, finest.height >> l))
      return false;
  }
  return true;
}

int mipmapLevels(int width, int height) {
  int levels = 1;
  for (int side = std::max(width, height); side > 1; side >>= 1) ++levels;
  return levels;
}

void packImage(std::vector<std::byte>& bytes, const Image& image) {
  pack(bytes, image.width);
  pack(bytes, image.height);
  pack(bytes, static_cast<std::uint32_t>(image.channels.size()));
  for (const std::string& name : image.channels) packText(bytes, name);
  packAll(bytes, std::span<const float>(image.pixels));
}

Image unpackImage(Unpacker& from) {
  Image image;
  image.width = from.one<int>();
  image.height = from.one<int>();
  const auto channels = std::min(from.one<std::uint32_t>(), static_cast<std::uint32_t>(kMaxImageChannels) + 1);
  for (std::uint32_t c = 0; c < channels; ++c) image.channels.push_back(from.text());
  image.pixels = from.all<float>();
  return image;
}

Result<Image> parseImage(const std::filesystem::path& path, ImageParser parser) {
  const std::string file = path.string();
  const auto result = runSandboxed(path, {}, [&]() -> Result<std::vector<std::byte>> {
    const auto bytes = readFile(path, kMaxImageFileBytes);
    if (!bytes) return bytes.error();
    const auto image = parser(bytes.value(), file);
    if (!image) return image.error();
    std::vector<std::byte> packed;
    packed.reserve(image.value().pixels.size() * sizeof(float) + 4096);
    packImage(packed, image.value());
    return packed;
  });
  if (!result) return result.error();
  Unpacker from(result.value());
  Image image = unpackImage(from);
  // A corrupt child may hand over anything: what it promised is checked again.
  if (!from.atEnd() || !isWhole(image)) return Error{file, "", "its reader returned something that is not an image"};
  return image;
}

Result<MipmappedImage> readMipmaps(const std::filesystem::path& path) {
  const std::string file = path.string();
  const auto result = runSandboxed(path, {}, [&]() -> Result<std::vector<std::byte>> {
    const auto bytes = readFile(path, kMaxImageFileBytes);
    if (!bytes) return bytes.error();
    const auto image = parseMipmaps(bytes.value(), file);
    if (!image) return image.error();
    std::vector<std::byte> packed;
    packed.reserve(2 * image.value().levels.front().pixels.size() * sizeof(float) + 4096);
    pack(packed, static_cast<std::uint32_t>(image.value().levels.size()));
    for (const Image& level : image.value().levels) packImage(packed, level);
    pack(packed, static_cast<char>(image.value().cube));
    pack(packed, static_cast<std::uint32_t>(image.value().numbers.size()));
    for (const auto& [name, number] : image.value().numbers) {
      packText(packed, name);
      pack(packed, number);
    }
    return packed;
  });
  if (!result) return result.error();
  Unpacker from(result.value());
  MipmappedImage image;
  for (auto levels = from.one<std::uint32_t>(); levels > 0 && from.good(); --levels) image.levels.push_back(unpackImage(from));
  image.cube = from.one<char>() != 0;
  for (auto numbers = from.one<std::uint32_t>(); numbers > 0 && from.good(); --numbers) {
    const std::string name = from.text();
    image.numbers[name] = from.one<double>();
  }
  if (!from.atEnd() || !isWhole(image)) return Error{file, "", "its reader returned something that is not a mipmapped image"};
  return image;
}

}  // namespace overcast
