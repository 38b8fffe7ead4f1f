// Report files: read back as they were, their schema, and what is refused. Changing the lighting of a scene on disk.
#include "formats/report.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/files.h"
#include "formats/scene.h"
#include "formats/scene_lighting.h"
#include "tests/formats/json_schema.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using Json = nlohmann::ordered_json;
using test::TemporaryFolder;
using testing::HasSubstr;

Report smallReport() {
  Report report{"a device", "CPU", "driver 1", "1.3", 240, 135, 640, 360, 7, 0.03, "much", {}};
  ReportRow row;
  row.setting = "published, 5 taps, 128^3, apertures";
  row.technique = "overcast";
  row.estimator = "published";
  row.resolution = 128;
  row.taps = 5;
  row.cones = 7;
  row.bake = "8 bits";
  row.apertureMode = "accurate";
  row.occluders = "16 bits, up to 64 samples";
  row.storable = true;
  row.errors = {0.1, 0.09, -0.05, 0.07, 0.2, 0.3, 0.4, 0.9, 0.12, 0.01, {0.08, 0.12}};
  row.frame = {3.0, 3.5, 0.5, 6};
  row.still = {1.0, 1.25, 0.25, 7};
  row.passes = {{"composite", {2.0, 2.25, 0.5, 6}}};
  row.gpuBytes = std::uint64_t{1} << 40;
  row.assetBytes = 12345;
  row.steps = {{"filter and estimator", 0.1, -0.05, 1.25}};
  ReportRow bare;
  bare.setting = bare.technique = "constant";
  report.scenes.push_back({"clutter", "abc", 2, 1000, 0.002, 7, {{"view0", 0, 0.0}, {"view0", 30, 1.0}}, {row, bare}});
  return report;
}

TEST(Report, IsReadBackAsItWas) {
  const TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path;
  std::ofstream(folder / "report.json") << reportJson(smallReport());
  const auto read = readReport(folder / "report.json");
  ASSERT_TRUE(read.ok()) << message(read.error());
  EXPECT_EQ(reportJson(read.value()), reportJson(smallReport()));
  const ReportRow* row = rowNamed(read.value().scenes.at(0), "published, 5 taps, 128^3, apertures");
  ASSERT_NE(row, nullptr);
  EXPECT_EQ(row->gpuBytes, std::uint64_t{1} << 40);
  EXPECT_EQ(row->errors.flicker, 0.01);
  EXPECT_EQ(row->still.noise, 0.25);
  EXPECT_EQ(row->frame.rounds, 6);
  EXPECT_EQ(row->errors.views.at(1), 0.12);
  EXPECT_EQ(row->bake, "8 bits");
  EXPECT_EQ(row->steps.at(0).share, 1.25);
  EXPECT_TRUE(row->storable);
  const ReportRow* constant = rowNamed(read.value().scenes.at(0), "constant");
  ASSERT_NE(constant, nullptr);
  EXPECT_LT(constant->errors.flicker, 0.0) << "there was none";
  EXPECT_EQ(rowNamed(read.value().scenes.at(0), "magic"), nullptr);
}

TEST(Report, KeepsToItsSchema) {
  const Json schema = test::schema("report");
  EXPECT_EQ(test::violation(schema, Json::parse(reportJson(smallReport())), schema), "");
}

TEST(Report, NamesTheFieldAtFault) {
  const auto errorOf = [](const char* pointer, const Json& value) {
    Json json = Json::parse(reportJson(smallReport()));
    json[Json::json_pointer(pointer)] = value;
    const auto parsed = parseReport(json.dump(), "x");
    return parsed ? std::string() : message(parsed.error());
  };
  EXPECT_EQ(errorOf("/rounds", 9), "");
  EXPECT_THAT(errorOf("/format", "overcast-reference"), HasSubstr("x/format: is 'overcast-reference'"));
  EXPECT_THAT(errorOf("/version", 2), HasSubstr("newer"));
  EXPECT_THAT(errorOf("/scenes/0/rows/0/errors/rmse", -1), HasSubstr("x/scenes/0/rows/0/errors/rmse"));
  EXPECT_THAT(errorOf("/scenes/0/rows/0/frame/noise", "much"), HasSubstr("frame/noise: is not a number"));
  EXPECT_THAT(errorOf("/scenes/0/rows/0/errors/views", Json::array({0.1})), HasSubstr("errors/views: is not an array of 2"));
  EXPECT_THAT(errorOf("/scenes/0/views/1/frame", -1), HasSubstr("views/1/frame"));
  EXPECT_THAT(errorOf("/scenes/0/rows/1/setting", "published, 5 taps, 128^3, apertures"), HasSubstr("twice"));
  EXPECT_FALSE(parseReport("[1, 2", "x").ok());
}

TEST(SceneLighting, IsReplacedAndNothingElse) {
  const TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path;
  Scene scene = sceneFromMesh({});
  scene.nodes[0].mesh = -1;
  scene.meshes.clear();
  scene.lighting.emplace().sun.emplace();
  ASSERT_TRUE(writeScene(folder / "scene.gltf", scene).ok());
  Json before;
  std::ifstream(folder / "scene.gltf") >> before;
  Lighting lighting = *scene.lighting;
  lighting.globalVolume.resolution = 64;
  lighting.estimator.taps = 3;
  ASSERT_TRUE(replaceLighting(folder / "scene.gltf", lighting).ok());
  const auto read = readScene(folder / "scene.gltf");
  ASSERT_TRUE(read.ok()) << message(read.error());
  EXPECT_EQ(read.value().lighting->globalVolume.resolution, 64);
  EXPECT_EQ(read.value().lighting->estimator.taps, 3);
  ASSERT_TRUE(replaceLighting(folder / "scene.gltf", *scene.lighting).ok());
  Json after;
  std::ifstream(folder / "scene.gltf") >> after;
  EXPECT_EQ(after, before);
}

TEST(SceneLighting, IsNotPutWhereThereIsNone) {
  const TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path;
  const std::string plain = R"({"asset": {"version": "2.0"}, "scenes": [{}]})";
  for (const std::string& text : {plain, std::string("{"), std::string(R"({"scenes": 3})")}) {
    std::ofstream(folder / "scene.gltf") << text;
    EXPECT_FALSE(replaceLighting(folder / "scene.gltf", {}).ok());
    std::ifstream file(folder / "scene.gltf");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), text);
  }
  EXPECT_FALSE(replaceLighting(folder / "scene.glb", {}).ok());
  EXPECT_FALSE(replaceLighting(folder / "missing.gltf", {}).ok());
}

}  // namespace
}  // namespace overcast
