// EXR and PNG files that other programs would write, made with OpenEXR and libpng themselves.
#include <cstring>

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include "formats/image.h"
#include "tests/formats/support.h"

namespace overcast {
namespace {

void expectError(const Result<Image>& image, const char* part) {
  ASSERT_FALSE(image) << "expected: " << part;
  EXPECT_NE(message(image.error()).find(part), std::string::npos) << message(image.error());
}

/// x + 100 y over the window (10, 20) to (14, 22), as one channel.
struct Ramp {
  Imath::Box2i window{Imath::V2i(10, 20), Imath::V2i(14, 22)};
  std::vector<float> values;
  Ramp() {
    for (int y = 20; y <= 22; ++y)
      for (int x = 10; x <= 14; ++x) values.push_back(static_cast<float>(x + 100 * y));
  }
  Imf::FrameBuffer frame() {
    Imf::FrameBuffer buffer;
    buffer.insert("Z", Imf::Slice::Make(Imf::FLOAT, values.data(), window, sizeof(float), 5 * sizeof(float)));
    return buffer;
  }
  Imf::Header header() const {
    Imf::Header result(Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(99, 99)), window);
    result.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    return result;
  }
};

TEST(ForeignExr, dataWindowDecidesTheSize) {
  const TemporaryFolder folder;
  Ramp ramp;
  {
    Imf::OutputFile file((folder / "window.exr").c_str(), ramp.header());
    file.setFrameBuffer(ramp.frame());
    file.writePixels(3);
  }
  const auto image = readExr(folder / "window.exr");
  ASSERT_TRUE(image) << message(image.error());
  EXPECT_EQ(image.value().width, 5);
  EXPECT_EQ(image.value().height, 3);
  EXPECT_EQ(image.value().pixels, ramp.values);
}

TEST(ForeignExr, tilesAndMipmapsGiveTheFinestLevel) {
  const TemporaryFolder folder;
  Ramp ramp;
  {
    Imf::Header header = ramp.header();
    header.setTileDescription(Imf::TileDescription(2, 2, Imf::MIPMAP_LEVELS));
    Imf::TiledOutputFile file((folder / "tiles.exr").c_str(), header);
    for (int level = 0; level < file.numLevels(); ++level) {
      file.setFrameBuffer(ramp.frame());
      file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
    }
  }
  const auto image = readExr(folder / "tiles.exr");
  ASSERT_TRUE(image) << message(image.error());
  EXPECT_EQ(image.value().width, 5);
  EXPECT_EQ(image.value().pixels, ramp.values);
}

TEST(ForeignExr, wholeNumbersBecomeFloats) {
  const TemporaryFolder folder;
  std::vector<unsigned> ids{1, 2, 70000, 4};
  {
    Imf::Header header(2, 2);
    header.channels().insert("id", Imf::Channel(Imf::UINT));
    Imf::FrameBuffer buffer;
    buffer.insert("id", Imf::Slice::Make(Imf::UINT, ids.data(), header.dataWindow(), sizeof(unsigned), 2 * sizeof(unsigned)));
    Imf::OutputFile file((folder / "ids.exr").c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(2);
  }
  const auto image = readExr(folder / "ids.exr");
  ASSERT_TRUE(image) << message(image.error());
  EXPECT_EQ(image.value().pixels, (std::vector<float>{1, 2, 70000, 4}));
}

TEST(ForeignExr, severalPartsAreAnError) {
  const TemporaryFolder folder;
  Ramp ramp;
  {
    std::vector<Imf::Header> headers;
    for (const char* name : {"left", "right"}) {
      headers.push_back(ramp.header());
      headers.back().setName(name);
      headers.back().setType(Imf::SCANLINEIMAGE);
    }
    Imf::MultiPartOutputFile file((folder / "parts.exr").c_str(), headers.data(), 2);
    for (int part = 0; part < 2; ++part) {
      Imf::OutputPart out(file, part);
      out.setFrameBuffer(ramp.frame());
      out.writePixels(3);
    }
  }
  expectError(readExr(folder / "parts.exr"), "has 2 parts");
}

TEST(ForeignExr, deepPixelsAreAnError) {
  const TemporaryFolder folder;
  float value = 1.0f;
  float* pointer = &value;
  unsigned count = 1;
  {
    Imf::Header header(1, 1);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(&count), sizeof(unsigned), sizeof(unsigned)));
    buffer.insert("Z", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(&pointer), sizeof(float*), sizeof(float*), sizeof(float)));
    Imf::DeepScanLineOutputFile file((folder / "deep.exr").c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(1);
  }
  expectError(readExr(folder / "deep.exr"), "only flat images");
}

