// What a scene says of its occluders holds, and a lie is found, for every representation.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "formats/asset.h"
#include "formats/mesh.h"
#include "formats/scene.h"
#include "tests/commands/scratch.h"
#include "tests/commands/shell.h"
#include "tests/reference/shapes.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A pebble: every representation can hold it, none exactly.
Mesh pebble(double dent) {
  Mesh mesh = reference::icosphere(1.0, 3);
  for (glm::dvec3& p : mesh.positions) p *= glm::dvec3(1.3, 0.7, 1.0) * (1.0 + dent * std::sin(3.0 * p.x + 1.0) * std::cos(2.0 * p.z));
  return mesh;
}

class Certificate : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    folder = scratchFolder();
    ASSERT_TRUE(writeOff(folder / "pebble.off", pebble(0.05)).ok());
    const ShellResult baked = bake(fmt::format("pebble.off -o out --representation {} --error-samples 500", GetParam()));
    ASSERT_EQ(baked.exitCode, 0) << baked.output;
  }

  ShellResult bake(const std::string& arguments) const {
    return shell(quoted(std::string(OVERCAST_BINARY_FOLDER) + "/overcast-bake") + " " + arguments, folder);
  }

  Scene baked() const { return readScene(folder / "out/scene.gltf").value(); }

  /// What verify says after `change` of the occluder.
  template <class Change>
  ShellResult tampered(Change change) const {
    Scene scene = baked();
    change(*scene.nodes[0].occluder);
    EXPECT_TRUE(writeScene(folder / "out/lie.gltf", scene).ok());
    return bake("verify out/lie.gltf --source pebble.off");
  }

  fs::path folder;
};

TEST_P(Certificate, HoldsAndIsComplete) {
  const Occluder occluder = *baked().nodes[0].occluder;
  EXPECT_STREQ(name(occluder.representation), GetParam());
  EXPECT_EQ(occluder.error.samples, 500u);
  EXPECT_EQ(occluder.error.seed, 1u);
  EXPECT_EQ(occluder.error.method, "influence-2");
  EXPECT_GT(occluder.error.surfaceRms, 0.0);
  EXPECT_GE(occluder.error.skyRmse, 0.0);
  EXPECT_LE(occluder.error.p99, occluder.error.max);
  const ShellResult verified = bake("verify out/scene.gltf --source pebble.off --json 2>messages");
  EXPECT_EQ(verified.exitCode, 0);
  EXPECT_TRUE(nlohmann::json::parse(verified.output)["findings"].empty());
}

TEST_P(Certificate, EveryFigureIsHeldToItsWord) {
  EXPECT_EQ(tampered([](Occluder&) {}).exitCode, 0);
  using Figure = double MeasuredError::*;
  const std::vector<std::pair<std::string, Figure>> figures = {{"max", &MeasuredError::max},
                                                               {"rms", &MeasuredError::rms},
                                                               {"p99", &MeasuredError::p99},
                                                               {"surfaceRms", &MeasuredError::surfaceRms},
                                                               {"skyRmse", &MeasuredError::skyRmse}};
  for (const auto& [word, figure] : figures)
    for (const double factor : {0.9, 1.1}) {
      const ShellResult found = tampered([&](Occluder& occluder) { occluder.error.*figure *= factor; });
      EXPECT_EQ(found.exitCode, 5) << word;
      EXPECT_THAT(found.output, HasSubstr("states " + word)) << factor;
    }
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.error.signErrors += 7; }).output, HasSubstr("sign errors"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.error.seed = 2; }).output, HasSubstr("measured"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.error.samples = 450; }).output, HasSubstr("measured"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.error.method = "influence-1"; }).output, HasSubstr("bake it again"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.lipschitz = 0.9; }).output, HasSubstr("states lipschitz"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.bounds.min.y -= 0.01; }).output, HasSubstr("states bounds"));
}

TEST_P(Certificate, AnotherMeshOrAnotherAssetIsNoticed) {
  ASSERT_TRUE(writeOff(folder / "pebble.off", pebble(0.06)).ok());
  EXPECT_EQ(bake("verify out/scene.gltf --source pebble.off").exitCode, 5);
  ASSERT_TRUE(writeOff(folder / "pebble.off", pebble(0.05)).ok());
  EXPECT_EQ(bake("verify out/scene.gltf --source pebble.off").exitCode, 0);

  // Another asset of the same kind with hash, bytes, bounds and bound of its own under the old figures.
  ASSERT_TRUE(writeOff(folder / "other.off", pebble(0.06)).ok());
  ASSERT_EQ(bake(fmt::format("other.off -o out --name other --representation {} --error-samples 500", GetParam())).exitCode, 0);
  const Occluder other = *readScene(folder / "out/other.gltf").value().nodes[0].occluder;
  const ShellResult swapped = tampered([&](Occluder& occluder) {
    const MeasuredError stated = occluder.error;
    const std::string source = occluder.source;
    occluder = other;
    occluder.error = stated;
    occluder.source = source;
  });
  EXPECT_EQ(swapped.exitCode, 5);
  EXPECT_THAT(swapped.output, HasSubstr("states max"));
}

