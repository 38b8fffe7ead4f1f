// overcast-player measure as a user runs it: a table, JSON, a clip, the map of FLIP, exit codes. No device.
#include <cmath>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/image.h"
#include "tests/commands/scratch.h"
#include "tests/commands/shell.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class MeasureCommand : public ::testing::Test {
 protected:
  void SetUp() override { folder = scratchFolder(); }
  ShellResult measure(const std::string& arguments) const {
    return shell(fmt::format("{}/overcast-player measure {}", quoted(OVERCAST_BINARY_FOLDER), arguments), folder);
  }
  /// 8 x 4 pixels of `sky`; the right half shows no surface where there is `depth`.
  void write(const std::string& name, float sky, bool depth) const {
    Image image{8, 4, {"sky"}, {}};
    if (depth) image.channels.push_back("depth");
    for (int p = 0; p < 32; ++p) {
      image.pixels.push_back(p % 8 < 4 ? sky : 0.0f);
      if (depth) image.pixels.push_back(p % 8 < 4 ? 2.0f : -1.0f);
    }
    ASSERT_TRUE(writeExr(folder / name, image, ExrBits::single).ok());
  }
  fs::path folder;
};

TEST_F(MeasureCommand, PrintsATableOfTheSurfaces) {
  write("picture.exr", 0.75f, false);
  write("reference.exr", 0.5f, true);
  const ShellResult result = measure("picture.exr reference.exr --flip flip.png");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  for (const char* word : {"channels: sky", "rmse", "bias", "ssim", "flip", "    16   0.2500  +0.2500   0.2500"})
    EXPECT_THAT(result.output, HasSubstr(word));
  const auto map = readPng(folder / "flip.png");
  ASSERT_TRUE(map.ok());
  EXPECT_GT(at(map.value(), 0, 0, 0), 0.1f);
  EXPECT_EQ(at(map.value(), 7, 0, 0), 0.0f);
}

TEST_F(MeasureCommand, ComparesWithAChannelOfAnotherName) {
  write("picture.exr", 0.75f, false);
  Image reference{8, 4, {"dome", "sky"}, {}};
  for (int p = 0; p < 32; ++p) reference.pixels.insert(reference.pixels.end(), {0.5f, 0.0f});
  ASSERT_TRUE(writeExr(folder / "reference.exr", reference, ExrBits::single).ok());
  const ShellResult result = measure("picture.exr reference.exr --channels sky --against dome --json");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  const auto frame = nlohmann::json::parse(result.output).at("frames").at(0);
  EXPECT_EQ(frame.at("max"), 0.5) << "of the right half, where the picture shows nothing";
  EXPECT_EQ(frame.at("bias"), -0.125);
  EXPECT_EQ(measure("picture.exr reference.exr --channels sky --against dome,sky").exitCode, 2);
}

TEST_F(MeasureCommand, ComparesNamedChannelsOfTheSameName) {
  Image image{8, 4, {"B", "G", "R", "sky"}, std::vector<float>(128, 0.5f)};
  ASSERT_TRUE(writeExr(folder / "picture.exr", image, ExrBits::single).ok());
  for (std::size_t p = 2; p < image.pixels.size(); p += 4) image.pixels[p] = 0.25f;
  ASSERT_TRUE(writeExr(folder / "reference.exr", image, ExrBits::single).ok());
  const ShellResult all = measure("picture.exr reference.exr --channels R,G,B --json"),
                    red = measure("picture.exr reference.exr --channels R --json");
  ASSERT_EQ(all.exitCode, 0) << all.output;
  ASSERT_EQ(red.exitCode, 0) << red.output;
  EXPECT_NEAR(nlohmann::json::parse(all.output).at("frames").at(0).at("rmse").get<double>(), 0.25 / std::sqrt(3.0), 1e-6);
  EXPECT_EQ(nlohmann::json::parse(red.output).at("frames").at(0).at("rmse"), 0.25);
}

TEST_F(MeasureCommand, PrintsAClipWithItsFlickerAsJson) {
  for (int frame = 0; frame < 3; ++frame) {
    write(fmt::format("picture_{}.exr", frame), 0.5f + 0.125f * static_cast<float>(frame % 2), false);
    write(fmt::format("reference_{}.exr", frame), 0.5f, true);
  }
  const ShellResult result = measure("picture_#.exr reference_#.exr --frames 0:2 --json");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  const auto json = nlohmann::json::parse(result.output);
  ASSERT_EQ(json.at("frames").size(), 3u);
  EXPECT_EQ(json.at("frames").at(0).at("rmse"), 0.0);
  EXPECT_EQ(json.at("frames").at(0).at("ssim"), 1.0);
  EXPECT_EQ(json.at("frames").at(1).at("bias"), 0.125);
  EXPECT_EQ(json.at("flicker").at("rms"), 0.125);
}

TEST_F(MeasureCommand, EndsWithTheDocumentedCodes) {
  write("picture.exr", 0.75f, false);
  write("reference.exr", 0.5f, true);
  const auto check = [&](const std::string& arguments, int code, const std::string& words) {
    const ShellResult result = measure(arguments);
    EXPECT_EQ(result.exitCode, code) << result.output;
    EXPECT_THAT(result.output, HasSubstr(words));
  };
  check("picture.exr", 2, "reference");
  check("picture.exr reference.exr --channels R,G", 2, "takes one or three");
  check("picture.exr reference.exr --frames 0:3", 2, "no # for the frame number");
  check("picture.exr missing.exr", 3, "missing.exr");
  check("picture.exr reference.exr --channels R,G,B", 3, "picture.exr: the picture has no channel R");
  check("picture.exr reference.exr --flip /proc/flip.png", 4, "/proc/flip.png");
}

}  // namespace
}  // namespace overcast::test