TEST(ForeignExr, subsampledChannelsAreAnError) {
  const TemporaryFolder folder;
  std::vector<float> values(4, 1.0f);
  {
    Imf::Header header(4, 4);
    header.channels().insert("BY", Imf::Channel(Imf::FLOAT, 2, 2));
    Imf::FrameBuffer buffer;
    buffer.insert("BY", Imf::Slice::Make(Imf::FLOAT, values.data(), header.dataWindow(), sizeof(float), 2 * sizeof(float), 2, 2));
    Imf::OutputFile file((folder / "chroma.exr").c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(4);
  }
  expectError(readExr(folder / "chroma.exr"), "channel BY: is subsampled");
}

void writeWithLibpng(const std::filesystem::path& path, unsigned width, unsigned height, unsigned format, const void* pixels,
                     const void* palette = nullptr) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = width;
  image.height = height;
  image.format = format;
  image.colormap_entries = palette == nullptr ? 0 : 2;
  ASSERT_NE(png_image_write_to_file(&image, path.c_str(), 0, pixels, 0, palette), 0) << image.message;
}

TEST(ForeignPng, greyAndPalettesAreWidened) {
  const TemporaryFolder folder;
  const unsigned char grey[] = {0, 51, 255, 102};
  writeWithLibpng(folder / "grey.png", 2, 2, PNG_FORMAT_GRAY, grey);
  auto image = readPng(folder / "grey.png");
  ASSERT_TRUE(image) << message(image.error());
  EXPECT_EQ(image.value().channels, (std::vector<std::string>{"R", "G", "B"}));
  EXPECT_EQ(image.value().pixels, (std::vector<float>{0, 0, 0, 0.2f, 0.2f, 0.2f, 1, 1, 1, 0.4f, 0.4f, 0.4f}));
  const unsigned char greyAlpha[] = {51, 102};
  writeWithLibpng(folder / "alpha.png", 1, 1, PNG_FORMAT_GA, greyAlpha);
  image = readPng(folder / "alpha.png");
  ASSERT_TRUE(image) << message(image.error());
  EXPECT_EQ(image.value().pixels, (std::vector<float>{0.2f, 0.2f, 0.2f, 0.4f}));
  const unsigned char indices[] = {1, 0};
  const unsigned char palette[] = {0, 51, 102, 255, 204, 153};
  writeWithLibpng(folder / "palette.png", 2, 1, PNG_FORMAT_RGB_COLORMAP, indices, palette);
  image = readPng(folder / "palette.png");
  ASSERT_TRUE(image) << message(image.error());
  EXPECT_EQ(image.value().pixels, (std::vector<float>{1, 0.8f, 0.6f, 0, 0.2f, 0.4f}));
}

TEST(ForeignPng, sixteenBitsAreAnError) {
  const TemporaryFolder folder;
  const unsigned short deep[] = {0, 1000, 60000};
  writeWithLibpng(folder / "deep.png", 1, 1, PNG_FORMAT_LINEAR_RGB, deep);
  expectError(readPng(folder / "deep.png"), "16 bits");
}

TEST(ForeignPng, hugeSidesAreAnError) {
  const TemporaryFolder folder;
  const std::vector<unsigned char> row(20000, 7);
  writeWithLibpng(folder / "wide.png", 20000, 1, PNG_FORMAT_GRAY, row.data());
  expectError(readPng(folder / "wide.png"), "at most 16384");
}

}  // namespace
}  // namespace overcast
