#include <algorithm>
#include <cmath>
#include <cstring>

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfEnvmap.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfTiledInputPart.h>
#include <ImfTiledOutputFile.h>

#include "formats/files.h"
#include "formats/image_mipmaps.h"
#include "formats/image_parse.h"

namespace overcast {
namespace {

constexpr float kLargestHalf = 65504.0f;

class MemoryOutput : public Imf::OStream {
 public:
  MemoryOutput() : Imf::OStream("memory") {}

  void write(const char data[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (bytes.size() < position_ + size) bytes.resize(position_ + size);
    std::memcpy(bytes.data() + position_, data, size);
    position_ += size;
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = position; }

  std::vector<std::byte> bytes;

 private:
  std::size_t position_ = 0;
};

class MemoryInput : public Imf::IStream {
 public:
  explicit MemoryInput(std::span<const std::byte> bytes) : Imf::IStream("memory"), bytes_(bytes) {}

  bool read(char data[], int count) override {
    const auto size = static_cast<std::size_t>(count);
    if (position_ > bytes_.size() || size > bytes_.size() - position_) throw Iex::InputExc("the file is cut short");
    std::memcpy(data, bytes_.data() + position_, size);
    position_ += size;
    return position_ < bytes_.size();
  }
  uint64_t tellg() override { return position_; }
  void seekg(uint64_t position) override { position_ = position; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t position_ = 0;
};

/// Finite values beyond the range are clamped: an infinity in a picture spreads over everything that filters it.
Imath::half toHalf(float value) {
  return Imath::half(std::isfinite(value) ? std::clamp(value, -kLargestHalf, kLargestHalf) : value);
}

/// A frame buffer over interleaved pixels of one type.
template <class T>
Imf::FrameBuffer frameOver(std::vector<T>& pixels, const std::vector<std::string>& channels, int width, Imf::PixelType type,
                           const Imath::Box2i& window) {
  Imf::FrameBuffer frame;
  const std::size_t across = sizeof(T) * channels.size();
  for (std::size_t c = 0; c < channels.size(); ++c)
    frame.insert(channels[c], Imf::Slice::Make(type, pixels.data() + c, window, across, across * static_cast<std::size_t>(width)));
  return frame;
}

template <class T>
std::vector<std::byte> encode(const Image& image, std::vector<T> pixels, Imf::PixelType type) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const std::string& name : image.channels) header.channels().insert(name, Imf::Channel(type));
  MemoryOutput output;
  {
    Imf::OutputFile file(output, header, 0);  // its destructor writes the table of offsets
    file.setFrameBuffer(frameOver(pixels, image.channels, image.width, type, header.dataWindow()));
    file.writePixels(image.height);
  }
  return std::move(output.bytes);
}

/// Sizes and kinds that are refused before any pixel is allocated.
Result<Done> check(const Imf::MultiPartInputFile& input, const std::string& file) {
  if (input.parts() != 1) return Error{file, "", fmt::format("has {} parts, only files of one part are read", input.parts())};
  const Imf::Header& header = input.header(0);
  if (header.hasType() && !Imf::isImage(header.type()))
    return Error{file, "", fmt::format("is of type {}, only flat images are read", header.type())};
  const Imath::Box2i& window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (!sidesFit(width, height))
    return Error{file, "dataWindow", fmt::format("is {} x {} pixels, at most {} per side are read", width, height, kMaxImageSide)};
  int count = 0;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel, ++count)
    if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1)
      return Error{file, fmt::format("channel {}", channel.name()), "is subsampled"};
  if (count < 1 || count > kMaxImageChannels)
    return Error{file, "channels", fmt::format("there are {}, allowed are 1 to {}", count, kMaxImageChannels)};
  const std::uint64_t bytes = static_cast<std::uint64_t>(width * height) * static_cast<std::uint64_t>(count) * sizeof(float);
  if (bytes > kMaxImageBytes) return Error{file, "dataWindow", fmt::format("its pixels would take {} bytes", bytes)};
  return Done{};
}

constexpr unsigned kTileSide = 64;

Imf::Header mipmapHeader(const MipmappedImage& image) {
  const Image& finest = image.levels.front();
  Imf::Header header(finest.width, finest.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.setTileDescription(Imf::TileDescription(kTileSide, kTileSide, Imf::MIPMAP_LEVELS, Imf::ROUND_DOWN));
  for (const std::string& name : finest.channels) header.channels().insert(name, Imf::Channel(Imf::HALF));
  for (const auto& [name, value] : image.numbers) header.insert(name, Imf::DoubleAttribute(value));
  if (image.cube) Imf::addEnvmap(header, Imf::ENVMAP_CUBE);
  return header;
}

void readLevel(Imf::TiledInputPart& part, int level, Image& image) {
  const Imath::Box2i window = part.dataWindowForLevel(level);
  image.width = window.max.x - window.min.x + 1;
  image.height = window.max.y - window.min.y + 1;
  image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * image.channels.size());
  part.setFrameBuffer(frameOver(image.pixels, image.channels, image.width, Imf::FLOAT, window));
  part.readTiles(0, part.numXTiles(level) - 1, 0, part.numYTiles(level) - 1, level);
}

}  // namespace

