// overcast-player calibrate as a user runs it, on a small scene.
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/scene.h"
#include "tests/commands/bake_fixture.h"
#include "tests/commands/player_fixture.h"

namespace overcast::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class CalibrateCommand : public PlayerFixture {
 protected:
  ShellResult bake(const std::string& arguments) const { return shell(fmt::format("{} {}", kBake, arguments), folder); }
  json sceneJson() const {
    std::ifstream file(folder / "baked/sphere_on_plane.gltf");
    return json::parse(file);
  }
  /// RMSE of the sky of the first frame against its reference.
  double errorOfFrame(const std::string& options = "") const {
    EXPECT_EQ(play("baked/sphere_on_plane.gltf --headless --size 64x36 --supersample 1 -o picture.exr" + options).exitCode, 0);
    const ShellResult measured = play("measure picture.exr baked/reference/view0_0000.exr --channels sky --json");
    EXPECT_EQ(measured.exitCode, 0) << measured.output;
    return json::parse(measured.output).at("frames").at(0).at("rmse");
  }
};

TEST_F(CalibrateCommand, FitsAndWritesTheSceneAndNothingElseInIt) {
  const std::string plain = quoted(std::string(OVERCAST_SOURCE_FOLDER) + "/data/scenes/sphere_on_plane.gltf");
  ASSERT_EQ(bake(plain + " -o baked --resolution 24 --quiet").exitCode, 0);
  ASSERT_EQ(bake("reference baked/sphere_on_plane.gltf -o baked/reference --size 64x36 --samples 256 --quantities sky --frames 0:1 --quiet")
                .exitCode,
            0);
  const json plainScene = sceneJson();
  const double before = errorOfFrame(" --estimator published --taps 4");
  const std::string scene = "calibrate baked/sphere_on_plane.gltf --taps 4", command = scene + " --points 3000 --estimator published";

  const ShellResult dry = play(command + " --dry-run");
  ASSERT_EQ(dry.exitCode, 0) << dry.output;
  EXPECT_THAT(dry.output, HasSubstr("published, 4 taps: "));
  EXPECT_THAT(dry.output, HasSubstr(" points of 2 frames and "));
  EXPECT_THAT(dry.output, HasSubstr("not written (--dry-run)"));
  EXPECT_EQ(sceneJson(), plainScene);

  const ShellResult unnamed = play(scene + " --points 100 --dry-run");
  ASSERT_EQ(unnamed.exitCode, 0) << unnamed.output;
  EXPECT_THAT(unnamed.output, HasSubstr("calibrated, 4 taps: ")) << "traced, the scene's, has no constants";

  const ShellResult result = play(command + " --json");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  const json fit = json::parse(result.output);
  EXPECT_TRUE(fit.at("written"));
  EXPECT_LT(fit.at("fitError"), fit.at("startError"));
  EXPECT_GE(fit.at("framesError").get<double>(), 0.999 * fit.at("fitError").get<double>());
  json calibrated = sceneJson();
  json& estimator = calibrated["scenes"][0]["extensions"]["OVERCAST_lighting"]["estimator"];
  EXPECT_EQ(estimator, fit.at("estimator"));
  EXPECT_EQ(estimator.at("heldOutError"), std::max(fit.at("framesError").get<double>(), fit.at("objectsError").get<double>()));
  estimator = plainScene["scenes"][0]["extensions"]["OVERCAST_lighting"]["estimator"];
  EXPECT_EQ(calibrated, plainScene) << "all but the estimator";
  EXPECT_LT(errorOfFrame(), 0.95 * before);
  // The picture has the error that the fit states: of both frames and of every pixel, so nearly.
  EXPECT_NEAR(errorOfFrame(), fit.at("fitError").get<double>(), 0.01);

  const ShellResult again = play(command);
  ASSERT_EQ(again.exitCode, 0) << again.output;
  EXPECT_THAT(again.output, HasSubstr("no better than before"));
  EXPECT_EQ(play(command).output, again.output) << "the same every time";
}

TEST_F(CalibrateCommand, FitsWhatCanLightTheScene) {
  const std::string plain = quoted(std::string(OVERCAST_SOURCE_FOLDER) + "/data/scenes/sphere_on_plane.gltf");
  ASSERT_EQ(bake(plain + " -o baked --resolution 24 --apertures vertex --quiet").exitCode, 0);
  ASSERT_EQ(bake("reference baked/sphere_on_plane.gltf -o baked/reference --size 64x36 --samples 256 --quantities sky --quiet").exitCode,
            0);
  const std::string command = "calibrate baked/sphere_on_plane.gltf --points 100";
  const ShellResult plainTaps = play(command + " --estimator calibrated");
  ASSERT_EQ(plainTaps.exitCode, 0) << plainTaps.output;
  EXPECT_THAT(plainTaps.output, HasSubstr("in place of traced; over its apertures hybrid-traced lights it all the same"));
  const ShellResult unnamed = play(command);
  ASSERT_EQ(unnamed.exitCode, 0) << unnamed.output;
  EXPECT_THAT(unnamed.output, HasSubstr("hybrid, 5 taps: "));
  EXPECT_THAT(unnamed.output, testing::EndsWith("in place of calibrated\n")) << "the same constants light it now";
}

TEST_F(CalibrateCommand, RefusesWhatItCannotFit) {
  const auto refused = [&](const std::string& arguments, int code, const std::string& reason) {
    const ShellResult result = play(arguments);
    EXPECT_EQ(result.exitCode, code) << arguments << ": " << result.output;
    EXPECT_THAT(result.output, HasSubstr(reason)) << arguments;
  };
  refused("calibrate", 2, "SCENE");
  refused("calibrate a.gltf --taps 9", 2, "--taps");
  for (const std::string name : {"traced", "hybrid-traced", "hybrid-cones"})
    refused("calibrate a.gltf --estimator " + name, 2, "'" + name + "'");
  refused("calibrate a.gltf", 3, "a.gltf");
  refused("calibrate --help", 0, "--dry-run");
  const std::string plain = std::string(OVERCAST_SOURCE_FOLDER) + "/data/scenes/";
  ASSERT_EQ(bake(quoted(plain + "sphere_on_plane.gltf") + " -o baked --resolution 24 --quiet").exitCode, 0);
  refused("calibrate baked/sphere_on_plane.gltf", 3, "overcast-bake reference");
  ASSERT_EQ(
      bake("reference " + quoted(plain + "cornell_box.gltf") + " -o other --size 16x9 --samples 128 --quantities sky --quiet").exitCode, 0);
  refused("calibrate baked/sphere_on_plane.gltf --reference other", 3, "has no reference of sphere_on_plane.gltf");
}

}  // namespace
}  // namespace overcast::test
