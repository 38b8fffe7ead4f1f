// overcast-bake on many inputs: cache, --each and its resumption, depfiles, dry runs, presets, configs, memory.
#include <chrono>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/mesh.h"
#include "formats/scene.h"
#include "tests/commands/bake_fixture.h"
#include "tests/reference/shapes.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

const std::string kQuick = "--resolution 8 --error-samples 50";

class ScaleCommand : public BakeFixture {
 protected:
  /// Boxes of different sizes in `library` and a folder below it; every tenth is the same as the one before.
  void writeLibrary(int count) {
    for (int i = 0; i < count; ++i) {
      const double size = 1.0 + 0.01 * (i % 10 == 9 ? i - 1 : i);
      write(fmt::format("library/{}box{:03}.off", i % 3 == 0 ? "more/" : "", i), reference::boxMesh(glm::dvec3(1.0, size, 2.0)));
    }
  }
  /// The JSON document of a bake that succeeds.
  json bakeJson(const std::string& arguments) const {
    const ShellResult baked = bake(arguments + " --json 2>messages");
    EXPECT_EQ(baked.exitCode, 0) << contents(folder / "messages");
    return json::parse(baked.output, nullptr, false);
  }
};

/// Whether two folders hold the same files; says which differ, not what is in them.
void expectSameFiles(const std::map<std::string, std::string>& found, const std::map<std::string, std::string>& expected) {
  for (const auto& [path, content] : expected) {
    const auto other = found.find(path);
    EXPECT_TRUE(other != found.end() && other->second == content) << path << (other == found.end() ? " is missing" : " differs");
  }
  for (const auto& [path, content] : found) EXPECT_TRUE(expected.contains(path)) << path << " should not be there";
}

/// A document without what may differ from run to run.
json timeless(json document) {
  for (const char* key : {"seconds", "peakMemory", "memoryLimit", "meshesBaked", "meshesCached", "inputsUpToDate", "files"})
    document.erase(key);
  for (json& input : document["inputs"])
    for (json& mesh : input["meshes"])
      for (const char* key : {"seconds", "cached"}) mesh.erase(key);
  return document;
}

TEST_F(ScaleCommand, ACachedBakeIsTheSameToTheLastBit) {
  for (const char* settings : {"--resolution 16", "--max-error 0.02 --largest 32", "--preset preview"}) {
    fs::remove_all(folder / "cache");
    for (const char* out : {"none", "cold", "warm", "moved"}) fs::remove_all(folder / out);
    const std::string inputs = fmt::format("ball.off bowl.off ring.off {} --error-samples 500", settings);
    const json none = bakeJson(inputs + " -o none");
    const json cold = bakeJson(inputs + " -o cold --cache cache");
    const json warm = bakeJson(inputs + " -o warm --cache cache");
    const json again = bakeJson(inputs + " -o warm --cache cache --threads 1");
    expectSameFiles(filesIn("none"), filesIn("cold"));
    expectSameFiles(filesIn("none"), filesIn("warm"));
    EXPECT_EQ(timeless(none), timeless(cold));
    EXPECT_EQ(timeless(none), timeless(warm));
    EXPECT_EQ(timeless(none), timeless(again));
    EXPECT_EQ(cold["meshesBaked"], 3);
    EXPECT_EQ(warm["meshesCached"], 3);
    EXPECT_EQ(warm["meshesBaked"], 0);
    EXPECT_EQ(warm["inputsUpToDate"], 0);
    EXPECT_EQ(again["inputsUpToDate"], 3);
    // One mesh more: the others come from the cache although the scene is a new one.
    const json more = bakeJson(fmt::format("ring.off ball.off {} --error-samples 500 -o moved --cache cache", settings));
    EXPECT_EQ(more["meshesCached"], 2);
    EXPECT_EQ(more["inputs"][1]["meshes"][0]["occluder"], none["inputs"][0]["meshes"][0]["occluder"]);
    EXPECT_EQ(bake("validate moved/scene.gltf").exitCode, 0);
    EXPECT_EQ(bake("verify moved/scene.gltf --source ring.off ball.off").exitCode, 0);
  }
}

