// Texture coordinates of OBJ files: which vertex gets which, and what leaves a mesh without.
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "formats/mesh.h"
#include "tests/formats/support.h"

namespace overcast {
namespace {

Mesh meshOf(const std::string& text) {
  const TemporaryFolder folder;
  std::ofstream(folder / "mesh.obj") << text;
  auto read = readMesh(folder / "mesh.obj");
  EXPECT_TRUE(read) << message(read.error());
  return read ? read.value().mesh : Mesh{};
}

/// Place and texture coordinate of every corner, as the file means them whatever the vertices are numbered.
std::vector<std::pair<glm::dvec3, glm::vec2>> cornersOf(const Mesh& mesh) {
  std::vector<std::pair<glm::dvec3, glm::vec2>> corners;
  for (const glm::uvec3& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) corners.emplace_back(mesh.positions[t[c]], mesh.textureCoordinates.at(t[c]));
  return corners;
}

const char* kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0.25\nvt 1 1\nvt 0 1\nvt 0.5 0.5\n";

TEST(ObjTextureCoordinates, GoToTheCornersThatNameThem) {
  const Mesh mesh = meshOf(std::string(kSquare) + "f 1/1 2/2 3/3\nf 1/1/7 3/5/7 4/4\n");
  ASSERT_EQ(mesh.positions.size(), 5u);  // one vertex has two
  const std::vector<std::pair<glm::dvec3, glm::vec2>> expected{{{0, 0, 0}, {0, 1}}, {{1, 0, 0}, {1, 0.75f}},   {{1, 1, 0}, {1, 0}},
                                                               {{0, 0, 0}, {0, 1}}, {{1, 1, 0}, {0.5f, 0.5f}}, {{0, 1, 0}, {0, 0}}};
  EXPECT_EQ(cornersOf(mesh), expected);
  EXPECT_EQ(cornersOf(meshOf(std::string(kSquare) + "f -4/-5 -3/-4 -2/-3\nf -4/-5 -2/-1 -1/-2\n")), expected);
}

TEST(ObjTextureCoordinates, EqualOnesShareAVertexAndFacesWithoutExtentDoNotDisturb) {
  const Mesh mesh = meshOf(std::string(kSquare) + "vt 0 0\nf 1/1 1/1 2/2\nf 1/1 2/2 3/3 3/3\nf 1/6 3/3 4/4\nf 1/1 2/2 99/3\n");
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.textureCoordinates.size(), 4u);
  EXPECT_EQ(mesh.triangles.size(), 2u);
}

TEST(ObjTextureCoordinates, AreLeftOutWhereAFaceLacksThem) {
  for (const char* faces : {"f 1/1 2/2 3/3\nf 1 3 4\n", "f 1/1 2/2 3/9\n", "f 1/1 2/2 3//3\n", "f 1/1 2/2 3/-9\n"}) {
    const Mesh mesh = meshOf(std::string(kSquare) + faces);
    EXPECT_TRUE(mesh.textureCoordinates.empty()) << faces;
    EXPECT_EQ(mesh.positions.size(), 4u);
    EXPECT_FALSE(mesh.triangles.empty());
  }
  EXPECT_TRUE(meshOf("v 0 0 0\nv 1 0 0\nv 1 1 0\nvt nan 0\nf 1/1 2/1 3/1\n").textureCoordinates.empty());
}

}  // namespace
}  // namespace overcast
