// The comparison of golden pictures finds what it should, and leaves pictures to look at.
#include "tests/golden/golden.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/commands/scratch.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr Tolerance kTolerance{0.004, 0.03, 0.005};

Image flat(int width, int height, float value) {
  Image image{width, height, {"R", "G", "B"}, {}};
  image.pixels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, value);
  return image;
}

TEST(GoldenComparison, MeasuresKnownDifferences) {
  const Image golden = flat(10, 10, 0.5f);
  Image picture = golden;
  at(picture, 3, 4, 1) += 0.25f;  // one channel of one pixel in a hundred
  const auto difference = compare(picture, golden, 0.1);
  ASSERT_TRUE(difference.ok());
  EXPECT_DOUBLE_EQ(difference.value().rmse, 0.25 / std::sqrt(300.0));
  EXPECT_DOUBLE_EQ(difference.value().max, 0.25);
  EXPECT_DOUBLE_EQ(difference.value().share, 0.01);
}

TEST(GoldenComparison, AllowsRoundingButNoVisibleChange) {
  const Image golden = flat(100, 100, 0.5f);
  EXPECT_TRUE(within(compare(golden, golden, kTolerance.off).value(), kTolerance));
  EXPECT_TRUE(within(compare(flat(100, 100, 0.5f + 0.5f / 255.0f), golden, kTolerance.off).value(), kTolerance)) << "half a grey level";
  EXPECT_FALSE(within(compare(flat(100, 100, 0.5f + 2.0f / 255.0f), golden, kTolerance.off).value(), kTolerance))
      << "all a little brighter";
  Image blot = golden;
  for (int y = 0; y < 10; ++y)
    for (int x = 0; x < 10; ++x) at(blot, x, y, 0) = 0.55f;
  EXPECT_FALSE(within(compare(blot, golden, kTolerance.off).value(), kTolerance)) << "a faint blot on a hundredth of the picture";
}

TEST(GoldenComparison, RefusesAnotherSize) {
  const auto difference = compare(flat(10, 8, 0.5f), flat(10, 9, 0.5f), 0.1);
  ASSERT_FALSE(difference.ok());
  EXPECT_EQ(difference.error().reason, "the picture is 10x8, its golden 10x9");
}

TEST(GoldenComparison, SaysWhereToLook) {
  const fs::path folder = scratchFolder();
  Golden golden;
  golden.name = "grey";
  golden.tolerance = kTolerance;
  const GoldenFolders folders{folder / "source", folder / "bin", folder / "output"};
  ASSERT_TRUE(writePng(folder / "source/data/golden/grey.png", flat(16, 16, 0.5f)).ok());
  ASSERT_TRUE(writePng(folder / "output/grey/picture.png", flat(16, 16, 0.6f)).ok());
  const auto checked = checkGolden(golden, folder / "output/grey/picture.png", folders);
  ASSERT_FALSE(checked.ok());
  EXPECT_THAT(checked.error().reason, HasSubstr("difference.png"));
  const auto seen = readPng(folder / "output/grey/difference.png");
  ASSERT_TRUE(seen.ok());
  EXPECT_NEAR(at(seen.value(), 5, 5, 0), 0.8f, 0.03f);

  ASSERT_TRUE(renewGolden(golden, folder / "output/grey/picture.png", folders).ok());
  EXPECT_TRUE(checkGolden(golden, folder / "output/grey/picture.png", folders).ok());
}

TEST(GoldenList, NamesTheBadEntry) {
  const fs::path file = scratchFolder() / "goldens.json";
  std::ofstream(file) << R"({"goldens": [{"name": 3}]})";
  const auto goldens = readGoldens(file);
  ASSERT_FALSE(goldens.ok());
  EXPECT_EQ(goldens.error().place, "goldens/0");
}

TEST(GoldenList, IsReadable) {
  const auto goldens = readGoldens(fs::path(OVERCAST_SOURCE_FOLDER) / "data/golden/goldens.json");
  ASSERT_TRUE(goldens.ok()) << message(goldens.error());
  EXPECT_GE(goldens.value().size(), 4u);
  for (const Golden& golden : goldens.value()) {
    EXPECT_FALSE(golden.reason.empty()) << golden.name;
    EXPECT_LT(golden.tolerance.rmse, 0.01) << golden.name << ": a golden that allows more watches over nothing";
  }
}

}  // namespace
}  // namespace overcast::test
