#include "formats/scene.h"

#include <filesystem>

#include <gtest/gtest.h>

namespace overcast {
namespace {

Mesh tetrahedron() {
  Mesh mesh;
  mesh.name = "tetrahedron";
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TEST(Scene, AMeshSurvivesWritingAndReading) {
  const auto path = std::filesystem::temp_directory_path() / "overcast_scene_test" / "tetrahedron.gltf";
  const Scene scene = sceneFromMesh(tetrahedron());
  auto written = writeScene(path, scene);
  ASSERT_TRUE(written) << message(written.error());
  auto read = readScene(path);
  ASSERT_TRUE(read) << message(read.error());
  ASSERT_EQ(read.value().meshes.size(), 1u);
  EXPECT_EQ(read.value().meshes[0].triangles.size(), 4u);
  EXPECT_EQ(read.value().meshes[0].positions.size(), 12u) << "all edges are creases, so every corner has its own normal";
  std::filesystem::remove_all(path.parent_path());
}

}  // namespace
}  // namespace overcast