TEST_F(ScaleCommand, NotesComeBackFromTheCache) {
  const auto notes = [&](const char* out) {
    EXPECT_EQ(bake(fmt::format("bowl.off {} -o {} --cache cache 2>messages", kQuick, out)).exitCode, 0);
    std::istringstream lines(contents(folder / "messages"));
    std::vector<std::string> found;
    for (std::string line; std::getline(lines, line);)
      if (line.find(": note: ") != std::string::npos) found.push_back(line);
    return found;
  };
  const auto cold = notes("a");
  EXPECT_FALSE(cold.empty());
  EXPECT_EQ(notes("b"), cold);
}

// What decides a result is in its key: input bytes, every setting, the names that the output repeats.
TEST_F(ScaleCommand, WhatChangesTheResultMissesTheCache) {
  ASSERT_EQ(bakeJson("ball.off -o out --cache cache --resolution 12")["meshesBaked"], 1);
  for (const char* settings :
       {"--resolution 13", "--resolution 12 --padding 3", "--resolution 12 --bits 32", "--resolution 12 --seed 2",
        "--resolution 12 --error-samples 100", "--voxel-size 0.3", "--max-error 0.05", "--max-error 0.06", "--max-error 0.05 --largest 16",
        "--max-sky-error 0.3", "--max-bytes 20000", "--representation volume --max-error 0.05"}) {
    const std::string arguments = fmt::format("ball.off -o other --cache cache {}", settings);
    EXPECT_EQ(bakeJson(arguments)["meshesBaked"], 1) << settings;
    EXPECT_EQ(bakeJson(arguments)["inputsUpToDate"], 1) << settings;
  }
  const json renamed = bakeJson("ball.off -o out --cache cache --resolution 12 --name other");
  EXPECT_EQ(renamed["meshesCached"], 1);
  EXPECT_TRUE(fs::exists(folder / "out/other.gltf"));
  fs::rename(folder / "ball.off", folder / "sphere.off");
  EXPECT_EQ(bakeJson("sphere.off -o out --cache cache --resolution 12")["meshesCached"], 1);
  EXPECT_EQ(readScene(folder / "out/scene.gltf").value().nodes[0].name, "sphere");
  write("sphere.off", reference::icosphere(1.5, 3));
  EXPECT_EQ(bakeJson("sphere.off -o out --cache cache --resolution 12")["meshesBaked"], 1);
}

// A glTF's buffers are inputs too.
TEST_F(ScaleCommand, AChangedBufferIsBakedAgain) {
  ASSERT_EQ(bake(fmt::format("ball.off {} -o source --name pair", kQuick)).exitCode, 0);
  fs::path binary;
  for (const auto& entry : fs::directory_iterator(folder / "source"))
    if (entry.path().extension() == ".bin") binary = entry.path();
  const std::string command = fmt::format("source/pair.gltf {} -o out --cache cache --depfile out.d", kQuick);
  EXPECT_EQ(bakeJson(command)["meshesBaked"], 1);
  EXPECT_EQ(bakeJson(command)["inputsUpToDate"], 1);
  EXPECT_THAT(contents(folder / "out.d"), HasSubstr(binary.filename().string()));
  std::string bytes = contents(binary);
  bytes[7] = static_cast<char>(bytes[7] ^ 0x01);  // an exponent bit of the first position
  std::ofstream(binary, std::ios::binary) << bytes;
  EXPECT_EQ(bakeJson(command)["meshesBaked"], 1);
}

