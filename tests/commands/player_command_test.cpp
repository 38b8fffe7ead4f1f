// overcast-player as a user runs it: pictures, tables, JSON, exit codes.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/composite_costs.h"
#include "formats/files.h"
#include "formats/image.h"
#include "formats/scene.h"
#include "tests/commands/player_fixture.h"
#include "tests/reference/shapes.h"
#include "tests/runtime/baked_scene.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class PlayerCommand : public PlayerFixture {
 protected:
  void SetUp() override {
    PlayerFixture::SetUp();
    scene = writeBakedScene(folder, {.animated = true});
  }
  fs::path scene;
};

TEST_F(PlayerCommand, CostMeasuresEveryKindOnce) {
  const ShellResult result = play("cost --runs 3 --voxels 16 --objects 2 --largest 16 -o costs.json 2>&1");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  for (const char* word : {"device: ", "2 objects at 16^3 voxels", "primitive ellipsoid", "heightfield pair 16", "volume 8, 8 bits"})
    EXPECT_THAT(result.output, HasSubstr(word));
  const auto costs = readCompositeCosts(folder / "costs.json");
  ASSERT_TRUE(costs.ok()) << message(costs.error());
  EXPECT_EQ(costs.value().runs, 3);
  EXPECT_EQ(costs.value().costs.size(), 2u + 2u + 4u + 4u);
  for (const CompositeCost& cost : costs.value().costs) {
    EXPECT_LE(cost.least, cost.median);
    EXPECT_LE(cost.median, cost.most);
  }
  EXPECT_EQ(play("cost --voxels 12").exitCode, 2);
  EXPECT_EQ(play("cost --runs 1 --voxels 8 --largest 8 --quiet -o /dev/null/costs.json").exitCode, 4);
}

TEST_F(PlayerCommand, WritesPicturesAndATable) {
  const ShellResult result = play("scene.gltf --headless --frames 3:4 --size 64x48 -o 'out put/f_####.png' -o out_%02d.exr --validate");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  for (const char* word : {"device: ", "pass", "median ms", "p95 ms", "composite", "pyramid", "geometry", "shade", "tonemap", "f_0003.png"})
    EXPECT_THAT(result.output, HasSubstr(word));
  for (const char* number : {"3", "4"}) {
    const auto png = readPng(folder / "out put" / (std::string("f_000") + number + ".png"));
    const auto exr = readExr(folder / (std::string("out_0") + number + ".exr"));
    ASSERT_TRUE(png.ok() && exr.ok()) << result.output;
    EXPECT_EQ(png.value().width, 64);
    EXPECT_EQ(exr.value().height, 48);
    EXPECT_GE(channelIndex(exr.value(), "sky"), 0);
  }
}

TEST_F(PlayerCommand, ItsPixelsAreThoseOfTheReference) {
  // Where other base colours change the picture, it shows a surface.
  Scene other = readScene(scene).value();
  for (Material& material : other.materials) material.baseColour *= 0.5f;
  ASSERT_TRUE(writeScene(folder / "other.gltf", other).ok());
  for (const char* name : {"scene", "other"})
    ASSERT_EQ(play(fmt::format("{0}.gltf --headless --frames 3 --size 64x48 --supersample 1 -o {0}.exr", name)).exitCode, 0);
  const ShellResult traced = shell(fmt::format("{}/overcast-bake reference scene.gltf -o truth --frames 3 --size 64x48 --samples 128 "
                                               "--quantities sky",
                                               quoted(OVERCAST_BINARY_FOLDER)),
                                   folder);
  ASSERT_EQ(traced.exitCode, 0) << traced.output;
  const Image drawn = readExr(folder / "scene.exr").value(), dimmed = readExr(folder / "other.exr").value();
  const Image truth = readExr(folder / "truth/view0_0003.exr").value();
  const int green = channelIndex(drawn, "G"), depth = channelIndex(truth, "depth");
  int surfaces = 0, others = 0;
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      surfaces += at(truth, x, y, depth) >= 0.0f;
      others += (at(truth, x, y, depth) >= 0.0f) != (at(drawn, x, y, green) != at(dimmed, x, y, green));
    }
  EXPECT_GT(surfaces, 300);
  EXPECT_LE(others, 1) << "but for a silhouette within the rounding of single floats of a pixel's middle";
}

TEST_F(PlayerCommand, GivesTheSameBytesTwice) {
  for (const char* name : {"a", "b"})
    ASSERT_EQ(play(fmt::format("scene.gltf --headless --frames 0:1 --size 64x48 -o {0}#.png -o {0}#.exr", name)).exitCode, 0);
  for (const char* file : {"0.png", "1.png", "0.exr", "1.exr"})
    EXPECT_EQ(readFile(folder / (std::string("a") + file)).value(), readFile(folder / (std::string("b") + file)).value()) << file;
  EXPECT_NE(readFile(folder / "a0.png").value(), readFile(folder / "a1.png").value()) << "the scene is animated";
}

