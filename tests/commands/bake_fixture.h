// Bake fixture: a scratch folder with a few meshes, and overcast-bake run in it.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "formats/mesh.h"
#include "tests/commands/scratch.h"
#include "tests/commands/scratch_files.h"
#include "tests/commands/shell.h"
#include "tests/reference/shapes.h"

namespace overcast::test {

const std::string kBake = quoted(std::string(OVERCAST_BINARY_FOLDER) + "/overcast-bake");

/// A closed ball and ring, a bowl with a hole, and a file that is no mesh.
class BakeFixture : public testing::Test {
 protected:
  void SetUp() override {
    folder = scratchFolder();
    write("ball.off", reference::icosphere(1.0, 3));
    write("ring.off", reference::torusMesh(1.0, 0.4, 32, 16));
    write("bowl.off", reference::withHoles(reference::icosphere(1.0, 3), 0.2, 4));
    std::ofstream(folder / "broken.off") << "OFF\n8 6 0\n0 0 0\n";
  }

  void write(const std::string& name, const Mesh& mesh) {
    std::filesystem::create_directories((folder / name).parent_path());
    ASSERT_TRUE(writeOff(folder / name, mesh).ok());
  }
  ShellResult bake(const std::string& arguments) const { return shell(fmt::format("{} {}", kBake, arguments), folder); }
  std::map<std::string, std::string> filesIn(const std::string& name) const { return everythingIn(folder / name); }

  std::filesystem::path folder;
};

}  // namespace overcast::test