TEST_F(ScaleCommand, ADamagedCacheOnlyCostsABake) {
  const std::string command = fmt::format("ball.off ring.off {} --cache cache -o ", kQuick);
  ASSERT_EQ(bake(command + "a").exitCode, 0);
  const auto damageAll = [&](auto damage) {
    for (const auto& entry : fs::recursive_directory_iterator(folder / "cache/v1"))
      if (entry.is_regular_file()) damage(entry.path(), contents(entry.path()));
  };
  const auto check = [&](const char* out, bool noted) {
    const ShellResult baked = bake(command + out);
    EXPECT_EQ(baked.exitCode, 0);
    EXPECT_EQ(baked.output.find("is damaged; baking again") != std::string::npos, noted) << baked.output;
    expectSameFiles(filesIn("a"), filesIn(out));
  };
  damageAll([](const fs::path& file, const std::string& whole) { fs::resize_file(file, whole.size() / 2); });
  check("b", true);
  damageAll([](const fs::path& file, std::string whole) {
    whole[whole.size() / 2] = static_cast<char>(whole[whole.size() / 2] ^ 8);
    std::ofstream(file, std::ios::binary) << whole;
  });
  check("c", true);
  damageAll([](const fs::path& file, const std::string&) {
    if (file.string().find("objects") != std::string::npos) fs::remove(file);
  });
  check("d", false);  // as after --cache-limit
  fs::remove_all(folder / "cache");
  check("e", false);
}

TEST_F(ScaleCommand, TheLimitHolds) {
  for (int i = 0; i < 8; ++i)
    ASSERT_EQ(
        bake(fmt::format("ball.off --resolution {} --error-samples 0 -o out --cache cache --cache-limit 200K --quiet", 16 + i)).exitCode,
        0);
  std::uintmax_t total = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "cache/v1"))
    if (entry.is_regular_file()) total += entry.file_size();
  EXPECT_LE(total, 200u << 10);
  EXPECT_GT(total, 0u);
}

TEST_F(ScaleCommand, ProcessesShareACache) {
  writeLibrary(12);
  ASSERT_EQ(bake(fmt::format("library --each -o alone {} --quiet > /dev/null", kQuick)).exitCode, 0);
  const ShellResult all = bake(fmt::format(
      "--version; for i in 1 2 3 4; do {} library --each -o out$i --cache cache {} --quiet > /dev/null & done; wait", kBake, kQuick));
  EXPECT_THAT(all.output, Not(HasSubstr("overcast-bake:")));
  for (const char* out : {"out1", "out2", "out3", "out4"}) expectSameFiles(filesIn(out), filesIn("alone"));
}

// Each input becomes what a command for it alone makes.
TEST_F(ScaleCommand, EachInputIsBakedOnItsOwn) {
  write("library/a.off", reference::icosphere(1.0, 2));
  write("library/more/b.off", reference::torusMesh(1.0, 0.3, 12, 8));
  ASSERT_EQ(bake(fmt::format("ball.off {} -o library/deep --name truck", kQuick)).exitCode, 0);
  const ShellResult baked = bake(fmt::format("library --each {} -o out --quiet", kQuick));
  EXPECT_EQ(baked.exitCode, 0) << baked.output;
  EXPECT_EQ(baked.output, "out/a/scene.gltf\nout/deep/truck/truck.gltf\nout/more/b/scene.gltf\n");
  for (const auto& [input, name] :
       std::map<std::string, std::string>{{"a.off", "a"}, {"deep/truck.gltf", "deep/truck"}, {"more/b.off", "more/b"}}) {
    ASSERT_EQ(bake(fmt::format("library/{} {} -o alone/{} --quiet", input, kQuick, name)).exitCode, 0);
    expectSameFiles(filesIn("out/" + name), filesIn("alone/" + name));
  }
  // The output folder is no input, wherever it lies.
  ASSERT_EQ(bake(fmt::format("library --each {} -o library/baked --quiet", kQuick)).exitCode, 0);
  EXPECT_EQ(bake(fmt::format("library --each {} -o library/baked --quiet", kQuick)).output,
            "library/baked/a/scene.gltf\nlibrary/baked/deep/truck/truck.gltf\nlibrary/baked/more/b/scene.gltf\n");
}