TEST_F(PlayerCommand, PrintsOneJsonObjectOnStdout) {
  const ShellResult result = play("scene.gltf --headless --frames 0:5 --size 32x32 --supersample 1 -o f#.png --json 2>messages.txt");
  ASSERT_EQ(result.exitCode, 0);
  const auto json = nlohmann::json::parse(result.output, nullptr, false);
  ASSERT_TRUE(json.is_object()) << result.output;
  EXPECT_EQ(json["pictures"].size(), 6u);
  EXPECT_EQ(json["frames"], nlohmann::json({0, 5}));
  EXPECT_EQ(json["device"]["kind"], "CPU");
  EXPECT_GT(json["triangles"], 0);
  ASSERT_EQ(json["passes"].size(), 7u) << "six passes and the frame";
  for (const auto& pass : json["passes"]) {
    EXPECT_EQ(pass["frames"].get<int>() + pass["skipped"].get<int>(), 5) << "the warm-up is left out";
    EXPECT_GE(pass["p95_ms"].get<double>(), pass["median_ms"].get<double>());
  }
}

TEST_F(PlayerCommand, ListsDevices) {
  const ShellResult plain = play("--list-devices");
  EXPECT_EQ(plain.exitCode, 0);
  EXPECT_THAT(plain.output, AllOf(HasSubstr("0: "), HasSubstr("CPU")));
  const auto json = nlohmann::json::parse(play("--list-devices --json 2>messages.txt").output, nullptr, false);
  ASSERT_TRUE(json.is_object());
  EXPECT_EQ(json["devices"][0]["index"], 0);
}

TEST_F(PlayerCommand, MovesTheCamera) {
  ASSERT_EQ(play("scene.gltf --headless --size 32x32 --supersample 1 --camera 0,9,0,0,0,0,40 -o above.exr").exitCode, 0);
  ASSERT_EQ(play("scene.gltf --headless --size 32x32 --supersample 1 --camera 0,9,0.001,0,99,0 -o away.exr").exitCode, 0);
  const Image above = readExr(folder / "above.exr").value();
  const Image away = readExr(folder / "away.exr").value();
  const int sky = channelIndex(above, "sky");
  EXPECT_LT(at(above, 16, 16, sky), 1.0f) << "the floor";
  for (int i = 0; i < 32; ++i) EXPECT_EQ(at(away, i, i, sky), 1.0f) << "nothing but the backdrop";
}

TEST_F(PlayerCommand, EndsUsageErrorsWithTwo) {
  for (const char* arguments : {"",
                                "scene.gltf --headless --frames 3:1",
                                "scene.gltf --headless --frames -1",
                                "scene.gltf --headless --frames a",
                                "scene.gltf --headless --size 0x9",
                                "scene.gltf --headless --size 99999x9",
                                "scene.gltf --headless --camera 1,2,3",
                                "scene.gltf --headless --camera 1,2,3,1,2,3",
                                "scene.gltf --headless --camera 1,2,3,4,5,nan",
                                "scene.gltf --headless --taps 0",
                                "scene.gltf --headless --taps 4 --estimator traced",
                                "scene.gltf --headless --aperture-mode none",
                                "scene.gltf --headless --time-of-day 25",
                                "scene.gltf --headless --hours-per-second 1",
                                "scene.gltf --headless --resolution 100",
                                "scene.gltf --headless -o f.jpg",
                                "scene.gltf --headless --frames 0:1 -o f.png",
                                "scene.gltf --headless --fps 0",
                                "scene.gltf --headless --supersample 9",
                                "scene.gltf --headless --technique magic",
                                "scene.gltf --headless --constant 2",
                                "scene.gltf --headless --gtao-quality best",
                                "scene.gltf --headless --gtao-radius 0",
                                "scene.gltf --headless --surfel-nearness 0",
                                "scene.gltf --nonsense"}) {
    const ShellResult result = play(arguments);
    EXPECT_EQ(result.exitCode, 2) << arguments << ": " << result.output;
    EXPECT_THAT(result.output, Not(testing::IsEmpty())) << arguments;
  }
  EXPECT_EQ(play("--help").exitCode, 0);
}

