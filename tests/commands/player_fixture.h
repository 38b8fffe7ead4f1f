// Player fixture: a scratch folder, and overcast-player run in it on lavapipe.
#pragma once

#include <glob.h>

#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/commands/scratch.h"
#include "tests/commands/shell.h"

namespace overcast::test {

class PlayerFixture : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = scratchFolder();
    glob_t found{};
    if (glob("/usr/share/vulkan/icd.d/lvp_icd*.json", 0, nullptr, &found) == 0) driver = found.gl_pathv[0];
    globfree(&found);
  }
  /// Runs the player on lavapipe with a cache of its own.
  ShellResult play(const std::string& arguments) const {
    return shell(fmt::format("VK_DRIVER_FILES={} XDG_RUNTIME_DIR={} XDG_CACHE_HOME={} {}/overcast-player {}", quoted(driver),
                             quoted(folder.string()), quoted((folder.parent_path() / "player cache").string()),
                             quoted(OVERCAST_BINARY_FOLDER), arguments),
                 folder);
  }

  std::filesystem::path folder;
  std::string driver;
};

}  // namespace overcast::test