// Slopes between random pairs, near and far from each other, within the box.
TEST_P(Certificate, NoSlopeExceedsTheLipschitzBound) {
  const Occluder occluder = *baked().nodes[0].occluder;
  const Asset asset = readAsset(folder / "out", occluder).value();
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const auto anywhere = [&] {
    return occluder.bounds.min + glm::dvec3(share(random), share(random), share(random)) * extent(occluder.bounds);
  };
  double steepest = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const glm::dvec3 a = anywhere(), b = glm::mix(a, anywhere(), std::pow(10.0, -4.0 * share(random)));
    const double apart = glm::length(a - b);
    if (apart < 1e-6) continue;
    steepest = std::max(steepest, std::abs(sampleAsset(asset, a) - sampleAsset(asset, b)) / apart);
  }
  EXPECT_LE(steepest, occluder.lipschitz * (1.0 + 1e-6));
  EXPECT_GT(steepest, 0.5);
}

INSTANTIATE_TEST_SUITE_P(Every, Certificate, testing::Values("primitive", "radius", "heightfield", "volume"),
                         [](const auto& kind) { return std::string(kind.param); });

class Explain : public testing::Test {
 protected:
  void SetUp() override {
    folder = scratchFolder();
    fs::create_directories(folder / "meshes/more");
    ASSERT_TRUE(writeOff(folder / "meshes/more/box.off", reference::boxMesh({1.0, 0.5, 0.25})).ok());
    ASSERT_TRUE(writeOff(folder / "meshes/ring.off", reference::torusMesh(1.0, 0.4, 24, 12)).ok());
    std::ofstream(folder / "meshes/notes.txt") << "no mesh\n";
  }
  ShellResult explain(const std::string& arguments) const {
    return shell(quoted(std::string(OVERCAST_BINARY_FOLDER) + "/overcast-bake") + " explain --error-samples 500 " + arguments, folder);
  }
  fs::path folder;
};

TEST_F(Explain, AFolderIsATable) {
  const ShellResult table = explain("meshes");
  EXPECT_EQ(table.exitCode, 0);
  for (const char* words : {"| box.off | 12 | primitive cuboid | 0.0000 |", "| ring.off |", "| all 2 |", "1 primitive", "bytes ratio"})
    EXPECT_THAT(table.output, HasSubstr(words));

  const nlohmann::json document = nlohmann::json::parse(explain("meshes --json").output)["table"];
  ASSERT_EQ(document["rows"].size(), 2u);
  double logBytes = 0.0, bytes = 0.0;
  for (const auto& row : document["rows"]) {
    EXPECT_NEAR(row["bytesRatio"].get<double>(), row["bytes"].get<double>() / row["volume"]["bytes"].get<double>(), 1e-12);
    EXPECT_GT(row["seconds"].get<double>(), 0.0);
    logBytes += std::log(row["bytesRatio"].get<double>());
    bytes += row["bytes"].get<double>();
  }
  EXPECT_NEAR(document["totals"]["meanBytesRatio"].get<double>(), std::exp(logBytes / 2.0), 1e-9);
  EXPECT_EQ(document["totals"]["bytes"].get<double>(), bytes);
  EXPECT_EQ(document["totals"]["won"]["primitive"], 1);
}

// What explain says is chosen is what a bake chooses.
TEST_F(Explain, AgreesWithTheBake) {
  const nlohmann::json full = nlohmann::json::parse(explain("meshes/ring.off --largest 32 --json").output);
  const nlohmann::json quick = nlohmann::json::parse(explain("meshes --json").output);
  EXPECT_EQ(full["table"]["rows"][0]["chosen"], quick["table"]["rows"][1]["chosen"]);
  EXPECT_EQ(full["table"]["rows"][0]["surfaceRms"], quick["table"]["rows"][1]["surfaceRms"]);
  const ShellResult baked =
      shell(quoted(std::string(OVERCAST_BINARY_FOLDER) + "/overcast-bake") + " meshes/ring.off -o out --error-samples 500 --json", folder);
  const nlohmann::json mesh = nlohmann::json::parse(baked.output.substr(baked.output.find('{')))["inputs"][0]["meshes"][0];
  EXPECT_EQ(mesh["occluder"]["representation"], full["table"]["rows"][0]["representation"]);
  EXPECT_EQ(mesh["occluder"]["bytes"], full["table"]["rows"][0]["bytes"]);
}

TEST_F(Explain, BadFilesOfAFolderAreNamed) {
  std::ofstream(folder / "meshes/broken.off") << "OFF\n8 6 0\n0 0 0\n";
  const ShellResult some = explain("meshes");
  EXPECT_EQ(some.exitCode, 6);
  EXPECT_THAT(some.output, HasSubstr("broken.off"));
  EXPECT_THAT(some.output, HasSubstr("| all 2 |"));
  fs::create_directories(folder / "empty");
  EXPECT_EQ(explain("empty").exitCode, 3);
  EXPECT_EQ(explain("meshes --svg fronts.svg").exitCode, 2);
}

}  // namespace
}  // namespace overcast::test
