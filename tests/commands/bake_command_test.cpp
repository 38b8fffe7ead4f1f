// The command overcast-bake: exit codes, messages, files.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/composite_costs.h"
#include "formats/files.h"
#include "formats/mesh.h"
#include "formats/scene.h"
#include "formats/scene_lighting.h"
#include "tests/commands/bake_fixture.h"
#include "tests/reference/radius.h"
#include "tests/reference/shapes.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class BakeCommand : public BakeFixture {
 protected:
  void SetUp() override {
    BakeFixture::SetUp();
    std::ofstream(folder / "text.txt") << "hello\n";
  }
};

TEST_F(BakeCommand, AMeshBecomesASceneThatValidates) {
  const ShellResult baked = bake("ball.off -o out --resolution 32 2>messages");
  EXPECT_EQ(baked.exitCode, 0) << contents(folder / "messages");
  EXPECT_THAT(baked.output, testing::MatchesRegex("out/volumes/ball-[0-9a-f]{8}.vdb\nout/scene-[0-9a-f]{8}.bin\nout/scene.gltf\n"));
  EXPECT_THAT(contents(folder / "messages"), HasSubstr("ball.off: 1,280 faces, 32x32x32, "));
  EXPECT_THAT(contents(folder / "messages"), HasSubstr("closed, signed-crossings\n"));
  EXPECT_THAT(contents(folder / "messages"), Not(HasSubstr("\r")));
  EXPECT_EQ(filesIn("out").size(), 3u);

  const Result<Scene> scene = readScene(folder / "out/scene.gltf");
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene.value().nodes.size(), 1u);
  const Occluder& occluder = scene.value().nodes[0].occluder.value();
  EXPECT_EQ(occluder.source, "ball.off");
  EXPECT_EQ(occluder.bytes, fs::file_size(folder / "out" / occluder.uri));
  EXPECT_EQ(occluder.error.samples, 4096u);
  EXPECT_EQ(occluder.error.signErrors, 0u);
  EXPECT_GT(occluder.error.rms, 0.0);
  EXPECT_TRUE(scene.value().lighting.has_value());
  EXPECT_EQ(bake("validate out/scene.gltf").exitCode, 0);
}

TEST_F(BakeCommand, AGltfSceneKeepsItsNameAndItsEstimator) {
  ASSERT_EQ(bake("ball.off ring.off -o first --name pair").exitCode, 0);
  Lighting lighting = readScene(folder / "first/pair.gltf").value().lighting.value();
  EXPECT_EQ(lighting.estimator.name, "traced") << "where nobody chose";
  lighting.estimator.name = "published";
  ASSERT_TRUE(replaceLighting(folder / "first/pair.gltf", lighting).ok());
  ASSERT_EQ(bake("first/pair.gltf -o second").exitCode, 0);
  EXPECT_EQ(bake("validate second/pair.gltf").exitCode, 0);
  EXPECT_EQ(readScene(folder / "second/pair.gltf").value().lighting->estimator.name, "published");
  EXPECT_EQ(bake("first/pair.gltf -o first").exitCode, 2);  // would replace its own input
  EXPECT_EQ(bake("validate first/pair.gltf").exitCode, 0);
}

TEST_F(BakeCommand, EqualMeshesShareOneVolume) {
  fs::copy_file(folder / "ball.off", folder / "copy.off");
  ASSERT_EQ(bake("ball.off copy.off ring.off -o out --resolution 16").exitCode, 0);
  EXPECT_EQ(filesIn("out/volumes").size(), 2u);
  const Result<Scene> scene = readScene(folder / "out/scene.gltf");
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(scene.value().nodes.size(), 3u);
  EXPECT_EQ(scene.value().nodes[0].occluder->uri, scene.value().nodes[1].occluder->uri);
}

TEST_F(BakeCommand, SameBytesForAnyThreadCount) {
  for (const char* threads : {"1", "2", "4"})
    ASSERT_EQ(bake(fmt::format("ball.off ring.off bowl.off -o out{0} --threads {0} --quiet", threads)).exitCode, 0);
  EXPECT_EQ(filesIn("out1"), filesIn("out2"));
  EXPECT_EQ(filesIn("out1"), filesIn("out4"));
}

