// The command `./run`: what it says, and how it sets a machine up. Package tools are replaced by scripts that write down what they are
// asked.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/commands/scratch.h"
#include "tests/commands/shell.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

void writeScript(const fs::path& file, const std::string& body) {
  std::ofstream(file) << "#!/bin/bash\n" << body << "\n";
  fs::permissions(file, fs::perms::owner_all);
}

std::string contents(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// A copy of `run` in a folder with a space in its name, beside a folder `tools` that is searched before the system's own.
class Run : public testing::Test {
 protected:
  void SetUp() override {
    folder = scratchFolder();
    fs::create_directories(folder / ".ci");
    fs::create_directories(folder / "tools");
    fs::copy_file(fs::path(OVERCAST_SOURCE_FOLDER) / "run", folder / "run");
    std::ofstream(folder / ".ci/packages.txt") << "# a comment\npresent-dev\n\nabsent-dev\nabsent-tool fuzz\n";
    writeScript(folder / "tools/sudo", "while [[ $1 == -* ]]; do shift; done; exec \"$@\"");
    writeScript(folder / "tools/apt-get", "echo \"$@\" >> \"" + (folder / "asked").string() + "\"");
    packagesAre("echo 'installed present-dev'");
  }

  void packagesAre(const std::string& answer) { writeScript(folder / "tools/dpkg-query", answer); }

  ShellResult run(const std::string& arguments) {
    return shell("unset OVERCAST_SKIP_SETUP; PATH=" + quoted((folder / "tools").string()) + ":$PATH " + quoted((folder / "run").string()) +
                 " " + arguments);
  }

  std::string askedOfApt() { return contents(folder / "asked"); }

  fs::path folder;
};

TEST_F(Run, AloneExplainsEveryCommand) {
  const auto result = run("");
  EXPECT_EQ(result.exitCode, 0);
  for (const char* command : {"demo", "test", "setup", "build", "table", "bench", "golden", "data", "fuzz", "format", "tidy"})
    EXPECT_THAT(result.output, HasSubstr(std::string("./run ") + command));
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 140u) << line;
}

TEST_F(Run, RefusesAnUnknownCommand) {
  const auto result = run("fly");
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_EQ(result.output, "run: no command 'fly'; ./run alone lists them\n");
}

TEST_F(Run, SetupInstallsOnlyWhatIsMissingAndSaysSoFirst) {
  const auto result = run("setup");
  EXPECT_EQ(result.exitCode, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("absent-dev"));
  EXPECT_THAT(askedOfApt(), HasSubstr("install --no-install-recommends absent-dev"));
  EXPECT_THAT(askedOfApt(), Not(HasSubstr("present-dev")));
  EXPECT_THAT(askedOfApt(), Not(HasSubstr("absent-tool"))) << "only ./run fuzz needs it";
  EXPECT_THAT(askedOfApt(), Not(HasSubstr("update"))) << "the package lists were good enough";
}

TEST_F(Run, SetupTouchesNothingWhenAllIsThere) {
  packagesAre("printf 'installed %s\\n' present-dev absent-dev");
  const auto result = run("setup");
  EXPECT_EQ(result.exitCode, 0);
  EXPECT_EQ(result.output, "setup: all packages are there\n");
  EXPECT_FALSE(fs::exists(folder / "asked"));
}

TEST_F(Run, SetupCountsRemovedPackagesAsMissing) {
  packagesAre("echo 'installed present-dev'; echo 'config-files absent-dev'; exit 1");
  EXPECT_EQ(run("setup").exitCode, 0);
  EXPECT_THAT(askedOfApt(), HasSubstr("absent-dev"));
}

TEST_F(Run, SetupFetchesTheListsWhenTheyAreStale) {
  writeScript(folder / "tools/apt-get", "echo \"$@\" >> \"" + (folder / "asked").string() + "\"; [[ $* == *update* ]] && touch \"" +
                                            (folder / "fresh").string() + "\"; [[ -e \"" + (folder / "fresh").string() + "\" ]]");
  const auto result = run("setup");
  EXPECT_EQ(result.exitCode, 0) << result.output;
  EXPECT_THAT(askedOfApt(), HasSubstr("update"));
}

TEST_F(Run, SetupSaysWhenPackagesCannotBeInstalled) {
  writeScript(folder / "tools/apt-get", "exit 100");
  const auto result = run("setup");
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_THAT(result.output, HasSubstr("run: could not install the packages"));
}

TEST_F(Run, SetupSaysWhenThisIsNotDebian) {
  fs::remove(folder / "tools/dpkg-query");
  for (const char* tool : {"bash", "env", "dirname", "awk"}) {
    const auto where = shell(std::string("command -v ") + tool).output;
    fs::create_symlink(where.substr(0, where.find('\n')), folder / "tools" / tool);
  }
  const auto result =
      shell("unset OVERCAST_SKIP_SETUP; PATH=" + quoted((folder / "tools").string()) + " " + quoted((folder / "run").string()) + " setup");
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_THAT(result.output, HasSubstr("this is not Debian"));
  EXPECT_THAT(result.output, HasSubstr(".ci/packages.txt"));
}

TEST_F(Run, SetupCanBeLeftOut) {
  const auto result = shell("OVERCAST_SKIP_SETUP=1 " + quoted((folder / "run").string()) + " setup");
  EXPECT_EQ(result.exitCode, 0);
  EXPECT_EQ(result.output, "");
}

}  // namespace
}  // namespace overcast::test
