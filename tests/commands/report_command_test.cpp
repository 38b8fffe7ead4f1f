// overcast-player report and compare as a user runs them, on a small scene.
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/report.h"
#include "formats/scene.h"
#include "tests/commands/bake_fixture.h"
#include "tests/commands/player_fixture.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ReportCommand : public PlayerFixture {
 protected:
  ShellResult bake(const std::string& arguments) const { return shell(fmt::format("{} {}", kBake, arguments), folder); }
};

TEST_F(ReportCommand, MeasuresWritesChoosesAndCompares) {
  const std::string plain = quoted(std::string(OVERCAST_SOURCE_FOLDER) + "/data/scenes/sphere_on_plane.gltf");
  ASSERT_EQ(bake(plain + " -o baked --resolution 24 --quiet").exitCode, 0);
  ASSERT_EQ(bake(plain + " -o coarse --resolution 12 --bits 8 --quiet").exitCode, 0);
  for (const char* frames : {"0:1", "30:31"})
    ASSERT_EQ(bake(fmt::format("reference baked/sphere_on_plane.gltf -o baked/reference --size 64x36 --samples 256 --quantities sky "
                               "--frames {} --quiet",
                               frames))
                  .exitCode,
              0);
  const std::string options = " --quick --rounds 1 --timed-size 64x36 --quiet";
  const ShellResult first = play("report baked/sphere_on_plane.gltf coarse/sphere_on_plane.gltf -o one --budget-ms 0.000001" + options);
  ASSERT_EQ(first.exitCode, 6) << "nothing is that fast: " << first.output;
  EXPECT_THAT(first.output, HasSubstr("| setting | RMSE |"));
  EXPECT_THAT(first.output, HasSubstr("| rays64, 128^3 |"));
  for (const char* file : {"one/report.html", "one/report.csv", "one/pictures/sphere_on_plane_reference.png"})
    EXPECT_TRUE(fs::exists(folder / file)) << file;
  const auto report = readReport(folder / "one/report.json");
  ASSERT_TRUE(report.ok()) << message(report.error());
  const ReportScene& scene = report.value().scenes.at(0);
  const ReportRow *constant = rowNamed(scene, "constant"), *rays = rowNamed(scene, "rays64, 128^3");
  ASSERT_TRUE(constant != nullptr && rays != nullptr);
  EXPECT_LT(rays->errors.rmse, 0.05);
  EXPECT_GT(constant->errors.rmse, 0.2) << "most of the ground sees all of the sky";
  EXPECT_LT(constant->errors.bias, -0.2);
  EXPECT_EQ(constant->gpuBytes, 0u);
  EXPECT_GT(rays->gpuBytes, 128u * 128 * 2) << "a volume";
  EXPECT_EQ(constant->assetBytes, 0u);
  EXPECT_GE(constant->errors.flicker, 0.0) << "two frames";
  EXPECT_EQ(constant->errors.views.size(), 4u) << "at rest and moved";
  EXPECT_EQ(scene.views.at(2).frame, 30);
  for (const ReportRow& row : scene.rows) {
    double shares = 0.0;
    for (const ReportStep& step : row.steps) shares += step.share;
    if (!row.steps.empty()) {
      EXPECT_NEAR(shares, 1.0, 1e-6) << row.setting;
    }
  }
  EXPECT_NE(rowNamed(scene, "published, 4 taps, 128^3")->steps.at(3).rms, 0.0) << "reads the pyramid";
  EXPECT_EQ(rowNamed(scene, "traced, 128^3")->steps.at(3).rms, 0.0) << "does not";
  const ReportRow* coarse = rowNamed(scene, "rays64, 128^3 [8 bits, up to 12 samples]");
  ASSERT_NE(coarse, nullptr) << "the other bake";
  EXPECT_GT(coarse->errors.rmse, rays->errors.rmse);
  EXPECT_FALSE(coarse->storable);
  const ReportRow* printed = rowNamed(scene, "as printed, 4 taps, 128^3, best k");
  ASSERT_NE(printed, nullptr);
  EXPECT_LT(printed->errors.rmse, constant->errors.rmse);

  // The same errors and bytes again, and a setting chosen and written.
  const double most = scene.rows.front().errors.rmse * 3.0;
  const ShellResult second = play(fmt::format("report baked/sphere_on_plane.gltf -o two --max-error {}", most) + options);
  ASSERT_EQ(second.exitCode, 0) << second.output;
  EXPECT_THAT(second.output, HasSubstr("\nsphere_on_plane: "));
  const auto again = readReport(folder / "two/report.json").value();
  for (const ReportRow& row : again.scenes.at(0).rows) {
    const ReportRow* was = rowNamed(scene, row.setting);  // the other bake is left out
    ASSERT_NE(was, nullptr);
    EXPECT_EQ(row.errors.rmse, was->errors.rmse) << row.setting;
    EXPECT_EQ(row.errors.flicker, was->errors.flicker) << row.setting;
    EXPECT_EQ(row.gpuBytes, was->gpuBytes) << row.setting;
  }
  const int resolution = readScene(folder / "baked/sphere_on_plane.gltf").value().lighting->globalVolume.resolution;
  EXPECT_THAT(second.output, HasSubstr(fmt::format("{}^3 (RMSE", resolution)));

  EXPECT_EQ(play("compare one/report.json one/report.json").exitCode, 0);
  std::ifstream file(folder / "one/report.json");
  nlohmann::json worse = nlohmann::json::parse(file);
  worse["scenes"][0]["rows"][0]["errors"]["rmse"] = 0.9;
  std::ofstream(folder / "worse.json") << worse;
  const ShellResult compared = play("compare one/report.json worse.json");
  EXPECT_EQ(compared.exitCode, 6) << compared.output;
  EXPECT_THAT(compared.output, HasSubstr("WORSE"));
}

TEST_F(ReportCommand, RefusesWhatMakesNoSense) {
  const auto refused = [&](const std::string& arguments, int code, const std::string& reason) {
    const ShellResult result = play(arguments);
    EXPECT_EQ(result.exitCode, code) << arguments << ": " << result.output;
    EXPECT_THAT(result.output, HasSubstr(reason)) << arguments;
  };
  refused("report -o out", 2, "SCENE");
  refused("report a.gltf", 2, "--output");
  refused("report a.gltf -o out --budget-ms 3 --max-error 0.1", 2, "--budget-ms");
  refused("report a.gltf -o out --timed-size 3", 2, "--timed-size");
  refused("report a.gltf -o out", 3, "a.gltf");
  refused("report a.gltf -o out --seconds 0", 2, "--seconds");
  refused("report a.gltf -o /dev/null/out", 4, "/dev/null");
  refused("compare a.json", 2, "AFTER");
  refused("compare a.json b.json", 3, "a.json");
  std::ofstream(folder / "b.json") << "{}";
  refused("compare b.json b.json", 3, "b.json");
  refused("report --help", 0, "--max-error");
}

}  // namespace
}  // namespace overcast::test