TEST_F(ScaleCommand, EachNamesWhatFailedAndBakesTheRest) {
  std::ofstream(folder / "list.txt") << "# some\nball.off\nbroken.off\n\nmissing.off\nring.off\nball.off\n";
  const ShellResult baked = bake(fmt::format("@list.txt --each {} -o out --json 2>messages", kQuick));
  EXPECT_EQ(baked.exitCode, 6);
  const std::string messages = contents(folder / "messages");
  EXPECT_THAT(messages, HasSubstr("overcast-bake: broken.off: "));
  EXPECT_THAT(messages, HasSubstr("overcast-bake: missing.off: "));
  EXPECT_THAT(messages, Not(HasSubstr("4 inputs"))) << "the document says it";
  EXPECT_THAT(bake(fmt::format("@list.txt --each {} -o again", kQuick)).output,
              HasSubstr("4 inputs: 2 meshes baked, 0 from the cache, 0 inputs up to date, 2 failed; "));
  const json document = json::parse(baked.output);
  EXPECT_EQ(document["inputs"].size(), 4u);
  EXPECT_EQ(document["inputs"][1]["errors"].size(), 1u);
  EXPECT_EQ(document["inputsFailed"], 2);
  EXPECT_GT(document["peakMemory"], 1 << 20);
  EXPECT_EQ(bake(fmt::format("broken.off missing.off --each {} -o none", kQuick)).exitCode, 3);
  EXPECT_EQ(bake(fmt::format("ball.off sub/ball.off --each {} -o two", kQuick)).exitCode, 6);  // two folders, one input missing
  EXPECT_EQ(bake(fmt::format("{0} ../{1}/ball.off --each {2} -o none", "ball.off", quoted(folder.filename().string()), kQuick)).exitCode,
            2);
}

TEST_F(ScaleCommand, WhatIsMissingOrChangedIsBakedAgain) {
  writeLibrary(10);
  const std::string command = fmt::format("library --each {} -o out", kQuick);
  const json first = bakeJson(command);
  EXPECT_EQ(first["meshesBaked"].get<int>() + first["meshesCached"].get<int>(), 10);
  EXPECT_EQ(first["meshesBaked"], 9) << "two of the ten are the same mesh";
  const auto whole = filesIn("out");
  EXPECT_EQ(bakeJson(command)["inputsUpToDate"], 10);
  fs::remove(folder / "out/box001/scene.gltf");
  std::ofstream(folder / "out/box002/scene.gltf", std::ios::app) << " ";
  for (const auto& entry : fs::directory_iterator(folder / "out/box004/volumes")) fs::resize_file(entry.path(), 10);
  fs::remove_all(folder / "out/box005");
  const json mended = bakeJson(command);
  EXPECT_EQ(mended["inputsUpToDate"], 6);
  EXPECT_EQ(mended["meshesBaked"], 0);
  expectSameFiles(filesIn("out"), whole);
  write("library/box001.off", reference::boxMesh(glm::dvec3(1.0, 7.0, 2.0)));
  const json changed = bakeJson(command);
  EXPECT_EQ(changed["meshesBaked"], 1);
  EXPECT_EQ(changed["inputsUpToDate"], 9);
  // The cache may go at any time.
  fs::remove_all(folder / "out/.overcast-cache");
  EXPECT_EQ(bakeJson(command)["meshesBaked"], 9);
}

// Killed at any moment and started again, it bakes nothing twice but what was under way, and ends with the same files.
TEST_F(ScaleCommand, AKilledLibraryResumes) {
  constexpr int kMeshes = 240;
  constexpr int kThreads = 2;
  writeLibrary(kMeshes);
  const std::string settings = "--max-error 0.02 --largest 24 --error-samples 400 --representation volume";
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(bakeJson(fmt::format("library --each {} -o whole --threads {}", settings, kThreads))["inputsFailed"], 0);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  std::set<std::string> finished;
  const auto finishedNow = [&] {
    std::set<std::string> scenes;
    for (const auto& [path, content] : filesIn("out"))
      if (path.ends_with(".gltf")) scenes.insert(path);
    return scenes;
  };
  int kills = 0;
  for (; kills < 12 && finished.size() < kMeshes; ++kills) {
    const auto before = finished;
    const ShellResult killed =
        bake(fmt::format("library --each {} -o out --threads {} --quiet > /dev/null & p=$!; sleep {:.3f}; kill -9 $p; wait $p", settings,
                         kThreads, 0.15 + seconds * 0.07 * (1 + kills % 3)));
    finished = finishedNow();
    EXPECT_TRUE(std::includes(finished.begin(), finished.end(), before.begin(), before.end()));
    for (const std::string& scene : finished)
      EXPECT_EQ(contents(folder / "out" / scene), contents(folder / "whole" / scene)) << "torn by kill " << kills;
  }
  EXPECT_GT(kills, 2) << "the kills came too late to find anything";
  EXPECT_GT(finished.size(), 20u) << "the kills came too early to leave anything";
  const json last = bakeJson(fmt::format("library --each {} -o out --threads {}", settings, kThreads));
  // Scenes on disk are up to date but for those whose record had not been stored: at most what was under way at each kill.
  EXPECT_GE(last["inputsUpToDate"].get<int>() + kills * kThreads, static_cast<int>(finished.size()));
  EXPECT_LE(last["meshesBaked"].get<int>(), kMeshes - static_cast<int>(finished.size()));
  expectSameFiles(filesIn("out"), filesIn("whole"));
}

