// Images: float pixels in memory; OpenEXR for data, 8-bit PNG for looking.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/result.h"

namespace overcast {

/// Pixels, row 0 at the top, channels interleaved: pixels[(y * width + x) * channels.size() + c]. Linear values.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::string> channels;  ///< EXR channel names in storage order, e.g. {"R", "G", "B", "sky"}
  std::vector<float> pixels;
};

inline constexpr int kMaxImageSide = 16384;  ///< larger images are refused before anything is allocated
inline constexpr int kMaxImageChannels = 64;

float& at(Image& image, int x, int y, int channel);
float at(const Image& image, int x, int y, int channel);
/// Index of a channel by name, or -1.
int channelIndex(const Image& image, const std::string& name);

enum class ExrBits { half, single };

/// Writes a scan-line EXR (ZIP). Deterministic bytes; atomic. Finite values beyond the range of half floats are clamped to +-65504. `image`
/// is whole: sides within 1 .. kMaxImageSide, channel names distinct and not empty, as many pixels as these say.
Result<Done> writeExr(const std::filesystem::path& path, const Image& image, ExrBits bits = ExrBits::half);
/// Reads the data window of a flat scan-line or tiled EXR (of mipmaps the finest level), all channels as float, channels in the file's
/// (alphabetical) order. Parsed in a sandbox. An Error for files of several parts, deep or subsampled pixels, more than kMaxImageChannels
/// channels, sides beyond kMaxImageSide, and files that are cut short.
Result<Image> readExr(const std::filesystem::path& path);

/// Writes 8-bit RGB or RGBA from values already display-encoded in [0, 1] (rounded to nearest, clamped). 3 or 4 channels. Deterministic;
/// atomic.
Result<Done> writePng(const std::filesystem::path& path, const Image& image);
/// Reads an 8-bit PNG as display-encoded (sRGB) values k / 255, channels R G B or R G B A (grey and palettes are widened). Parsed in a
/// sandbox. An Error for 16-bit files, sides beyond kMaxImageSide, and files that are cut short.
Result<Image> readPng(const std::filesystem::path& path);

}  // namespace overcast