// Every representation, on meshes that give repair, winding number and centre search something to decide.
TEST_F(BakeCommand, SameAssetsAndErrorsForAnyOrderOfTheInput) {
  const Mesh ball = reference::withRadius(reference::icosphere(1.0, 3), reference::bumpyRadius());
  write("bumpy.off", ball);
  write("spoiled.off", reference::withFlips(reference::withHoles(reference::torusMesh(1.0, 0.4, 32, 16), 0.1, 4), 0.2, 5));
  Mesh bumps = reference::torusMesh(1.0, 0.4, 32, 16);
  std::erase_if(bumps.triangles,
                [&](const glm::uvec3& t) { return bumps.positions[t.x].y + bumps.positions[t.y].y + bumps.positions[t.z].y < 0.1; });
  write("half.off", bumps);
  const std::map<std::string, std::string> meshOf = {
      {"volume", "spoiled.off"}, {"radius", "bumpy.off"}, {"heightfield", "half.off"}, {"primitive", "bumpy.off"}};
  for (const auto& [representation, name] : meshOf) {
    SCOPED_TRACE(representation);
    std::vector<nlohmann::json> errors;
    std::vector<std::vector<std::string>> assets;
    for (const int threads : {1, 2, 4}) {
      const Result<MeshFile> given = readMesh(folder / name);
      ASSERT_TRUE(given.ok());
      fs::create_directories(folder / "in");
      const auto seed = static_cast<std::uint64_t>(threads);
      ASSERT_TRUE(writeOff(folder / "in" / name, threads == 1 ? given.value().mesh : reference::shuffled(given.value().mesh, seed)).ok());
      const std::string out = fmt::format("{}{}", representation, threads);
      const ShellResult baked =
          bake(fmt::format("in/{} -o {} --representation {} --max-error 0.02 --threads {} --json --error-samples 500 --quiet", name, out,
                           representation, threads));
      ASSERT_EQ(baked.exitCode, 0) << baked.output;
      nlohmann::json occluder = nlohmann::json::parse(baked.output)["inputs"][0]["meshes"][0]["occluder"];
      EXPECT_EQ(occluder["representation"], representation);
      for (const char* hashed : {"uri", "settingsHash"}) occluder.erase(hashed);
      errors.push_back(occluder);
      assets.emplace_back();
      for (const auto& [path, bytes] : filesIn(out))
        if (path.ends_with(".vdb") || path.ends_with(".exr")) assets.back().push_back(bytes);
    }
    EXPECT_EQ(errors[0], errors[1]);
    EXPECT_EQ(errors[0], errors[2]);
    EXPECT_EQ(assets[0].size(), representation == "primitive" ? 0u : 1u);
    EXPECT_TRUE(assets[0] == assets[1] && assets[0] == assets[2]);
  }
}

TEST_F(BakeCommand, JsonAloneIsOnStdout) {
  const ShellResult baked = bake("ball.off bowl.off -o out --resolution 32 --json 2>messages");
  ASSERT_EQ(baked.exitCode, 0);
  const nlohmann::json document = nlohmann::json::parse(baked.output);
  EXPECT_EQ(document["format"], "overcast-bake");
  EXPECT_EQ(document["version"], 1);
  ASSERT_EQ(document["inputs"].size(), 2u);
  EXPECT_EQ(document["inputs"][0]["meshes"][0]["found"]["closed"], true);
  EXPECT_EQ(document["inputs"][1]["meshes"][0]["found"]["closed"], false);
  EXPECT_EQ(document["inputs"][1]["meshes"][0]["occluder"]["signMethod"], "winding-number");
  EXPECT_EQ(document["files"].size(), 4u);
  EXPECT_THAT(contents(folder / "messages"), HasSubstr("bowl.off: note: "));

  const nlohmann::json inspected = nlohmann::json::parse(bake("inspect out/scene.gltf --json").output);
  EXPECT_EQ(inspected["kind"], "baked scene");
  EXPECT_EQ(inspected["occluders"], 2);
}

