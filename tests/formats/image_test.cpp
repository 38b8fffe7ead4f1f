#include "formats/image.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <Imath/half.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/formats/support.h"

namespace overcast {
namespace {

Image gradient(int width, int height, std::vector<std::string> channels) {
  Image image{width, height, std::move(channels), {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (std::size_t c = 0; c < image.channels.size(); ++c)
        image.pixels.push_back((static_cast<float>(x) + 0.37f * static_cast<float>(y)) / static_cast<float>(width + height) -
                               0.1f * static_cast<float>(c));
  return image;
}

bool sameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

std::string text(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void patch(std::vector<std::byte>& bytes, std::size_t at, const std::vector<unsigned>& values) {
  for (const unsigned value : values) bytes[at++] = static_cast<std::byte>(value);
}

TEST(Image, pixelsAreRowsOfInterleavedChannels) {
  Image image = gradient(5, 3, {"R", "sky"});
  at(image, 4, 2, 1) = 7.0f;
  EXPECT_EQ(image.pixels.back(), 7.0f);
  at(image, 0, 1, 0) = 8.0f;
  EXPECT_EQ(image.pixels[10], 8.0f);
  EXPECT_EQ(channelIndex(image, "sky"), 1);
  EXPECT_EQ(channelIndex(image, "Z"), -1);
}

TEST(Exr, singleComesBackBitForBit) {
  const TemporaryFolder folder;
  Image image = gradient(17, 9, {"A", "B", "G", "R", "layer.x"});
  image.pixels[3] = -0.0f;
  image.pixels[4] = std::numeric_limits<float>::infinity();
  image.pixels[5] = std::numeric_limits<float>::quiet_NaN();
  image.pixels[6] = std::numeric_limits<float>::denorm_min();
  image.pixels[7] = std::numeric_limits<float>::max();
  ASSERT_TRUE(writeExr(folder / "image.exr", image, ExrBits::single));
  const auto back = readExr(folder / "image.exr");
  ASSERT_TRUE(back) << message(back.error());
  EXPECT_EQ(back.value().width, 17);
  EXPECT_EQ(back.value().height, 9);
  EXPECT_EQ(back.value().channels, image.channels);
  EXPECT_TRUE(sameBits(back.value().pixels, image.pixels));
}

RC_GTEST_PROP(Exr, singleComesBackWhateverItHolds, ()) {
  const TemporaryFolder folder;
  Image image;
  image.width = *rc::gen::inRange(1, 40);
  image.height = *rc::gen::inRange(1, 40);
  image.channels = {"B", "G", "R"};
  const auto bits = *rc::gen::container<std::vector<std::uint32_t>>(static_cast<std::size_t>(image.width * image.height) * 3,
                                                                    rc::gen::arbitrary<std::uint32_t>());
  image.pixels.resize(bits.size());
  std::memcpy(image.pixels.data(), bits.data(), bits.size() * sizeof(float));
  RC_ASSERT(writeExr(folder / "any.exr", image, ExrBits::single).ok());
  const auto back = readExr(folder / "any.exr");
  RC_ASSERT(back.ok());
  RC_ASSERT(sameBits(back.value().pixels, image.pixels));
}

TEST(Exr, halfRoundsToNearestAndClamps) {
  const TemporaryFolder folder;
  Image image = gradient(64, 33, {"B", "G", "R"});
  image.pixels[0] = 1e6f;
  image.pixels[1] = -1e6f;
  image.pixels[2] = std::numeric_limits<float>::infinity();
  ASSERT_TRUE(writeExr(folder / "image.exr", image));
  const auto back = readExr(folder / "image.exr");
  ASSERT_TRUE(back);
  EXPECT_EQ(back.value().pixels[0], 65504.0f);
  EXPECT_EQ(back.value().pixels[1], -65504.0f);
  EXPECT_TRUE(std::isinf(back.value().pixels[2]));
  for (std::size_t i = 3; i < image.pixels.size(); ++i)
    ASSERT_LE(std::abs(back.value().pixels[i] - image.pixels[i]), std::max(std::abs(image.pixels[i]) * 0x1p-11f, 0x1p-25f));
}

TEST(Exr, channelsAreFoundByName) {
  const TemporaryFolder folder;
  Image image = gradient(4, 4, {"R", "G", "B", "A"});
  ASSERT_TRUE(writeExr(folder / "image.exr", image, ExrBits::single));
  const auto back = readExr(folder / "image.exr");
  ASSERT_TRUE(back);
  EXPECT_EQ(back.value().channels, (std::vector<std::string>{"A", "B", "G", "R"}));
  for (const std::string& name : image.channels)
    EXPECT_EQ(at(back.value(), 2, 3, channelIndex(back.value(), name)), at(image, 2, 3, channelIndex(image, name)));
}

TEST(Exr, bytesAreTheSameAndCarryNoDate) {
  const TemporaryFolder folder;
  const Image image = gradient(70, 40, {"B", "G", "R"});
  ASSERT_TRUE(writeExr(folder / "a.exr", image));
  ASSERT_TRUE(writeExr(folder / "b.exr", image));
  EXPECT_EQ(fileBytes(folder / "a.exr"), fileBytes(folder / "b.exr"));
  EXPECT_EQ(text(fileBytes(folder / "a.exr")).find("capDate"), std::string::npos);
}

TEST(Exr, hugeWindowsAreRefusedBeforeAllocation) {
  const TemporaryFolder folder;
  // Large enough to hold the table of offsets that 16384 lines would have: OpenEXR looks for that first.
  ASSERT_TRUE(writeExr(folder / "image.exr", gradient(160, 160, {"B", "G", "R"}), ExrBits::single));
  auto bytes = fileBytes(folder / "image.exr");
  // The attribute: name, type, size (16), then xMin yMin xMax yMax.
  const std::string attribute = std::string("dataWindow") + '\0' + "box2i" + '\0';
  const std::size_t at = text(bytes).find(attribute) + attribute.size() + 4;
  const auto original = bytes;
  const auto expectRefused = [&](const std::vector<unsigned>& corners, const char* reason) {
    bytes = original;
    patch(bytes, at, corners);
    putBytes(folder / "huge.exr", bytes);
    const auto image = readExr(folder / "huge.exr");
    ASSERT_FALSE(image);
    EXPECT_NE(message(image.error()).find(reason), std::string::npos) << message(image.error());
  };
  expectRefused({0, 0, 0, 0, 0, 0, 0, 0, 0x00, 0x40, 0, 0, 7, 0, 0, 0}, "at most 16384");
  expectRefused({0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0x3f, 0, 0, 0xff, 0x3f, 0, 0}, "would take");
  expectRefused({0, 0, 0, 0x80, 0, 0, 0, 0x80, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f}, "huge.exr: ");
}

TEST(Exr, missingForeignAndCutFilesAreErrors) {
  const TemporaryFolder folder;
  EXPECT_FALSE(readExr(folder / "missing.exr"));
  putBytes(folder / "text.exr", std::vector<std::byte>(3000, std::byte{'x'}));
  EXPECT_FALSE(readExr(folder / "text.exr"));
  ASSERT_TRUE(writeExr(folder / "image.exr", gradient(60, 60, {"B", "G", "R"})));
  const auto whole = fileBytes(folder / "image.exr");
  for (std::size_t part = 0; part < 40; ++part) {
    auto bytes = whole;
    bytes.resize(whole.size() * part / 40);
    putBytes(folder / "cut.exr", bytes);
    EXPECT_FALSE(readExr(folder / "cut.exr")) << bytes.size() << " of " << whole.size();
  }
}

TEST(Png, everyLevelComesBack) {
  const TemporaryFolder folder;
  for (const auto& channels : {std::vector<std::string>{"R", "G", "B"}, std::vector<std::string>{"R", "G", "B", "A"}}) {
    Image image{64, 4, channels, {}};
    for (std::size_t i = 0; i < 64 * 4 * channels.size(); ++i) image.pixels.push_back(static_cast<float>(i * 7 % 256) / 255.0f);
    ASSERT_TRUE(writePng(folder / "image.png", image));
    const auto back = readPng(folder / "image.png");
    ASSERT_TRUE(back) << message(back.error());
    EXPECT_EQ(back.value().channels, channels);
    EXPECT_EQ(back.value().width, 64);
    EXPECT_EQ(back.value().pixels, image.pixels);
  }
}

TEST(Png, roundsToNearestAndClamps) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Image image{3, 1, {"R", "G", "B"}, {-0.5f, 0.0f, 1.0f, 2.0f, 0.4f / 255.0f, 0.6f / 255.0f, 127.4f / 255.0f, 127.6f / 255.0f, nan}};
  ASSERT_TRUE(writePng(folder / "image.png", image));
  const auto back = readPng(folder / "image.png");
  ASSERT_TRUE(back);
  const std::vector<int> expected{0, 0, 255, 255, 0, 1, 127, 128, 0};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(std::lround(back.value().pixels[i] * 255.0f), expected[i]) << i;
}

TEST(Png, bytesAreTheSameAndCarryNoDate) {
  const TemporaryFolder folder;
  const Image image = gradient(90, 50, {"R", "G", "B"});
  ASSERT_TRUE(writePng(folder / "a.png", image));
  ASSERT_TRUE(writePng(folder / "b.png", image));
  EXPECT_EQ(fileBytes(folder / "a.png"), fileBytes(folder / "b.png"));
  for (const char* chunk : {"tIME", "tEXt", "iTXt", "zTXt"}) EXPECT_EQ(text(fileBytes(folder / "a.png")).find(chunk), std::string::npos);
}

TEST(Png, missingForeignAndCutFilesAreErrors) {
  const TemporaryFolder folder;
  EXPECT_FALSE(readPng(folder / "missing.png"));
  putBytes(folder / "text.png", std::vector<std::byte>(3000, std::byte{'x'}));
  EXPECT_FALSE(readPng(folder / "text.png"));
  ASSERT_TRUE(writePng(folder / "image.png", gradient(60, 60, {"R", "G", "B"})));
  const auto whole = fileBytes(folder / "image.png");
  // The closing chunk holds nothing: a file that lacks only part of it may be read.
  for (std::size_t part = 0; part < 40; ++part) {
    auto bytes = whole;
    bytes.resize((whole.size() - 12) * part / 40);
    putBytes(folder / "cut.png", bytes);
    EXPECT_FALSE(readPng(folder / "cut.png")) << bytes.size() << " of " << whole.size();
  }
}

using Reader = Result<Image> (*)(const std::filesystem::path&);

void expectSurvivesAccidents(const TemporaryFolder& folder, const std::vector<std::byte>& whole, Reader read) {
  int errors = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    putBytes(folder / "accident", mutated(whole, seed));
    const auto image = read(folder / "accident");
    if (image) {
      EXPECT_EQ(image.value().pixels.size(),
                static_cast<std::size_t>(image.value().width * image.value().height) * image.value().channels.size());
    } else {
      ++errors;
      EXPECT_NE(message(image.error()).find("accident: "), std::string::npos) << seed;
      EXPECT_EQ(message(image.error()).find('\n'), std::string::npos) << seed;
    }
  }
  EXPECT_GT(errors, 100);
}

TEST(Exr, accidentsEndInAnImageOrAnError) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writeExr(folder / "image.exr", gradient(60, 40, {"B", "G", "R"})));
  expectSurvivesAccidents(folder, fileBytes(folder / "image.exr"), [](const std::filesystem::path& path) { return readExr(path); });
}

TEST(Png, accidentsEndInAnImageOrAnError) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writePng(folder / "image.png", gradient(60, 40, {"R", "G", "B"})));
  expectSurvivesAccidents(folder, fileBytes(folder / "image.png"), [](const std::filesystem::path& path) { return readPng(path); });
}

}  // namespace
}  // namespace overcast