TEST_F(ScaleCommand, DepfilesDriveMakeAndNinja) {
  fs::create_directories(folder / "in put");
  fs::copy_file(folder / "ball.off", folder / "in put/a#b $c.off");
  std::ofstream(folder / "config.json") << R"({"version": 1, "settings": {"resolution": 8, "errorSamples": 10}})";
  std::ofstream(folder / "bake.sh") << "echo ran >> runs\nexec " << kBake
                                    << " 'in put/a#b $c.off' ring.off --config config.json -o out --depfile out.d --quiet > /dev/null\n";
  std::ofstream(folder / "Makefile") << "out/scene.gltf:\n\tsh bake.sh\n-include out.d\n";
  std::ofstream(folder / "build.ninja") << "rule bake\n  command = sh bake.sh\n  depfile = out.d\nbuild out/scene.gltf: bake\n";
  for (const char* tool : {"make", "ninja"}) {
    if (shell(fmt::format("command -v {}", tool)).exitCode != 0) continue;
    fs::remove_all(folder / "out");
    fs::remove(folder / "out.d");
    const auto runsAfter = [&](const fs::path& touched) {
      fs::remove(folder / "runs");
      if (!touched.empty()) fs::last_write_time(folder / touched, fs::file_time_type::clock::now() + std::chrono::seconds(2));
      const ShellResult built = shell(tool, folder);
      EXPECT_EQ(built.exitCode, 0) << tool << ": " << built.output;
      const bool ran = fs::exists(folder / "runs");
      if (!touched.empty()) fs::last_write_time(folder / touched, fs::file_time_type::clock::now() - std::chrono::hours(1));
      return ran;
    };
    EXPECT_TRUE(runsAfter("")) << tool;
    EXPECT_FALSE(runsAfter("")) << tool;
    for (const char* input : {"in put/a#b $c.off", "ring.off", "config.json"}) {
      EXPECT_TRUE(runsAfter(input)) << tool << " " << input;
      EXPECT_FALSE(runsAfter("")) << tool << " " << input;
    }
    EXPECT_FALSE(runsAfter("bowl.off")) << tool;
  }
  // Without a change nothing is baked, yet make is content: the scene's time is renewed.
  const std::string cached = "ball.off --resolution 8 -o cached --cache cache --quiet";
  ASSERT_EQ(bake(cached).exitCode, 0);
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(1);
  fs::last_write_time(folder / "cached/scene.gltf", old);
  ASSERT_EQ(bake(cached).exitCode, 0);
  EXPECT_GT(fs::last_write_time(folder / "cached/scene.gltf"), old);
}