TEST_F(BakeCommand, QuietSaysNothing) {
  EXPECT_EQ(bake("bowl.off -o out --quiet > /dev/null").output, "");
}

TEST_F(BakeCommand, WrongArgumentsAreExitCodeTwo) {
  for (const char* arguments :
       {"", "ball.off", "-o out", "ball.off -o out --resolution 7", "ball.off -o out --resolution many", "ball.off -o out --bits 9",
        "ball.off -o out --voxel-size 0", "ball.off -o out --voxel-size 1 --resolution 9", "ball.off -o out --wrong",
        "ball.off -o out --padding nan", "ball.off -o out --max-error nan", "ball.off -o out --max-sky-error 0",
        "ball.off -o out --name ../up", "inspect", "validate", "explain", "verify out/scene.gltf"}) {
    EXPECT_EQ(bake(arguments).exitCode, 2) << arguments;
    EXPECT_FALSE(fs::exists(folder / "out")) << arguments;
  }
  for (const char* arguments : {"--help", "bake --help", "inspect --help", "validate --help"}) {
    const ShellResult help = bake(arguments);
    EXPECT_EQ(help.exitCode, 0);
    EXPECT_THAT(help.output, HasSubstr("Exit codes:"));
  }
  EXPECT_THAT(bake("--version").output, HasSubstr("overcast-bake 0."));
}

