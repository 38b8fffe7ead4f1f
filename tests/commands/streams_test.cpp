// What the commands do when nobody listens, and when names hold what a terminal or a URI would misread.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/mesh.h"
#include "formats/scene.h"
#include "tests/commands/scratch.h"
#include "tests/commands/shell.h"
#include "tests/reference/shapes.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Streams : public testing::Test {
 protected:
  void SetUp() override {
    folder = scratchFolder();
    ASSERT_TRUE(writeOff(folder / "ball.off", reference::icosphere(1.0, 2)).ok());
  }
  ShellResult bake(const std::string& arguments) const { return run("overcast-bake", arguments); }
  ShellResult play(const std::string& arguments) const { return run("overcast-player", arguments); }
  ShellResult run(const std::string& program, const std::string& arguments) const {
    return shell(fmt::format("{} {}", quoted(OVERCAST_BINARY_FOLDER "/" + program), arguments), folder);
  }
  bool isValid(const std::string& scene) const { return bake("validate " + quoted(scene)).exitCode == 0; }

  fs::path folder;
};

TEST_F(Streams, MessagesThatNobodyHearsStopNoBake) {
  for (const char* stderrOf : {"2> /dev/full", "2>&-", "<&- >&- 2>&-"}) {
    fs::remove_all(folder / "out");
    EXPECT_EQ(bake(fmt::format("ball.off -o out {}", stderrOf)).exitCode, 0) << stderrOf;
    EXPECT_TRUE(isValid("out/scene.gltf")) << stderrOf;
    EXPECT_EQ(bake(fmt::format("absent.off -o out {}", stderrOf)).exitCode, 3) << stderrOf;
    EXPECT_EQ(play(fmt::format("absent.gltf --nonsense {}", stderrOf)).exitCode, 2) << stderrOf;
  }
}

TEST_F(Streams, AResultThatNobodyReceivesIsAnError) {
  for (const char* arguments :
       {"ball.off -o out", "ball.off -o out --json", "inspect ball.off", "inspect --json ball.off", "--help", "--version"}) {
    const ShellResult result = bake(std::string(arguments) + " > /dev/full");
    EXPECT_EQ(result.exitCode, 4) << arguments;
    EXPECT_THAT(result.output, HasSubstr("overcast-bake: stdout: cannot be written")) << arguments;
  }
  EXPECT_TRUE(isValid("out/scene.gltf"));
  const ShellResult help = play("--help > /dev/full");
  EXPECT_EQ(help.exitCode, 4);
  EXPECT_THAT(help.output, HasSubstr("overcast-player: stdout: cannot be written"));
}

TEST_F(Streams, NamesReachTheTerminalWithoutControlCharacters) {
  const std::string name = "two\nlines \x1b[31mred.off";
  fs::rename(folder / "ball.off", folder / name);
  const std::string file = quoted(name);
  // The bake says a line of the mesh and one of the run.
  for (const auto& [arguments, lines] : std::map<std::string, int>{
           {file + " -o out > list", 2}, {"inspect " + quoted("absent" + name), 1}, {"absent" + file + " -o out", 1}}) {
    const ShellResult result = bake(arguments);
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), lines) << arguments << ": " << result.output;
    EXPECT_EQ(result.output.find('\x1b'), std::string::npos) << arguments;
  }
  EXPECT_TRUE(isValid("out/scene.gltf"));
}

// The scene's name becomes a URI of its .bin: what comes back must be the same name.
TEST_F(Streams, ScenesOfAnyNameOpenAgain) {
  for (const std::string name : {"100%", "a%41b", "per%zz", "sharp # question ?", "12:30", "\xc3\xbc \xe6\x97\xa5"}) {
    const ShellResult baked = bake(fmt::format("ball.off -o out --name {}", quoted(name)));
    ASSERT_EQ(baked.exitCode, 0) << baked.output;
    const ShellResult checked = bake("validate " + quoted("out/" + name + ".gltf"));
    EXPECT_EQ(checked.exitCode, 0) << checked.output;
    EXPECT_TRUE(readScene(folder / "out" / (name + ".gltf")).ok()) << name;
  }
}

TEST_F(Streams, WrongArgumentsGetOneShortLine) {
  const auto expectOneLine = [](const ShellResult& result, const std::string& start) {
    EXPECT_EQ(result.exitCode, 2) << result.output;
    EXPECT_TRUE(result.output.starts_with(start)) << result.output;
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
    EXPECT_LT(result.output.size(), 200u) << result.output;
  };
  for (const char* arguments : {"ball.off", "ball.off -o ''", "ball.off -o out --voxel-size 0", "ball.off -o out --voxel-size -1",
                                "ball.off -o out --voxel-size nan", "ball.off -o out --voxel-size inf", "ball.off -o out --voxel-size x"})
    expectOneLine(bake(arguments), "overcast-bake: ");
  EXPECT_FALSE(fs::exists(folder / "scene.gltf"));
  for (const char* arguments : {"", "--headless", "x.gltf --headless --size 0x0", "x.gltf --frames 5:1", "x.gltf --nonsense"})
    expectOneLine(play(arguments), "overcast-player: ");
}

}  // namespace
}  // namespace overcast::test