TEST_F(ScaleCommand, ADryRunOnlySaysWhatARealOneWouldDo) {
  const std::string inputs = fmt::format("ball.off ring.off {} --cache cache", kQuick);
  ShellResult dry = bake(inputs + " -o out --dry-run --depfile out.d");
  EXPECT_EQ(dry.exitCode, 0);
  EXPECT_THAT(dry.output, HasSubstr("ball.off: 1,280 faces, would be baked\n"));
  EXPECT_THAT(dry.output, HasSubstr("\nout/scene.gltf\n"));
  for (const char* name : {"out", "cache", "out.d"}) EXPECT_FALSE(fs::exists(folder / name)) << name;
  ASSERT_EQ(bake(fmt::format("ball.off {} --cache cache -o other", kQuick)).exitCode, 0);
  const auto cacheBefore = filesIn("cache");
  dry = bake(inputs + " -o out --dry-run");
  EXPECT_THAT(dry.output, HasSubstr("ball.off: 1,280 faces, 8x8x8, cached"));
  EXPECT_THAT(dry.output, HasSubstr("ring.off: 1,024 faces, would be baked"));
  EXPECT_FALSE(fs::exists(folder / "out"));
  expectSameFiles(filesIn("cache"), cacheBefore);
  const json document = bakeJson(inputs + " -o out --dry-run");
  EXPECT_TRUE(document["dryRun"]);
  EXPECT_EQ(document["meshesBaked"], 1);
  EXPECT_EQ(document["meshesCached"], 1);
  EXPECT_EQ(bake("ball.off broken.off -o out --dry-run").exitCode, 3);
  EXPECT_EQ(bake("ball.off broken.off -o out --dry-run --keep-going").exitCode, 6);
  EXPECT_EQ(bake("ball.off broken.off -o out --dry-run --each").exitCode, 6);
  EXPECT_EQ(bake("ball.off -o ring.off --dry-run").exitCode, 4);
  EXPECT_EQ(bake("ball.off -o /proc/overcast --dry-run").exitCode, 4);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(ScaleCommand, PresetsAreExplainedAndWhatIsSaidBesideThemWins) {
  const std::string help = bake("bake --help").output;
  for (const char* words : {"preview: error at most 3 %", "game: error at most 1 %", "film: error at most 0.2 %"})
    EXPECT_THAT(help, HasSubstr(words));
  const auto choiceOf = [&](const std::string& options) {
    return bakeJson(fmt::format("ring.off -o out {}", options))["inputs"][0]["meshes"][0];
  };
  const json preview = choiceOf("--preset preview");
  EXPECT_EQ(preview["occluder"]["measured"]["samples"], 1024);
  EXPECT_LE(preview["occluder"]["measured"]["surfaceRms"].get<double>(), 0.03 * preview["choice"]["diagonal"].get<double>());
  EXPECT_EQ(choiceOf("--preset preview --error-samples 300")["occluder"]["measured"]["samples"], 300);
  EXPECT_EQ(choiceOf("--preset preview --resolution 20")["occluder"]["size"][0], 20);
  EXPECT_EQ(bake("ring.off -o none --preset cinema").exitCode, 2);
}

TEST_F(ScaleCommand, AConfigHasRulesAndTheCommandLineWins) {
  writeLibrary(4);
  std::ofstream(folder / "config.json") << R"({"version": 1, "settings": {"resolution": 10, "errorSamples": 20},
    "rules": [{"files": "more/*", "settings": {"resolution": 12}}, {"files": ["box003.off"], "settings": {"resolution": 14}}]})";
  const auto sizes = [&](const std::string& options) {
    std::map<std::string, int> found;
    const json document = bakeJson(fmt::format("library --each -o out --config config.json {}", options));
    for (const json& input : document["inputs"]) found[input["file"]] = input["meshes"][0]["occluder"]["size"][2];
    return found;
  };
  const std::map<std::string, int> byRule = {
      {"library/box001.off", 10}, {"library/box002.off", 10}, {"library/more/box000.off", 12}, {"library/more/box003.off", 14}};
  EXPECT_EQ(sizes(""), byRule);
  for (const auto& [file, size] : sizes("--resolution 9")) EXPECT_EQ(size, 9) << file;
  // In one scene of all inputs, too.
  const json joined = bakeJson("library -o joined --config config.json");
  for (const json& input : joined["inputs"]) EXPECT_EQ(input["meshes"][0]["occluder"]["size"][2], byRule.at(input["file"]));
  std::ofstream(folder / "config.json") << R"({"version": 1, "settings": {"resolutoin": 10}})";
  const ShellResult refused = bake("ball.off -o none --config config.json");
  EXPECT_EQ(refused.exitCode, 2);
  EXPECT_THAT(refused.output, testing::StartsWith("overcast-bake: config.json: settings/resolutoin: is not a key that is known here"));
  EXPECT_EQ(std::count(refused.output.begin(), refused.output.end(), '\n'), 1);
  EXPECT_EQ(bake("ball.off -o none --config missing.json").exitCode, 2);
  EXPECT_FALSE(fs::exists(folder / "none"));
}

