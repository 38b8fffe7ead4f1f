// overcast-bake reference: files, caches, what is traced again and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/files.h"
#include "formats/image.h"
#include "formats/reference.h"
#include "formats/scene.h"
#include "tests/commands/bake_fixture.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;
using testing::Not;

class ReferenceCommand : public testing::Test {
 protected:
  void SetUp() override {
    folder = scratchFolder();
    scene = sceneFromMesh(reference::torusMesh(1.0, 0.4, 32, 16));
    scene.lighting.emplace().areaLights.push_back({{0.0f, 2.0f, 0.0f}, 0.3f, glm::vec3(2.0f), -1});
    scene.animations.emplace_back().channels.push_back(
        {0, AnimatedProperty::translation, Interpolation::linear, {0.0, 1.0}, {{0, 0, 0, 0}, {3, 0, 0, 0}}});
    save();
  }

  void save() { ASSERT_TRUE(writeScene(folder / "scene.gltf", scene).ok()); }
  ShellResult run(const std::string& arguments) const {
    return shell(fmt::format("{} reference scene.gltf -o out --size 32x24 {}", kBake, arguments), folder);
  }

  fs::path folder;
  Scene scene;
};

TEST_F(ReferenceCommand, WritesViewsAndPoints) {
  const ShellResult result =
      run("--frames 2:3 --camera scene --camera 0,5,0,0,0,0.1,40 --points 100 --error 0.02 --ao-distance 0.3 --preview");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  EXPECT_EQ(listReferences(folder / "out").value().size(), 6u);
  for (const char* name : {"view0_0002", "view1_0003", "points_0003"}) {
    const auto reference = readReference(folder / "out" / (std::string(name) + ".json"));
    ASSERT_TRUE(reference.ok()) << message(reference.error());
    EXPECT_EQ(reference.value().info.scene, "scene.gltf");
    EXPECT_EQ(reference.value().info.sceneHash, tracedHash(readScene(folder / "scene.gltf").value(), reference.value().info.time));
    EXPECT_DOUBLE_EQ(reference.value().info.time, reference.value().info.frame / 30.0);
    for (const char* quantity : {"sky", "dome", "ao", "colour", "light", "bounce"}) {
      ASSERT_NE(quantityNamed(reference.value().info, quantity), nullptr);
      EXPECT_LE(quantityNamed(reference.value().info, quantity)->meanError, 0.02) << quantity;
    }
    EXPECT_TRUE(fs::exists(folder / "out" / (std::string(name) + ".png")));
  }
  const ReferenceInfo second = readReferenceInfo(folder / "out/view1_0002.json").value();
  EXPECT_EQ(second.camera, "0,5,0,0,0,0.1,40");
  EXPECT_NEAR(second.view.worldFromView[3].y, 5.0, 1e-12);
}

TEST_F(ReferenceCommand, TracesAgainOnlyWhatChanged) {
  ASSERT_EQ(run("--frames 0:2 --samples 128 --cache kept").exitCode, 0);
  const auto before = everythingIn(folder / "out");
  EXPECT_THAT(run("--frames 0:2 --samples 128").output, HasSubstr("view0_0002: 32x24; "));
  EXPECT_EQ(everythingIn(folder / "out"), before) << "not even the seconds changed";
  // A calibration of the estimator changes the file but not the truth.
  scene.lighting->estimator.k = 2.0f;
  save();
  const Json same = Json::parse(run("--frames 0:2 --samples 128 --json --quiet").output);
  for (const Json& file : same["files"]) EXPECT_EQ(file["outcome"], "up to date");
  // What is damaged is traced again, or taken from the cache; both give the same picture.
  fs::resize_file(folder / "out/view0_0001.exr", 100);
  fs::remove(folder / "out/view0_0002.json");
  const Json mended = Json::parse(run("--frames 0:2 --samples 128 --json --quiet").output);
  EXPECT_EQ(mended["files"][0]["outcome"], "up to date");
  EXPECT_EQ(mended["files"][1]["outcome"], "traced");
  EXPECT_EQ(mended["files"][2]["outcome"], "traced");
  for (const char* name : {"view0_0001.exr", "view0_0002.exr"}) EXPECT_EQ(contents(folder / "out" / name), before.at(name));
  fs::remove_all(folder / "out");
  const Json cached = Json::parse(run("--frames 0:2 --samples 128 --json --quiet --cache kept").output);
  for (const Json& file : cached["files"]) EXPECT_EQ(file["outcome"], "cached");
  EXPECT_EQ(everythingIn(folder / "out"), before);
  // Settings and scene count.
  EXPECT_THAT(run("--samples 256").output, Not(HasSubstr("up to date")));
  scene.lighting->skyColour.x = 0.5f;
  save();
  EXPECT_THAT(run("--samples 256").output, Not(HasSubstr("up to date")));
}

TEST_F(ReferenceCommand, AnotherSkyGivesOtherColoursAlone) {
  ASSERT_TRUE(writeExr(folder / "red.exr", {2, 1, {"R", "G", "B"}, {1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f}}).ok());
  ASSERT_EQ(run("--samples 128").exitCode, 0);
  const Image plain = readExr(folder / "out/view0_0000.exr").value();
  const ShellResult result = run("--samples 128 --sky red.exr");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  EXPECT_THAT(result.output, Not(HasSubstr("up to date")));
  const Image red = readExr(folder / "out/view0_0000.exr").value();
  double green = 0.0;
  for (int i = 0; i < 32 * 24; ++i) {
    EXPECT_EQ(at(red, i % 32, i / 32, channelIndex(red, "sky")), at(plain, i % 32, i / 32, channelIndex(plain, "sky")));
    green += static_cast<double>(at(red, i % 32, i / 32, channelIndex(red, "G")));
  }
  EXPECT_EQ(green, 0.0);
  EXPECT_EQ(run("--sky nothing.exr").exitCode, 3);
}

