// Scratch: a folder of its own for the running test.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace overcast::test {

/// An empty folder of the running test, with a space in its name, below the build.
inline std::filesystem::path scratchFolder() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const auto folder =
      std::filesystem::path(OVERCAST_BINARY_FOLDER).parent_path() / "scratch" / (std::string(info->test_suite_name()) + " " + info->name());
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

}  // namespace overcast::test