TEST_F(BakeCommand, BadInputsAreNamedAndNothingIsWritten) {
  write("point.off", reference::scaled(reference::boxMesh(glm::dvec3(1.0)), 0.0));
  const ShellResult baked = bake("ball.off broken.off missing.off text.txt point.off -o out");
  EXPECT_EQ(baked.exitCode, 3);
  for (const char* file : {"broken.off", "missing.off", "text.txt", "point.off"}) EXPECT_THAT(baked.output, HasSubstr(file));
  EXPECT_EQ(std::count(baked.output.begin(), baked.output.end(), '\n'), 4);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(BakeCommand, KeepGoingBakesTheGoodOnes) {
  EXPECT_EQ(bake("ball.off broken.off ring.off -o out --resolution 16 --keep-going").exitCode, 6);
  EXPECT_EQ(filesIn("out/volumes").size(), 2u);
  EXPECT_EQ(bake("validate out/scene.gltf").exitCode, 0);
  EXPECT_EQ(bake("broken.off -o none --keep-going").exitCode, 3);
  EXPECT_FALSE(fs::exists(folder / "none"));
}

TEST_F(BakeCommand, AnOutputThatCannotBeWrittenIsExitCodeFour) {
  const ShellResult baked = bake("ball.off -o text.txt");
  EXPECT_EQ(baked.exitCode, 4);
  EXPECT_THAT(baked.output, HasSubstr("text.txt"));
  EXPECT_EQ(contents(folder / "text.txt"), "hello\n");
}

TEST_F(BakeCommand, FlatSheetsBake) {
  Mesh sheet;
  sheet.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  write("sheet.off", sheet);
  EXPECT_EQ(bake("sheet.off -o out").exitCode, 0);
  EXPECT_EQ(bake("validate out/scene.gltf").exitCode, 0);
}

TEST_F(BakeCommand, ValidateFindsWhatIsWrong) {
  ASSERT_EQ(bake("ball.off -o out --resolution 32").exitCode, 0);
  const Result<Scene> scene = readScene(folder / "out/scene.gltf");
  ASSERT_TRUE(scene.ok());
  const fs::path volume = folder / "out" / scene.value().nodes[0].occluder->uri;
  const std::string whole = contents(volume);

  std::string changed = whole;
  changed[changed.size() / 2] = static_cast<char>(changed[changed.size() / 2] ^ 1);
  std::ofstream(volume, std::ios::binary) << changed;
  ShellResult found = bake("validate out/scene.gltf");
  EXPECT_EQ(found.exitCode, 5);
  EXPECT_THAT(found.output, HasSubstr("content does not match"));

  std::ofstream(volume, std::ios::binary) << whole.substr(0, whole.size() / 2);
  found = bake("validate out/scene.gltf");
  EXPECT_EQ(found.exitCode, 5);
  EXPECT_THAT(found.output, HasSubstr("bytes, the scene says"));

  fs::remove(volume);
  EXPECT_EQ(bake("validate out/scene.gltf").exitCode, 5);
  std::ofstream(volume, std::ios::binary) << whole;
  EXPECT_EQ(bake("validate out/scene.gltf").exitCode, 0);

  for (const auto& [from, to] : std::map<std::string, std::string>{{"\"lipschitz\":", "\"lipschitz\":0.5,\"was\":"},
                                                                   {"\"signMethod\":", "\"signMethod\":\"other\",\"was\":"}}) {
    std::string text = contents(folder / "out/scene.gltf");
    const std::size_t place = text.find(from);
    ASSERT_NE(place, std::string::npos) << from;
    text.replace(place, from.size(), to);
    std::ofstream(folder / "out/changed.gltf") << text;
    EXPECT_EQ(bake("validate out/changed.gltf").exitCode, 5) << from;
  }
  EXPECT_EQ(bake("validate ball.off").exitCode, 3);
  EXPECT_EQ(bake("validate missing.gltf").exitCode, 3);
}

// Without being told.
TEST_F(BakeCommand, EveryMeshBecomesWhatSuitsIt) {
  write("box.off", reference::boxMesh({1.0, 0.5, 0.25}));
  ASSERT_EQ(bake("box.off ball.off bowl.off -o out").exitCode, 0);
  const Result<Scene> scene = readScene(folder / "out/scene.gltf");
  ASSERT_TRUE(scene.ok());
  const Occluder& box = *scene.value().nodes[0].occluder;
  EXPECT_EQ(box.representation, Representation::primitive);
  EXPECT_LT(box.error.max, 1e-5 * diagonal(box.bounds));
  EXPECT_EQ(scene.value().nodes[1].occluder->representation, Representation::primitive);
  EXPECT_EQ(bake("verify out/scene.gltf --source box.off ball.off bowl.off").exitCode, 0);
  EXPECT_EQ(bake("validate out/scene.gltf").exitCode, 0);
}

TEST_F(BakeCommand, TheErrorAllowedDecidesTheSize) {
  ASSERT_EQ(bake("ring.off -o rough --max-error 0.02 --representation volume --error-samples 1000").exitCode, 0);
  const ShellResult fine = bake("ring.off -o fine --max-error 0.003 --representation volume --error-samples 1000 --json 2>messages");
  ASSERT_EQ(fine.exitCode, 0);
  EXPECT_THAT(contents(folder / "messages"), HasSubstr("ring.off: 1,024 faces, volume "));
  const nlohmann::json mesh = nlohmann::json::parse(fine.output)["inputs"][0]["meshes"][0];
  const nlohmann::json& choice = mesh["choice"];
  EXPECT_TRUE(choice["withinLimits"]);
  EXPECT_GT(choice["scores"].size(), 2u);
  EXPECT_EQ(choice["scores"][choice["chosen"].get<std::size_t>()]["reason"], "chosen");
  EXPECT_EQ(mesh["occluder"]["measured"]["samples"], 1000);
  const auto stated = [&](const char* name) { return readScene(folder / name / "scene.gltf").value().nodes[0].occluder.value(); };
  EXPECT_LT(stated("rough").bytes, stated("fine").bytes);
  EXPECT_LE(stated("fine").error.surfaceRms, 0.003 * choice["diagonal"].get<double>());
  for (const char* name : {"rough", "fine"}) {
    EXPECT_EQ(bake(fmt::format("validate {}/scene.gltf", name)).exitCode, 0);
    EXPECT_EQ(bake(fmt::format("verify {}/scene.gltf --source ring.off", name)).exitCode, 0);
  }
  ASSERT_EQ(bake("ring.off -o few --max-bytes 12000 --representation volume --error-samples 1000").exitCode, 0);
  EXPECT_LE(stated("few").bytes, 12000u);
  EXPECT_EQ(bake("ring.off -o none --max-bytes 9").exitCode, 3);
  EXPECT_EQ(bake("ring.off -o none --max-error 0.01 --resolution 32").exitCode, 2);
  EXPECT_EQ(bake("ring.off -o none --max-error 0.01 --error-samples 0").exitCode, 2);
  EXPECT_FALSE(fs::exists(folder / "none"));
}

TEST_F(BakeCommand, ExplainShowsWinnerAndLosers) {
  const ShellResult table = bake("explain ring.off --largest 16 --error-samples 1000 --svg fronts.svg");
  ASSERT_EQ(table.exitCode, 0) << table.output;
  for (const char* words :
       {"ring.off: diagonal", "volume 8 half", "volume 16 single", "times the error", "chosen", "composite: nanoseconds"})
    EXPECT_THAT(table.output, HasSubstr(words));
  const std::string svg = contents(folder / "fronts.svg");
  EXPECT_THAT(svg, testing::StartsWith("<svg "));
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
  EXPECT_THAT(svg, HasSubstr("volume 16 half"));
  const ShellResult document = bake("explain ring.off --largest 12 --error-samples 500 --json");
  ASSERT_EQ(document.exitCode, 0);
  const nlohmann::json choice = nlohmann::json::parse(document.output)["meshes"][0]["choice"];
  EXPECT_GE(choice["scores"].size(), 4u);
  for (const auto& score : choice["scores"]) EXPECT_FALSE(score["reason"].get<std::string>().empty());
  EXPECT_EQ(bake("explain missing.off").exitCode, 3);
  EXPECT_EQ(bake("explain ring.off --costs ring.off").exitCode, 3);
  CompositeCosts costs = defaultCompositeCosts();
  for (CompositeCost& cost : costs.costs) cost.median = cost.representation == Representation::volume ? 2.5 : 7.25;
  ASSERT_TRUE(writeFileAtomically(folder / "costs.json", compositeCostsJson(costs)).ok());
  const ShellResult priced = bake("explain ring.off --largest 12 --error-samples 500 --json --costs costs.json");
  ASSERT_EQ(priced.exitCode, 0) << priced.output;
  for (const auto& score : nlohmann::json::parse(priced.output)["meshes"][0]["choice"]["scores"])
    if (score.contains("compositeNanoseconds")) {
      EXPECT_EQ(score["compositeNanoseconds"], score["representation"] == "volume" ? 2.5 : 7.25);
    }
  EXPECT_EQ(bake("explain ring.off --largest 8 --error-samples 100 --svg text.txt/x.svg").exitCode, 4);
}

TEST_F(BakeCommand, VerifyFindsLies) {
  ASSERT_EQ(bake("ball.off bowl.off -o out --resolution 16 --error-samples 1000").exitCode, 0);
  const std::string scene = "verify out/scene.gltf --source ball.off bowl.off";
  EXPECT_EQ(bake(scene).exitCode, 0) << bake(scene).output;
  EXPECT_EQ(bake("verify out/scene.gltf --source ball.off").exitCode, 5);  // bowl.off is missing
  EXPECT_EQ(bake("verify out/scene.gltf --source missing.off").exitCode, 3);
  EXPECT_EQ(bake("verify out/scene.gltf").exitCode, 2);

  const auto tampered = [&](auto change) {
    Scene read = readScene(folder / "out/scene.gltf").value();
    change(*read.nodes[0].occluder);
    EXPECT_TRUE(writeScene(folder / "out/lie.gltf", read).ok());
    return bake("verify out/lie.gltf --source ball.off bowl.off");
  };
  EXPECT_EQ(tampered([](Occluder&) {}).exitCode, 0);
  for (double MeasuredError::*figure :
       {&MeasuredError::max, &MeasuredError::rms, &MeasuredError::p99, &MeasuredError::surfaceRms, &MeasuredError::skyRmse})
    EXPECT_EQ(tampered([&](Occluder& occluder) { occluder.error.*figure *= 0.9; }).exitCode, 5);
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.error.max *= 0.5; }).output, HasSubstr("states max "));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.error.seed += 1; }).output, HasSubstr("measured"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.error.samples = 0; }).output, HasSubstr("states no measured error"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.error.method.clear(); }).output, HasSubstr("bake it again"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.signMethod = "winding-number"; }).output, HasSubstr("sign method"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.lipschitz = 0.5; }).output, HasSubstr("states lipschitz"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.bounds.max.x += 0.1; }).output, HasSubstr("states bounds"));
  EXPECT_THAT(tampered([](Occluder& occluder) { occluder.contentHash[0] ^= 1; }).output, HasSubstr("content hash"));
  // The other mesh's volume under this one's name, with a hash that fits.
  const Occluder other = readScene(folder / "out/scene.gltf").value().nodes[1].occluder.value();
  EXPECT_EQ(tampered([&](Occluder& occluder) {
              occluder.uri = other.uri;
              occluder.contentHash = other.contentHash;
            }).exitCode,
            5);
}