TEST_F(ReferenceCommand, TheSkyIsTheScenesImageUnlessAnotherIsNamed) {
  ASSERT_TRUE(writeExr(folder / "red.exr", {2, 1, {"R", "G", "B"}, {1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f}}).ok());
  ASSERT_TRUE(writeExr(folder / "green.exr", {2, 1, {"R", "G", "B"}, {0.0f, 1.0f, 0.0f, 0.0f, 1.0f, 0.0f}}).ok());
  scene.lighting->skyImage = "red.exr";
  save();
  const auto sumOf = [&](const char* channel) {
    const Image image = readExr(folder / "out/view0_0000.exr").value();
    double sum = 0.0;
    for (int i = 0; i < 32 * 24; ++i) sum += static_cast<double>(at(image, i % 32, i / 32, channelIndex(image, channel)));
    return sum;
  };
  ASSERT_EQ(run("--samples 128").exitCode, 0);
  EXPECT_GT(sumOf("R"), 0.0);
  EXPECT_EQ(sumOf("G"), 0.0);
  ASSERT_EQ(run("--samples 128 --sky green.exr").exitCode, 0);
  EXPECT_EQ(sumOf("R"), 0.0);
  EXPECT_GT(sumOf("G"), 0.0);
  fs::remove(folder / "red.exr");
  const ShellResult missing = run("--samples 128");
  EXPECT_EQ(missing.exitCode, 3);
  EXPECT_THAT(missing.output, HasSubstr("red.exr"));
}

TEST_F(ReferenceCommand, GivesTheSameBytesOnAnyNumberOfThreads) {
  ASSERT_EQ(run("--samples 128 --points 50 --threads 1").exitCode, 0);
  const std::string view = contents(folder / "out/view0_0000.exr"), points = contents(folder / "out/points_0000.exr");
  fs::remove_all(folder / "out");
  ASSERT_EQ(run("--samples 128 --points 50 --threads 3").exitCode, 0);
  EXPECT_EQ(contents(folder / "out/view0_0000.exr"), view);
  EXPECT_EQ(contents(folder / "out/points_0000.exr"), points);
}

TEST_F(ReferenceCommand, GoesOnAfterAKillAndAfterAnInterrupt) {
  const std::string all = "--frames 0:400 --samples 2048 --threads 1 --quiet";
  for (const auto& [signal, code] : {std::pair("KILL", 137), std::pair("TERM", 130)}) {
    const ShellResult stopped = run(fmt::format("{} > names & p=$!; sleep 1; kill -{} $p; wait $p", all, signal));
    EXPECT_EQ(stopped.exitCode, code) << stopped.output;
    const auto finished = listReferences(folder / "out").value();
    EXPECT_LT(finished.size(), 401u);
    for (const fs::path& file : finished) EXPECT_TRUE(readReference(file).ok()) << file;
    for (const auto& entry : fs::directory_iterator(folder / "out")) {
      const std::string extension = entry.path().extension().string();
      EXPECT_TRUE(extension == ".json" || extension == ".exr") << "left behind: " << entry.path();
    }
  }
  const auto finished = listReferences(folder / "out").value();
  ASSERT_GT(finished.size(), 2u);
  const auto before = everythingIn(folder / "out");
  ASSERT_EQ(run(fmt::format("--frames 0:{} --samples 2048 --quiet", finished.size() - 1)).exitCode, 0);
  for (const fs::path& file : finished) EXPECT_EQ(contents(file), before.at(file.filename().string())) << "traced again";
}

TEST_F(ReferenceCommand, RefusesWhatMakesNoSense) {
  const auto refused = [&](const std::string& arguments, int code, const std::string& reason) {
    const ShellResult result = shell(kBake + " reference " + arguments, folder);
    EXPECT_EQ(result.exitCode, code) << arguments;
    EXPECT_THAT(result.output, HasSubstr(reason)) << arguments;
  };
  refused("-o out", 2, "SCENE");
  refused("scene.gltf -o out --size 20", 2, "--size");
  refused("scene.gltf -o out --camera 1,2", 2, "--camera");
  refused("scene.gltf -o out --frames 3:1", 2, "--frames");
  refused("scene.gltf -o out --points-only", 2, "--points");
  refused("scene.gltf -o out --samples 200 --error 0.1", 2, "--samples");
  refused("scene.gltf -o out --quantities smell", 2, "smell");
  refused("nothing.gltf -o out", 3, "nothing.gltf");
  refused("scene.gltf -o /dev/null/out", 4, "/dev/null");
  scene.meshes[0].triangles.clear();
  scene.meshes[0].parts.clear();
  scene.nodes[0].mesh = -1;
  scene.meshes.clear();
  save();
  refused("scene.gltf -o out", 3, "scene.gltf");
  EXPECT_FALSE(fs::exists(folder / "out/view0_0000.json"));
  refused("--help", 0, "--ao-distance");
}

}  // namespace
}  // namespace overcast::test