TEST_F(PlayerCommand, EndsUnreadableScenesWithThree) {
  ASSERT_TRUE(writeOff(folder / "mesh.off", reference::boxMesh(glm::dvec3(1.0))).ok());
  Scene plain = bakedScene(folder, {});
  for (Node& node : plain.nodes) node.occluder.reset();
  ASSERT_TRUE(writeScene(folder / "plain.gltf", plain).ok());
  for (const char* file : {"absent.gltf", "mesh.off", "plain.gltf"}) {
    const ShellResult result = play(std::string(file) + " --headless --size 16x16 -o never.png");
    EXPECT_EQ(result.exitCode, 3) << file << ": " << result.output;
    EXPECT_THAT(result.output, HasSubstr(file));
  }
  EXPECT_THAT(play("plain.gltf --headless").output, HasSubstr("overcast-bake"));
  ASSERT_TRUE(writeFileAtomically(folder / "shape.off", "OFF\n").ok());
  EXPECT_THAT(play("shape.off --headless").output, HasSubstr("run overcast-bake"));
  EXPECT_FALSE(fs::exists(folder / "never.png"));
}

TEST_F(PlayerCommand, EndsUnwritablePicturesWithFour) {
  const ShellResult result = play("scene.gltf --headless --size 16x16 -o scene.gltf/inside.png");
  EXPECT_EQ(result.exitCode, 4) << result.output;
  EXPECT_THAT(result.output, HasSubstr("scene.gltf: cannot create the folder"));
}

// The cache of the driver is mapped into memory: written on a full disk it would be SIGBUS.
TEST_F(PlayerCommand, PlaysWithItsCacheOnAFullDisk) {
  fs::create_directories(folder / "cache");
  const std::string mounted = "mount -t tmpfs -o size=64k tmpfs cache && ";
  if (shell(fmt::format("unshare -m sh -c {}", test::quoted(mounted + "true")), folder).exitCode != 0) GTEST_SKIP() << "may not mount here";
  const std::string play =
      fmt::format("VK_DRIVER_FILES={} XDG_CACHE_HOME=cache {}/overcast-player scene.gltf --headless --size 16x16 -o full.png",
                  test::quoted(driver), test::quoted(OVERCAST_BINARY_FOLDER));
  const ShellResult result = shell(fmt::format("unshare -m sh -c {}", test::quoted(mounted + play)), folder);
  EXPECT_EQ(result.exitCode, 0) << result.output;
  EXPECT_TRUE(fs::exists(folder / "full.png"));
}

TEST_F(PlayerCommand, SaysThatAWindowNeedsADisplay) {
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const ShellResult result = play("scene.gltf");
  EXPECT_EQ(result.exitCode, 2);
  EXPECT_THAT(result.output, HasSubstr("--headless"));
}

TEST_F(PlayerCommand, EndsWithoutADeviceWithFive) {
  driver = "/nonexistent.json";
  EXPECT_EQ(play("scene.gltf --headless").exitCode, 5);
  EXPECT_EQ(play("--list-devices").exitCode, 5);
  SetUp();
  const ShellResult result = play("scene.gltf --headless --device abacus");
  EXPECT_EQ(result.exitCode, 5);
  EXPECT_THAT(result.output, HasSubstr("abacus"));
}

// A ring fine enough for its vertices to tell what its texels tell, seen where it hides half of the sky from itself.
TEST_F(PlayerCommand, ApertureMapsAndVerticesRenderAlike) {
  ASSERT_TRUE(writeOff(folder / "fine.off", reference::torusMesh(1.0, 0.6, 96, 48)).ok());
  std::vector<Image> pictures;
  for (const std::string way : {"vertex --aperture-bytes 8", "texel --atlas --texels 512"}) {
    const ShellResult result = shell(fmt::format("{}/overcast-bake fine.off -o out --resolution 16 --error-samples 0 --apertures {}",
                                                 quoted(OVERCAST_BINARY_FOLDER), way),
                                     folder);
    ASSERT_EQ(result.exitCode, 0) << result.output;
    const ShellResult drawn = play("out/scene.gltf --headless --size 160x90 -o picture.png");
    ASSERT_EQ(drawn.exitCode, 0) << drawn.output;
    auto picture = readPng(folder / "picture.png");
    ASSERT_TRUE(picture) << message(picture.error());
    pictures.push_back(std::move(picture).value());
  }
  ASSERT_EQ(pictures[0].pixels.size(), pictures[1].pixels.size());
  double squares = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < pictures[0].pixels.size(); ++i) {
    const double off = std::abs(double{pictures[0].pixels[i]} - double{pictures[1].pixels[i]});
    squares += off * off;
    largest = std::max(largest, off);
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(pictures[0].pixels.size())), 0.004);
  EXPECT_LT(largest, 0.04);  // no seams
}

}  // namespace
}  // namespace overcast::test
