// A terrain from its file to the picture, as a user makes it.
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/image.h"
#include "formats/scene.h"
#include "tests/commands/scratch.h"
#include "tests/commands/shell.h"
#include "tests/golden/compare.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string kBake = quoted(std::string(OVERCAST_BINARY_FOLDER) + "/overcast-bake");
const std::string kPlay = quoted(std::string(OVERCAST_BINARY_FOLDER) + "/overcast-player");
const std::string kTerrain = quoted(std::string(OVERCAST_SOURCE_FOLDER) + "/data/scenes/terrain.asc");

TEST(TerrainCommand, BakesHeightsIntoASceneWithLevels) {
  const fs::path folder = scratchFolder();
  const auto baked = shell(kBake + " " + kTerrain + " -o baked --apertures vertex --rays 32", folder);
  ASSERT_EQ(baked.exitCode, 0) << baked.output;
  EXPECT_THAT(baked.output, HasSubstr("heightfield"));
  EXPECT_THAT(baked.output, HasSubstr("apertures: 16,641 vertices"));
  EXPECT_THAT(baked.output, Not(HasSubstr("note:"))) << "a terrain is a sheet by design";
  const auto scene = readScene(folder / "baked/scene.gltf");
  ASSERT_TRUE(scene.ok()) << message(scene.error());
  ASSERT_EQ(scene.value().meshes.size(), 1u);
  const Mesh& mesh = scene.value().meshes[0];
  EXPECT_EQ(mesh.triangles.size(), 2u * 128u * 128u);
  EXPECT_TRUE(mesh.visibility.has_value());
  ASSERT_TRUE(mesh.levels.has_value());
  ASSERT_EQ(scene.value().nodes.size(), 1u);
  EXPECT_TRUE(scene.value().nodes[0].occluder.has_value()) << "one occluder for the whole terrain";
}

TEST(TerrainCommand, ShowsLevelsThatLookLikeTheFinest) {
  const fs::path folder = scratchFolder();
  ASSERT_EQ(shell(kBake + " " + kTerrain + " -o baked", folder).exitCode, 0);
  const auto picture = [&](const std::string& name, const std::string& error) {
    const auto played =
        shell(kPlay + " baked/scene.gltf --headless --size 160x90 --resolution 32 --camera 0,900,2600,0,100,0,30 --level-error " + error +
                  " -o " + name,
              folder);
    EXPECT_EQ(played.exitCode, 0) << played.output;
    EXPECT_EQ(played.output.find("triangles drawn: 32768 ") != std::string::npos, error == "0") << played.output;
    return readPng(folder / name);
  };
  const auto finest = picture("finest.png", "0"), levels = picture("levels.png", "1"), coarse = picture("coarse.png", "40");
  ASSERT_TRUE(finest.ok() && levels.ok() && coarse.ok());
  const auto near = compare(levels.value(), finest.value(), 0.1), far = compare(coarse.value(), finest.value(), 0.1);
  EXPECT_GT(near.value().max, 0.0) << "no coarser level was drawn";
  EXPECT_LT(near.value().rmse, 0.02);
  EXPECT_GT(far.value().rmse, 2.0 * near.value().rmse);
}

TEST(TerrainCommand, SaysWhatItCannotUse) {
  const fs::path folder = scratchFolder();
  std::ofstream(folder / "bad.asc") << "ncols 2\nnrows 2\ncellsize 1\n1 2 3";
  const auto bad = shell(kBake + " bad.asc -o out", folder);
  EXPECT_EQ(bad.exitCode, 3);
  EXPECT_THAT(bad.output, HasSubstr("bad.asc: is cut short: 4 values"));
  EXPECT_FALSE(fs::exists(folder / "out/scene.gltf"));
  for (const char* option : {"--terrain-height 5", "--terrain-height 5:5", "--terrain-spacing 0"})
    EXPECT_EQ(shell(kBake + " " + kTerrain + " -o out " + option, folder).exitCode, 2) << option;
}

TEST(TerrainCommand, KnowsItsOptionsInTheCache) {
  const fs::path folder = scratchFolder();
  const std::string bake = kBake + " " + kTerrain + " --error-samples 64 --cache cache -o ";
  ASSERT_EQ(shell(bake + "a", folder).exitCode, 0);
  ASSERT_EQ(shell(bake + "b --terrain-spacing 5", folder).exitCode, 0);
  const auto wide = readScene(folder / "a/scene.gltf"), narrow = readScene(folder / "b/scene.gltf");
  ASSERT_TRUE(wide.ok() && narrow.ok());
  EXPECT_NEAR(extent(bounds(wide.value().meshes[0])).x, 1280.0, 1e-3);
  EXPECT_NEAR(extent(bounds(narrow.value().meshes[0])).x, 640.0, 1e-3);
}

}  // namespace
}  // namespace overcast::test
