// Bisection and refinement: no cracks, the same surface, and vertices where what is seen bends.
#include "bake/aperture_refine.h"

#include <algorithm>
#include <array>
#include <map>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "bake/aperture.h"
#include "bake/mesh_bisect.h"
#include "formats/normals.h"
#include "tests/bake/test_meshes.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

double area(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a = mesh.positions[t.x];
  return 0.5 * glm::length(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a));
}

/// Edges, by the positions of their ends in the order of the triangle, whose other side is missing or there twice.
int openEdges(const Mesh& mesh) {
  using Place = std::array<double, 3>;
  std::map<std::pair<Place, Place>, int> count;
  const auto place = [&](std::uint32_t v) { return Place{mesh.positions[v].x, mesh.positions[v].y, mesh.positions[v].z}; };
  for (const glm::uvec3& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) ++count[{place(t[c]), place(t[(c + 1) % 3])}];
  int open = 0;
  for (const auto& [edge, n] : count) {
    const auto other = count.find({edge.second, edge.first});
    open += n != 1 || other == count.end();
  }
  return open;
}

TEST(MeshBisect, LeavesNoCracksAndTheSurfaceAsItIs) {
  std::mt19937 random(11);
  for (Mesh mesh : {withNormals(reference::boxMesh({1.0, 2.0, 0.3})), withNormals(reference::icosphere(1.0, 1)),
                    withNormals(reference::torusMesh(1.0, 0.3, 7, 5))}) {
    mesh.parts = {{0, 7, 0}, {7, static_cast<std::uint32_t>(mesh.triangles.size()) - 7, 1}};
    ASSERT_EQ(openEdges(mesh), 0);
    for (int round = 0; round < 8; ++round) {
      std::vector<char> marked;
      for (std::size_t i = 0; i < mesh.triangles.size(); ++i) marked.push_back(random() % 5 == 0);
      const Bisected cut = bisected(mesh, marked);
      EXPECT_EQ(openEdges(cut.mesh), 0) << "round " << round;
      std::vector<double> pieces(mesh.triangles.size(), 0.0);
      std::vector<int> count(mesh.triangles.size(), 0);
      for (std::size_t i = 0; i < cut.from.size(); ++i) {
        pieces[cut.from[i]] += area(cut.mesh, cut.mesh.triangles[i]);
        ++count[cut.from[i]];
      }
      for (std::size_t i = 0; i < pieces.size(); ++i) {
        EXPECT_NEAR(pieces[i], area(mesh, mesh.triangles[i]), 1e-12);
        EXPECT_GE(count[i], marked[i] ? 2 : 1);
      }
      ASSERT_TRUE(std::equal(mesh.positions.begin(), mesh.positions.end(), cut.mesh.positions.begin()));
      for (const glm::vec3& normal : cut.mesh.normals) EXPECT_NEAR(glm::length(normal), 1.0f, 1e-5f);
      ASSERT_EQ(cut.mesh.parts.size(), 2u);
      EXPECT_EQ(cut.mesh.parts[0].triangleCount + cut.mesh.parts[1].triangleCount, cut.mesh.triangles.size());
      for (std::size_t i = 0; i < cut.from.size(); ++i)
        EXPECT_EQ(i < cut.mesh.parts[0].triangleCount, cut.from[i] < mesh.parts[0].triangleCount);
      mesh = cut.mesh;
    }
  }
}

TEST(MeshBisect, WithoutMarksChangesNothing) {
  const Mesh mesh = withNormals(reference::boxMesh({1.0, 2.0, 0.3}));
  EXPECT_EQ(bisected(mesh, std::vector<char>(mesh.triangles.size(), 0)).mesh.triangles, mesh.triangles);
}

/// A floor of two triangles a side under a box that hovers close over it.
Mesh floorAndBox() {
  return withNormals(
      reference::joined(test::boxBetween({-2.0, -0.2, -2.0}, {2.0, 0.0, 2.0}), test::boxBetween({-0.4, 0.1, -0.4}, {0.4, 0.6, 0.4})));
}

double ambientError(const Mesh& mesh) {
  auto baked = bakeApertures(mesh, ApertureSettings{});
  EXPECT_TRUE(baked.ok());
  return baked.value().report.error.ambient;
}

TEST(ApertureRefine, PutsVerticesWhereWhatIsSeenBends) {
  const Mesh mesh = floorAndBox();
  const auto scene = makeRayScene(mesh);
  ASSERT_TRUE(scene.ok());
  const Mesh fine = refined(mesh, {scene.value().get(), nullptr}, {4096, {}});
  EXPECT_LT(fine.positions.size(), 4096u);
  EXPECT_EQ(openEdges(fine), 0);
  const double before = ambientError(mesh), after = ambientError(fine);
  RecordProperty("before", std::to_string(before));
  RecordProperty("after", std::to_string(after));
  EXPECT_GT(before, 0.04);
  EXPECT_LT(after, 0.02);
  std::size_t near = 0, below = 0;
  for (const glm::dvec3& p : fine.positions) {
    near += p.y == 0.0 && std::max(std::abs(p.x), std::abs(p.z)) < 1.0;
    below += p.y < 0.0;
  }
  EXPECT_GT(near, 60u);
  EXPECT_LT(below, 40u) << "the underside is open and needs none";
}

TEST(ApertureRefine, KeepsToItsBudget) {
  const Mesh mesh = floorAndBox();
  const auto scene = makeRayScene(mesh);
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(refined(mesh, {scene.value().get(), nullptr}, {10, {}}).positions.size(), mesh.positions.size());
  const Mesh some = refined(mesh, {scene.value().get(), nullptr}, {120, {}});
  EXPECT_GT(some.positions.size(), 100u);
  EXPECT_LT(some.positions.size(), 200u);
  const Mesh open = withNormals(reference::icosphere(1.0, 1));
  const auto alone = makeRayScene(open);
  ASSERT_TRUE(alone.ok());
  EXPECT_EQ(refined(open, {alone.value().get(), nullptr}, {4096, {}}).positions.size(), open.positions.size()) << "nothing to gain";
}

}  // namespace
}  // namespace overcast
