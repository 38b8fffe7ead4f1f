// What the image readers and writers share: checks of sizes, the parsers, and the way through the sandbox. Internal to formats and its
// fuzzers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/image_mipmaps.h"
#include "formats/packing.h"

namespace overcast {

inline constexpr std::uint64_t kMaxImageFileBytes = std::uint64_t{1} << 30;  ///< larger image files are refused unread
inline constexpr std::uint64_t kMaxImageBytes = std::uint64_t{512}
                                                << 20;  ///< larger images as float pixels are refused before they are allocated

bool sidesFit(std::int64_t width, std::int64_t height);  ///< both within 1 .. kMaxImageSide

/// Sides fit, 1 .. kMaxImageChannels channels with distinct names that are not empty, and as many pixels as these say.
bool isWhole(const Image& image);

/// At least one level, each as mipmapLevels and MipmappedImage say.
bool isWhole(const MipmappedImage& image);

/// Turns the bytes of `file` into an image; runs in the sandbox.
using ImageParser = Result<Image> (*)(std::span<const std::byte> bytes, const std::string& file);

Result<Image> parsePng(std::span<const std::byte> bytes, const std::string& file);
Result<Image> parseExr(std::span<const std::byte> bytes, const std::string& file);

Result<MipmappedImage> parseMipmaps(std::span<const std::byte> bytes, const std::string& file);

/// An image as bytes for the way out of the sandbox, and back; `image` is not checked.
void packImage(std::vector<std::byte>& bytes, const Image& image);
Image unpackImage(Unpacker& from);

/// Reads `path` and runs `parser` on its bytes in a sandbox.
Result<Image> parseImage(const std::filesystem::path& path, ImageParser parser);

}  // namespace overcast
