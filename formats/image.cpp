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

std::vector<std::byte> packed(const Image& image) {
  std::vector<std::byte> bytes;
  bytes.reserve(image.pixels.size() * sizeof(float) + 4096);
  pack(bytes, image.width);
  pack(bytes, image.height);
  pack(bytes, static_cast<std::uint32_t>(image.channels.size()));
  for (const std::string& name : image.channels) packText(bytes, name);
  packAll(bytes, std::span<const float>(image.pixels));
  return bytes;
}

Result<Image> unpacked(std::span<const std::byte> bytes, const std::string& file) {
  Unpacker from(bytes);
  Image image;
  image.width = from.one<int>();
  image.height = from.one<int>();
  const auto channels = std::min(from.one<std::uint32_t>(), static_cast<std::uint32_t>(kMaxImageChannels) + 1);
  for (std::uint32_t c = 0; c < channels; ++c) image.channels.push_back(from.text());
  image.pixels = from.all<float>();
  // A corrupt child may hand over anything: what it promised is checked again.
  if (!from.atEnd() || !isWhole(image)) return Error{file, "", "its reader returned something that is not an image"};
  return image;
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

Result<Image> parseImage(const std::filesystem::path& path, ImageParser parser) {
  const std::string file = path.string();
  const auto result = runSandboxed(path, {}, [&]() -> Result<std::vector<std::byte>> {
    const auto bytes = readFile(path, kMaxImageFileBytes);
    if (!bytes) return bytes.error();
    const auto image = parser(bytes.value(), file);
    if (!image) return image.error();
    return packed(image.value());
  });
  if (!result) return result.error();
  return unpacked(result.value(), file);
}

}  // namespace overcast
