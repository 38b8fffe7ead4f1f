#include <algorithm>
#include <array>
#include <cmath>

#include <png.h>

#include "formats/files.h"
#include "formats/image_parse.h"

namespace overcast {
namespace {

/// NaN becomes 0.
std::uint8_t quantised(float value) {
  return value > 0.0f ? static_cast<std::uint8_t>(std::lround(std::min(value, 1.0f) * 255.0f)) : 0;
}

/// libpng's simplified interface: no callbacks, no longjmp through our frames. The control structure frees itself on every way out.
struct PngImage {
  png_image control{};
  PngImage() { control.version = PNG_IMAGE_VERSION; }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
  ~PngImage() { png_image_free(&control); }
};

}  // namespace

Result<Image> parsePng(std::span<const std::byte> bytes, const std::string& file) {
  PngImage png;
  if (png_image_begin_read_from_memory(&png.control, bytes.data(), bytes.size()) == 0)
    return Error{file, "", fmt::format("not a readable PNG file ({})", png.control.message)};
  if ((png.control.format & PNG_FORMAT_FLAG_LINEAR) != 0) return Error{file, "", "has 16 bits per channel, only 8 are read"};
  if (!sidesFit(png.control.width, png.control.height))
    return Error{file, "",
                 fmt::format("is {} x {} pixels, at most {} per side are read", png.control.width, png.control.height, kMaxImageSide)};
  Image image;
  image.width = static_cast<int>(png.control.width);
  image.height = static_cast<int>(png.control.height);
  const bool alpha = (png.control.format & PNG_FORMAT_FLAG_ALPHA) != 0;
  image.channels = {"R", "G", "B"};
  if (alpha) image.channels.push_back("A");
  png.control.format = alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  const std::uint64_t floats = std::uint64_t{PNG_IMAGE_SIZE(png.control)} * sizeof(float);
  if (floats > kMaxImageBytes) return Error{file, "", fmt::format("its pixels would take {} bytes", floats)};
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(png.control));
  if (png_image_finish_read(&png.control, nullptr, pixels.data(), 0, nullptr) == 0)
    return Error{file, "", fmt::format("not a readable PNG file ({})", png.control.message)};
  image.pixels.resize(pixels.size());
  std::transform(pixels.begin(), pixels.end(), image.pixels.begin(), [](std::uint8_t k) { return static_cast<float>(k) / 255.0f; });
  return image;
}

Result<Done> writePng(const std::filesystem::path& path, const Image& image) {
  const std::size_t channels = image.channels.size();
  OVERCAST_REQUIRE(isWhole(image) && (channels == 3 || channels == 4), "an image of {} x {} with {} channels and {} values cannot be a PNG",
                   image.width, image.height, channels, image.pixels.size());
  PngImage png;
  png.control.width = static_cast<png_uint_32>(image.width);
  png.control.height = static_cast<png_uint_32>(image.height);
  png.control.format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(image.pixels.size());
  std::transform(image.pixels.begin(), image.pixels.end(), pixels.begin(), quantised);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png.control);
  std::vector<std::byte> bytes(size);
  if (png_image_write_to_memory(&png.control, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
    return Error{path.string(), "", fmt::format("cannot be encoded as PNG ({})", png.control.message)};
  bytes.resize(size);
  return writeFileAtomically(path, bytes);
}

Result<Image> readPng(const std::filesystem::path& path) {
  return parseImage(path, parsePng);
}

}  // namespace overcast