// The limit is kept where it is above what one bake needs, and says so.
TEST_F(ScaleCommand, MemoryStaysWithinTheLimit) {
  for (int i = 0; i < 6; ++i) write(fmt::format("large/{}.off", i), reference::icosphere(1.0 + 0.1 * i, 6));
  const auto peak = [&](const std::string& options) {
    const json document = bakeJson(fmt::format("large --each --resolution 8 --error-samples 10 --threads 4 {}", options));
    return std::pair<std::uint64_t, std::uint64_t>(document["peakMemory"], document["memoryLimit"]);
  };
  const auto [narrow, limit] = peak("-o narrow --memory 150M");
  EXPECT_EQ(limit, 150u << 20);
  EXPECT_LE(narrow, limit);
  std::uint64_t wide = 0;  // on a busy machine bakes may miss each other a few times
  for (int attempt = 0; attempt < 5 && wide <= limit; ++attempt) {
    fs::remove_all(folder / "wide");
    wide = peak("-o wide").first;
  }
  EXPECT_GT(wide, limit) << "the limit is none";
  expectSameFiles(filesIn("narrow"), filesIn("wide"));
  EXPECT_EQ(bake("ball.off -o out --memory much").exitCode, 2);
}

/// The first code block of this kind in a section of the README.
std::string codeBlock(const std::string& section, const std::string& kind) {
  const std::string readme = contents(fs::path(OVERCAST_SOURCE_FOLDER) / "README.md");
  const std::size_t begin = readme.find(fmt::format("\n```{}\n", kind), readme.find(fmt::format("\n## {}\n", section)));
  const std::size_t first = readme.find('\n', begin + 1) + 1;
  return readme.substr(first, readme.find("\n```\n", first) + 1 - first);
}

TEST_F(ScaleCommand, TheReadmesExampleRuns) {
  writeLibrary(6);
  std::ofstream(folder / "list.txt") << "ring.off\nlibrary/more/box000.off\n";
  std::ofstream(folder / "bake.json") << codeBlock("A library of meshes", "json");
  std::istringstream commands(codeBlock("A library of meshes", ""));
  int count = 0;
  for (std::string command; std::getline(commands, command); ++count) {
    const ShellResult ran =
        shell(fmt::format("export HOME=$PWD PATH={}:$PATH; sh -c {}", quoted(std::string(OVERCAST_BINARY_FOLDER)), test::quoted(command)),
              folder);
    EXPECT_EQ(ran.exitCode, 0) << command << "\n" << ran.output;
    if (count == 1) {
      EXPECT_THAT(ran.output, HasSubstr("6 inputs up to date, 0 failed"));
    }
  }
  EXPECT_EQ(count, 4);
  EXPECT_TRUE(fs::exists(folder / "baked/library/more/box000/scene.gltf")) << "of the list";
  EXPECT_TRUE(fs::exists(folder / "baked.d"));
  EXPECT_FALSE(fs::exists(folder / "all"));
}

TEST_F(ScaleCommand, WrongArgumentsAreRefused) {
  for (const char* arguments :
       {"ball.off -o out --cache ''", "ball.off -o out --cache-limit -1", "ball.off -o out --cache-limit 3X", "ball.off -o out --memory 0",
        "ball.off -o out --memory 99999999999999T", "ball.off -o out --preset", "ball.off -o out --largest 7",
        "ball.off -o out --resolution 8 --largest 16", "ball.off -o out --depfile ''", "ball.off -o out --config broken.off"}) {
    EXPECT_EQ(bake(arguments).exitCode, 2) << arguments;
  }
  fs::create_directory(folder / "empty");
  EXPECT_EQ(bake("empty -o out").exitCode, 3);
  EXPECT_EQ(bake("@missing.txt -o out").exitCode, 3);
  EXPECT_EQ(bake("ball.off -o out --cache ring.off").exitCode, 4);
  EXPECT_EQ(bake("ball.off -o out --depfile ring.off/x.d").exitCode, 4);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

}  // namespace
}  // namespace overcast::test