TEST_F(BakeCommand, AnInterruptLeavesNothing) {
  const ShellResult stopped = bake("ring.off -o out --resolution 500 --threads 1 --quiet & p=$!; sleep 0.5; kill -TERM $p; wait $p");
  EXPECT_EQ(stopped.exitCode, 130) << stopped.output;
  EXPECT_FALSE(fs::exists(folder / "out"));
}

// Killed at any moment, the folder holds a scene that validates, or between two renames none.
TEST_F(BakeCommand, AKilledBakeLeavesNoTornScene) {
  ASSERT_EQ(bake("ball.off -o out").exitCode, 0);
  const auto bakeOther = [&](int i) {
    const char* inputs = i % 2 ? "ball.off" : "ring.off bowl.off";
    return fmt::format("{} -o out --resolution {} --error-samples 100 --quiet", inputs, 8 + i % 3);
  };
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(bake(bakeOther(0)).exitCode, 0);
  const double whole = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  constexpr int kMoments = 48;
  int replaced = 0;
  for (int i = 1; i <= kMoments; ++i) {
    const std::string before = contents(folder / "out/scene.gltf");
    // Most of the moments near the end, where the scene is written.
    const double moment = whole * (0.2 + 0.9 * std::sqrt(static_cast<double>(i) / kMoments));
    bake(fmt::format("{} & p=$!; sleep {:.4f}; kill -9 $p; wait $p", bakeOther(i), moment));
    ASSERT_TRUE(fs::exists(folder / "out/scene.gltf")) << "killed after " << moment << " s";
    const ShellResult checked = bake("validate out/scene.gltf");
    EXPECT_EQ(checked.exitCode, 0) << "killed after " << moment << " s: " << checked.output;
    replaced += contents(folder / "out/scene.gltf") != before;
  }
  EXPECT_GT(replaced, 0) << "every bake was killed too early";
  EXPECT_LT(replaced, kMoments) << "no bake was killed";
  ASSERT_EQ(bake(bakeOther(0)).exitCode, 0);
  const auto binaries = std::count_if(fs::directory_iterator(folder / "out"), fs::directory_iterator(),
                                      [](const fs::directory_entry& entry) { return entry.path().extension() == ".bin"; });
  EXPECT_EQ(binaries, 1) << "what killed bakes left is removed";
}

// Every mesh of the shared folder in two commands: no signal, no hang, and what was baked validates.
TEST_F(BakeCommand, RealDirtyMeshesBakeOrAreNamed) {
  const fs::path shared = fs::path(OVERCAST_SOURCE_FOLDER).parent_path() / "shared/meshes";
  if (!fs::exists(shared)) GTEST_SKIP() << "no folder " << shared;
  for (const char* kind : {"dirty", "malformed"}) {
    std::string files;
    for (const auto& entry : fs::directory_iterator(shared / kind))
      if (isMeshFile(entry.path())) files += fmt::format(" {}", quoted(entry.path().string()));
    const ShellResult baked = bake(fmt::format("{} -o {} --resolution 16 --error-samples 500 --quiet --keep-going", files, kind));
    EXPECT_EQ(baked.exitCode, 6) << baked.output;
    EXPECT_EQ(bake(fmt::format("validate {}/scene.gltf", kind)).exitCode, 0);
  }
}

}  // namespace
}  // namespace overcast::test