std::vector<std::byte> encodeMipmaps(const MipmappedImage& image) {
  OVERCAST_REQUIRE(isWhole(image), "{} levels that are not a whole mipmapped image", image.levels.size());
  MemoryOutput output;
  {
    Imf::TiledOutputFile file(output, mipmapHeader(image), 0);  // its destructor writes the table of offsets
    for (int level = 0; level < file.numLevels(); ++level) {
      const Image& pixels = image.levels[static_cast<std::size_t>(level)];
      std::vector<Imath::half> halves(pixels.pixels.size());
      std::transform(pixels.pixels.begin(), pixels.pixels.end(), halves.begin(), toHalf);
      file.setFrameBuffer(frameOver(halves, pixels.channels, pixels.width, Imf::HALF, file.dataWindowForLevel(level)));
      file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    }
  }
  return std::move(output.bytes);
}

Result<std::uint64_t> writeMipmaps(const std::filesystem::path& path, const MipmappedImage& image) {
  const std::vector<std::byte> bytes = encodeMipmaps(image);
  if (const auto written = writeFileAtomically(path, bytes); !written) return written.error();
  return bytes.size();
}

Result<MipmappedImage> parseMipmaps(std::span<const std::byte> bytes, const std::string& file) {
  try {
    MemoryInput input(bytes);
    Imf::MultiPartInputFile parts(input, 0);
    if (const auto checked = check(parts, file); !checked) return checked.error();
    const Imf::Header& header = parts.header(0);
    if (!header.hasTileDescription() || header.tileDescription().mode != Imf::MIPMAP_LEVELS ||
        header.tileDescription().roundingMode != Imf::ROUND_DOWN)
      return Error{file, "", "has no mipmap levels that halve and round down"};
    MipmappedImage image;
    image.cube = Imf::hasEnvmap(header) && Imf::envmap(header) == Imf::ENVMAP_CUBE;
    for (auto attribute = header.begin(); attribute != header.end(); ++attribute)
      if (const auto* number = dynamic_cast<const Imf::DoubleAttribute*>(&attribute.attribute()); number != nullptr)
        image.numbers[attribute.name()] = number->value();
    Imf::TiledInputPart part(parts, 0);
    image.levels.resize(static_cast<std::size_t>(part.numLevels()));
    for (int level = 0; level < part.numLevels(); ++level) {
      Image& pixels = image.levels[static_cast<std::size_t>(level)];
      for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
        pixels.channels.emplace_back(channel.name());
      readLevel(part, level, pixels);
    }
    return image;
  } catch (const std::bad_alloc&) {
    throw;  // the sandbox says how much is allowed
  } catch (const std::exception& failure) {
    return Error{file, "", fmt::format("not a readable EXR file ({})", failure.what())};
  }
}

std::vector<glm::dvec3> cubePixelDirections(int side) {
  const Imath::Box2i window(Imath::V2i(0, 0), Imath::V2i(side - 1, 6 * side - 1));
  std::vector<glm::dvec3> directions(6 * static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (int face = 0; face < 6; ++face)
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i) {
        const auto place = Imf::CubeMapFace(face);
        const Imath::V2f inFace(static_cast<float>(i), static_cast<float>(j));
        const Imath::V2f pixel = Imf::CubeMap::pixelPosition(place, window, inFace);
        const Imath::V3f direction = Imf::CubeMap::direction(place, window, inFace);
        const auto index = static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(pixel.x);
        directions[index] = {direction.x, direction.y, direction.z};
      }
  return directions;
}

Result<Image> parseExr(std::span<const std::byte> bytes, const std::string& file) {
  try {
    MemoryInput input(bytes);
    Imf::MultiPartInputFile parts(input, 0);
    if (const auto checked = check(parts, file); !checked) return checked.error();
    const Imf::Header& header = parts.header(0);
    const Imath::Box2i window = header.dataWindow();
    Image image;
    image.width = window.max.x - window.min.x + 1;
    image.height = window.max.y - window.min.y + 1;
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
      image.channels.emplace_back(channel.name());
    image.pixels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * image.channels.size());
    Imf::InputPart part(parts, 0);
    part.setFrameBuffer(frameOver(image.pixels, image.channels, image.width, Imf::FLOAT, window));
    part.readPixels(window.min.y, window.max.y);
    return image;
  } catch (const std::bad_alloc&) {
    throw;  // the sandbox says how much is allowed
  } catch (const std::exception& failure) {
    return Error{file, "", fmt::format("not a readable EXR file ({})", failure.what())};
  }
}

Result<Done> writeExr(const std::filesystem::path& path, const Image& image, ExrBits bits) {
  OVERCAST_REQUIRE(isWhole(image), "an image of {} x {} with {} channels and {} values is not whole", image.width, image.height,
                   image.channels.size(), image.pixels.size());
  if (bits == ExrBits::single) return writeFileAtomically(path, encode(image, image.pixels, Imf::FLOAT));
  std::vector<Imath::half> halves(image.pixels.size());
  std::transform(image.pixels.begin(), image.pixels.end(), halves.begin(), toHalf);
  return writeFileAtomically(path, encode(image, std::move(halves), Imf::HALF));
}

Result<Image> readExr(const std::filesystem::path& path) {
  return parseImage(path, parseExr);
}

}  // namespace overcast
