#include "formats/terrain.h"

#include <cmath>

#include <gtest/gtest.h>

#include "formats/image.h"
#include "tests/formats/support.h"
#include "tests/formats/terrain_files.h"

namespace overcast {
namespace {

using test::Heights;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::vector<std::byte> bytesOf(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Result<Terrain> parsed(const std::string& text, const TerrainOptions& options = {}) {
  return parseTerrain(bytesOf(text), "input", options);
}

void expectError(const Result<Terrain>& terrain, const char* part) {
  ASSERT_FALSE(terrain) << "expected: " << part;
  EXPECT_NE(message(terrain.error()).find(part), std::string::npos) << message(terrain.error());
}

/// A hill on a slope, whole metres, whose outline is ragged at both ends of the profiles.
Heights hill() {
  return Heights(23, 190, [](int x, int y) {
    if (y < x % 3 || y > 189 - x % 5) return kNone;
    return 100.0 + 3.0 * x - y + std::round(60.0 * std::exp(-0.01 * ((x - 9.0) * (x - 9.0) + (y - 80.0) * (y - 80.0))));
  });
}

void expectHeights(const Result<Terrain>& read, const Heights& heights, double tolerance) {
  ASSERT_TRUE(read) << message(read.error());
  const Terrain& terrain = read.value();
  ASSERT_EQ(terrain.columns, heights.columns);
  ASSERT_EQ(terrain.rows, heights.rows);
  for (std::size_t i = 0; i < heights.values.size(); ++i) {
    ASSERT_EQ(std::isnan(terrain.heights[i]), std::isnan(heights.values[i])) << i;
    if (std::isnan(heights.values[i])) continue;
    ASSERT_NEAR(double{terrain.heights[i]}, heights.values[i], tolerance) << i;
  }
}

TEST(Terrain, isTheSameInAllFourFormats) {
  const TemporaryFolder folder;
  const Heights heights = hill();
  TerrainOptions options;
  options.spacing = 30.0;
  options.height = glm::dvec2(-200.0, 400.0);
  writeHeightPng(folder / "a.png", heights, -200.0, 400.0, true);
  writeHeightPng(folder / "interlaced.png", heights, -200.0, 400.0, true, true);
  writeHeightExr(folder / "a.exr", heights);
  writeHeightExr(folder / "named.exr", heights, "height");
  putBytes(folder / "a.asc", bytesOf(esriText(heights, 30.0)));
  putBytes(folder / "esri.dem", bytesOf(esriText(heights, 30.0, -1e30)));
  test::UsgsSettings lines;
  lines.lines = true;
  putBytes(folder / "a.dem", bytesOf(usgsText(heights, {})));
  putBytes(folder / "lines.dem", bytesOf(usgsText(heights, lines)));
  constexpr double kStep = 600.0 / 65535.0;
  expectHeights(readTerrain(folder / "a.png", options), heights, 0.51 * kStep);
  expectHeights(readTerrain(folder / "interlaced.png", options), heights, 0.51 * kStep);
  options.height.reset();
  for (const char* name : {"a.exr", "named.exr"}) expectHeights(readTerrain(folder / name, options), heights, 0.0);
  for (const char* name : {"a.asc", "esri.dem", "a.dem", "lines.dem"}) {
    const auto read = readTerrain(folder / name);
    expectHeights(read, heights, 0.0);
    EXPECT_EQ(read.value().spacing, glm::dvec2(30.0)) << name;
    EXPECT_TRUE(read.value().notes.empty()) << name;
  }
}

TEST(Terrain, ofPicturesSaysWhatItAssumes) {
  const TemporaryFolder folder;
  writeHeightPng(folder / "a.png", Heights(11, 6, [](int x, int) { return x; }), 0.0, 10.0);
  const auto read = readTerrain(folder / "a.png");
  ASSERT_TRUE(read) << message(read.error());
  EXPECT_EQ(read.value().notes.size(), 2u);
  EXPECT_EQ(read.value().spacing, glm::dvec2(1.0));
  EXPECT_EQ(read.value().heights.front(), 0.0f);
  EXPECT_NEAR(read.value().heights.back(), 2.0f, 1e-6f);  // a fifth of 10 m
}

TEST(Terrain, ofAnExrIsInMetresUnlessStretched) {
  const TemporaryFolder folder;
  writeHeightExr(folder / "a.exr", Heights(3, 2, [](int x, int y) { return 0.25 * x + 0.5 * y; }), "R");
  TerrainOptions options;
  options.spacing = 2.0;
  EXPECT_EQ(readTerrain(folder / "a.exr", options).value().heights, (std::vector<float>{0.0f, 0.25f, 0.5f, 0.5f, 0.75f, 1.0f}));
  options.height = glm::dvec2(10.0, 50.0);
  EXPECT_EQ(readTerrain(folder / "a.exr", options).value().heights, (std::vector<float>{10.0f, 20.0f, 30.0f, 30.0f, 40.0f, 50.0f}));
}

TEST(Terrain, ofAnExrThatIsAPlateOrANeedleSaysSo) {
  const TemporaryFolder folder;
  for (const auto& [rise, notes] : {std::pair(1e-3, 2u), {0.1, 1u}, {5.0, 2u}, {0.0, 1u}}) {
    writeHeightExr(folder / "a.exr", Heights(11, 6, [rise = rise](int x, int) { return rise * x; }));
    const auto read = readTerrain(folder / "a.exr");
    ASSERT_TRUE(read) << message(read.error());
    EXPECT_EQ(read.value().notes.size(), notes) << rise;
  }
  TerrainOptions options;
  options.height = glm::dvec2(0.0, 1.0);
  options.spacing = 1.0;
  EXPECT_TRUE(readTerrain(folder / "a.exr", options).value().notes.empty());
}

TEST(Terrain, inDegreesIsSmallerTowardsThePoles) {
  // Arc seconds: 3 of them at 60 degrees north are 46.5 m east-west (WGS 84: 55800 m per degree) and 92.8 m north-south (111412 m).
  test::UsgsSettings settings;
  settings.groundUnit = 3;
  settings.step = 3.0;
  settings.left = 10.0 * 3600.0;
  settings.bottom = 60.0 * 3600.0 - 15.0;
  const Heights heights(5, 11, [](int x, int y) { return x + y; });
  const auto usgs = parsed(usgsText(heights, settings));
  const auto esri = parsed(esriText(heights, 3.0 / 3600.0, -9999.0, 10.0, 60.0 - 5.5 * 3.0 / 3600.0));
  for (const auto* read : {&usgs, &esri}) {
    expectHeights(*read, heights, 0.0);
    EXPECT_NEAR(read->value().spacing.x, 55800.0 * 3.0 / 3600.0, 0.01);
    EXPECT_NEAR(read->value().spacing.y, 111412.0 * 3.0 / 3600.0, 0.01);
    EXPECT_EQ(read->value().notes.size(), 1u);
  }
  TerrainOptions options;
  options.spacing = 12.5;
  EXPECT_EQ(parsed(usgsText(heights, settings), options).value().spacing, glm::dvec2(12.5));
}

TEST(Terrain, inFeetBecomesMetres) {
  test::UsgsSettings settings;
  settings.groundUnit = 1;
  settings.heightUnit = 1;
  settings.step = 100.0;
  settings.heightStep = 0.1;
  const auto read = parsed(usgsText(Heights(4, 4, [](int x, int y) { return x + 4.0 * y; }), settings));
  expectHeights(read, Heights(4, 4, [](int x, int y) { return 0.3048 * (x + 4.0 * y); }), 1e-5);
  EXPECT_NEAR(read.value().spacing.x, 30.48, 1e-12);
}

TEST(Terrain, takesTwoCellSizesAndCentres) {
  const auto read = parsed("ncols 2 nrows 2\nxllcenter 5 yllcenter 6\ndx 10\ndy 20\n1 2\n3 4.5");
  ASSERT_TRUE(read) << message(read.error());
  EXPECT_EQ(read.value().spacing, glm::dvec2(10.0, 20.0));
  EXPECT_EQ(read.value().origin, glm::dvec2(5.0, 6.0));
  EXPECT_EQ(read.value().heights, (std::vector<float>{1.0f, 2.0f, 3.0f, 4.5f}));
}

TEST(Terrain, namesWhatIsWrong) {
  const std::string head = "ncols 2\nnrows 2\ncellsize 1\n";
  expectError(parsed(head + "1 2 3"), "cut short");
  expectError(parsed(head + "1 2 3 4 5"), "'5' comes after the 4 values");
  expectError(parsed(head + "1 2 3,5 4"), "decimal point, not a comma");
  expectError(parsed(head + "1 2 x 4"), "'x' is no number");
  expectError(parsed(head + "-9999 nan -9999 inf"), "holds no height");
  expectError(parsed("ncols 2\ncellsize 1\n1 2"), "nrows: is missing");
  expectError(parsed("ncols 2\nnrows 2\n1 2 3 4"), "cellsize: is missing");
  expectError(parsed("ncols 2\nnrows 2\ncellsize -1\n1 2 3 4"), "-1 is no length");
  expectError(parsed("ncols 2\nnrows 2.5\ncellsize 1\n1 2 3 4"), "2.5 is no number of samples");
  expectError(parsed("ncols 2\nncols 2\nnrows 2\ncellsize 1\n1 2 3 4"), "stands twice");
  expectError(parsed("ncols 99999\nnrows 99999\ncellsize 1\n1 2 3 4"), "more than 33554432");
  expectError(parsed("ncols 3000\nnrows 3000\ncellsize 1\n1 2 3 4"), "do not fit into the file");
  expectError(parsed("ncols 1\nnrows 3\ncellsize 1\n1 2 3"), "fewer than 2");
  expectError(parsed("ncols 2\nnrows 2\ncellsize 1\nbyteorder lsb\n1 2 3 4"), "'byteorder' is no field");
  expectError(parsed("hello"), "neither an ESRI ASCII grid nor a USGS DEM");
  expectError(parsed(std::string(2000, 'x')), "neither an ESRI ASCII grid nor a USGS DEM");
  std::string usgs = usgsText(hill(), {});
  expectError(parsed(usgs.substr(0, usgs.size() - 2048)), "cut short");
  expectError(parsed(usgs.substr(0, 9 * 1024)), "cut short");
  usgs.replace(1024 + 144, 6, "  ab  ");
  expectError(parsed(usgs), "profile 1: height 1 is no whole number");
}

TEST(Terrain, refusesPicturesThatAreNoHeights) {
  const TemporaryFolder folder;
  Image image{4, 4, {"R", "G", "B"}, std::vector<float>(48, 0.5f)};
  ASSERT_TRUE(writePng(folder / "rgb.png", image));
  expectError(readTerrain(folder / "rgb.png"), "picture in colours");
  image.channels = {"bent", "G", "B"};
  ASSERT_TRUE(writeExr(folder / "rgb.exr", image));
  expectError(readTerrain(folder / "rgb.exr"), "named height, Y or R");
  putBytes(folder / "cut.png", bytesOf("\x89PNG\r\n\x1a\n"));
  expectError(readTerrain(folder / "cut.png"), "cut short");
  expectError(readTerrain(folder / "missing.asc"), "missing.asc");
}

TEST(Terrain, survivesDamage) {
  const TemporaryFolder folder;
  writeHeightPng(folder / "a.png", hill(), -200.0, 400.0, true);
  writeHeightExr(folder / "a.exr", hill());
  const std::vector<std::byte> files[] = {fileBytes(folder / "a.png"), fileBytes(folder / "a.exr"), bytesOf(esriText(hill(), 30.0)),
                                          bytesOf(usgsText(hill(), {}))};
  for (const auto& bytes : files)
    for (std::uint64_t seed = 0; seed < 150; ++seed) {
      const auto terrain = parseTerrain(mutated(bytes, seed), "input", {});
      EXPECT_TRUE(!terrain || isWhole(terrain.value())) << seed;
    }
}

TEST(Terrain, agreesOnMountSaintHelens) {
  const std::filesystem::path folder = std::filesystem::path(OVERCAST_SOURCE_FOLDER) / "../shared/meshes/terrain";
  if (!std::filesystem::exists(folder / "sthelens_usgs.dem")) GTEST_SKIP() << "no ../shared";
  const auto dem = readTerrain(folder / "sthelens_usgs.dem");
  ASSERT_TRUE(dem) << message(dem.error());
  EXPECT_EQ(dem.value().columns, 327);
  EXPECT_EQ(dem.value().rows, 466);
  EXPECT_EQ(dem.value().spacing, glm::dvec2(30.0));
  TerrainOptions options;
  options.spacing = 30.0;
  options.height = glm::dvec2(682.0, 2543.0);
  const auto png = readTerrain(folder / "sthelens_30m_16bit.png", options);
  options.height.reset();
  const auto exr = readTerrain(folder / "sthelens_30m_float_nodataNaN.exr", options);
  ASSERT_TRUE(exr && png);
  std::size_t known = 0;
  for (std::size_t i = 0; i < dem.value().heights.size(); ++i) {
    const float height = dem.value().heights[i];
    ASSERT_EQ(std::isnan(height), std::isnan(exr.value().heights[i])) << i;
    if (std::isnan(height)) continue;
    ++known;
    ASSERT_EQ(height, exr.value().heights[i]) << i;
    ASSERT_NEAR(height, png.value().heights[i], 0.03f) << i;
  }
  EXPECT_GT(known, 100000u);
  const auto pit = readTerrain(folder / "richdem_pit.asc.dem");
  ASSERT_TRUE(pit) << message(pit.error());
  EXPECT_EQ(pit.value().columns, 10);
  EXPECT_EQ(pit.value().heights[22], 5.0f);  // the pit's corner, third row
}

}  // namespace
}  // namespace overcast
