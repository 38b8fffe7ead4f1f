// The README's table of volumes: one row per mesh, errors against brute force, bad files named and passed over.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/mesh.h"
#include "tests/commands/scratch.h"
#include "tests/commands/shell.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

const std::filesystem::path kCommand = std::filesystem::path(OVERCAST_BINARY_FOLDER) / "overcast-bench-volumes";

test::ShellResult bench(const std::filesystem::path& folder, const std::string& arguments) {
  return test::shell(fmt::format("{} {} {}", test::quoted(kCommand.string()), test::quoted(folder.string()), arguments));
}

std::filesystem::path folderOfMeshes() {
  const auto folder = test::scratchFolder();
  EXPECT_TRUE(writeOff(folder / "a torus.off", reference::torusMesh(1.0, 0.4, 40, 20)));
  EXPECT_TRUE(writeOff(folder / "far away.off", reference::moved(reference::boxMesh({1, 2, 3}), {1e5, -1e5, 1e5})));
  std::ofstream(folder / "broken.ply") << "ply\nformat ascii 1.0\nelement vertex 9\n";
  std::ofstream(folder / "notes.txt") << "not a mesh\n";
  return folder;
}

TEST(BenchVolumes, measuresEveryMeshAgainstTheTruth) {
  const auto result = bench(folderOfMeshes(), "--resolution 24 --points 3000 --seed 5 --json");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  const auto table = nlohmann::json::parse(result.output);
  ASSERT_EQ(table["meshes"].size(), 3u);
  const auto& torus = table["meshes"][0];
  EXPECT_EQ(torus["mesh"], "a torus.off");
  EXPECT_EQ(torus["faces"], 1600);
  EXPECT_NE(table["meshes"][1].value("error", ""), "");
  for (const auto& row : {torus, table["meshes"][2], table["total"]}) {
    // Half floats hold 11 bits: at most 12 voxels away that is a hundredth of a voxel.
    EXPECT_LT(row["at_samples_voxels"]["max"], 0.01) << row;
    EXPECT_EQ(row["at_samples_voxels"]["sign_errors"], 0) << row;
    EXPECT_GT(row["between_samples_voxels"]["max"], row["at_samples_voxels"]["max"]) << row;
    EXPECT_LT(row["between_samples_voxels"]["rms"], 0.1) << row;
  }
  EXPECT_EQ(table["total"]["faces"], 1612);
}

TEST(BenchVolumes, printsATableWithReasonsForBadFiles) {
  const auto result = bench(folderOfMeshes(), "--resolution 16 --points 100");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  EXPECT_NE(result.output.find("| a torus.off | 1600 |"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("| broken.ply | | |"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("| all 2 | 1612 |"), std::string::npos) << result.output;
}

TEST(BenchVolumes, aFolderWithoutMeshesIsAnError) {
  const auto result = bench(test::scratchFolder(), "");
  EXPECT_EQ(result.exitCode, 1);
  EXPECT_NE(result.output.find("holds no"), std::string::npos);
}

}  // namespace
}  // namespace overcast
