// Surfels: form factor and trees against closed forms, and a sphere on a floor through the whole frame.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "runtime/passes/surfels/surfel_tree.h"
#include "tests/runtime/baked_scene.h"
#include "tests/runtime/frames.h"

namespace overcast::test {
namespace {

using shared::Surfel;

TEST(SurfelFormulas, FactorIsExactOnTheAxisOfAParallelDiscAndFarAway) {
  for (const double radius : {0.01, 1.0, 20.0})
    for (const double distance : {0.1, 1.0, 50.0}) {
      const double exact = radius * radius / (distance * distance + radius * radius);
      EXPECT_NEAR(shared::surfelFactor(static_cast<float>(distance * distance), static_cast<float>(radius * radius), 1.0f, 1.0f) / exact,
                  1.0, 1e-5);
    }
  // Far away: area times both cosines over pi times the distance squared.
  EXPECT_NEAR(shared::surfelFactor(1e4f, 1.0f, 0.5f, 0.25f) / (0.5 * 0.25 / 1e4), 1.0, 1e-3);
  EXPECT_EQ(shared::surfelFactor(1.0f, 1.0f, -0.5f, 1.0f), 0.0f);
  EXPECT_EQ(shared::surfelFactor(1.0f, 1.0f, 0.5f, -1.0f), 0.0f);
}

TEST(SurfelFormulas, OneShadowCountsInFullAndShadowsOfShadowsHardly) {
  EXPECT_NEAR(shared::surfelVisibility(0.4f, 0.4f), 0.6f, 1e-6f);
  EXPECT_EQ(shared::surfelVisibility(5.0f, 1.2f), 0.0f);
  EXPECT_GT(shared::surfelVisibility(0.8f, 0.4f), 1.0f - 0.8f);
}

std::vector<Disc> discsOf(const Mesh& mesh, double longestEdge) {
  std::vector<glm::vec3> positions(mesh.positions.begin(), mesh.positions.end());
  std::vector<DiscTriangle> triangles;
  for (const glm::uvec3& corners : mesh.triangles) triangles.push_back({corners, {0.5f, 0.25f, 1.0f}});
  return overcast::discsOf(positions, {}, triangles, longestEdge);
}

double areaOf(const std::vector<Disc>& discs) {
  double sum = 0.0;
  for (const Disc& disc : discs) sum += disc.area;
  return sum;
}

TEST(SurfelTrees, DiscsHaveTheAreaOfTheMeshHoweverItIsDivided) {
  const Mesh box = reference::boxMesh({1.0, 0.5, 2.0});
  EXPECT_EQ(discsOf(box, 100.0).size(), box.positions.size());
  for (const double edge : {100.0, 1.0, 0.3, 0.1}) {
    const std::vector<Disc> discs = discsOf(box, edge);
    EXPECT_NEAR(areaOf(discs), 8.0 * (0.5 + 1.0 + 2.0), 1e-5) << edge;
    glm::dvec3 closed(0.0), albedo(0.0);
    for (const Disc& disc : discs) {
      closed += disc.facing;
      albedo += disc.albedo;
    }
    EXPECT_LT(glm::length(closed), 1e-5) << "areas of a closed surface sum to nothing";
    EXPECT_LT(glm::length(albedo - 28.0 * glm::dvec3(0.5, 0.25, 1.0)), 1e-4);
  }
}

TEST(SurfelTrees, EveryWalkSeesTheWholeAreaOnce) {
  const std::vector<Disc> discs = discsOf(reference::icosphere(0.7, 4), 100.0);
  for (const std::size_t most : {std::size_t{1} << 20, std::size_t{300}}) {
    const std::vector<Surfel> tree = surfelTree(discs, most);
    for (const double nearness : {0.0, 1.0, 4.0, 1e3}) {
      double area = 0.0;
      std::size_t visited = 0, node = 0;
      while (node < tree.size()) {
        const glm::vec3 way = glm::vec3(tree[node].place) - glm::vec3(0.9f, 0.2f, 0.1f);
        if (shared::surfelEnters(glm::dot(way, way), tree[node].place.w, tree[node].albedo.w, static_cast<float>(nearness * nearness))) {
          ++node;
          continue;
        }
        area += std::numbers::pi * tree[node].place.w;
        ++visited;
        ASSERT_GT(tree[node].normal.w, static_cast<float>(node));
        node = static_cast<std::size_t>(tree[node].normal.w);
      }
      EXPECT_EQ(node, tree.size());
      EXPECT_NEAR(area, areaOf(discs), 1e-4 * area);
      if (nearness == 0.0) {
        EXPECT_EQ(visited, 6u) << "one tree for each side";
      }
      EXPECT_LE(visited, std::min(discs.size(), 2 * most));
    }
  }
}

TEST(SurfelTrees, ParentsKeepTheDirectionOfTheirSide) {
  for (const Surfel& node : surfelTree(discsOf(reference::icosphere(0.7, 3), 100.0), 1u << 20)) {
    EXPECT_NEAR(glm::length(glm::vec3(node.normal)), 1.0f, 1e-5f);
    EXPECT_GT(glm::dot(glm::vec3(node.normal), glm::normalize(glm::vec3(node.place))), 0.97f) << "spheres face outward";
    EXPECT_LE(node.albedo.w, 4.0f * 0.49f);
  }
}

class Surfels : public Frames {
 protected:
  /// The baked scene with the floor and the sphere alone.
  std::filesystem::path sphereOnFloor(const std::filesystem::path& folder) {
    Scene made = bakedScene(folder, {});
    std::erase_if(made.nodes, [](const Node& node) { return node.name == "turned" || node.name == "mirrored"; });
    const std::filesystem::path file = folder / "scene.gltf";
    EXPECT_TRUE(writeScene(file, made).ok());
    return file;
  }
};

TEST_F(Surfels, FindTheFormFactorOfASphere) {
  settings.technique.technique = Technique::surfels;
  open(sphereOnFloor(temporaryFolder()), settings);
  const View view = lookAt({-0.5, 5.0, 2.5}, {-0.2, 0.0, 0.2}, {0, 1, 0}, 0.7);
  ASSERT_TRUE(renderFrame(device, renderer, scene, 0.0, view).ok());
  const Image image = linear();
  const int sky = channelIndex(image, "sky");
  const auto at = [&](const glm::dvec3& point, int channel) {
    const glm::ivec2 pixel = pixelOf(renderer, view, point);
    return image.pixels[static_cast<std::size_t>((pixel.y * image.width + pixel.x) * 4 + channel)];
  };
  for (const double distance : {0.5, 0.7, 1.0, 1.5}) {
    const double exact = 1.0 - std::pow(0.5 / std::hypot(distance, 0.5), 3.0);
    // Near the sphere its lower half counts for less, being in the floor's shadow itself: too light, as the method is.
    EXPECT_NEAR(at({-0.7 + distance, 0.0, 0.0}, sky), exact, distance < 1.0 ? 0.09 : 0.04) << distance;
  }
  EXPECT_NEAR(at({1.6, 0.0, -1.0}, sky), 1.0f, 0.02f);
  EXPECT_LT(at({-0.4, 0.0, 0.25}, sky), at({0.3, 0.0, 0.25}, sky)) << "darker towards where it touches";
  // The red sphere colours the floor beside it: more red per sky than far away.
  const auto redness = [&](const glm::dvec3& point) { return at(point, 0) / at(point, 2); };
  EXPECT_GT(redness({-0.2, 0.0, 0.0}), 1.03f * redness({1.6, 0.0, -1.0}));
}

TEST_F(Surfels, MoveWithTheirObjectsAndHaveNoHistory) {
  settings.technique.technique = Technique::surfels;
  open(writeBakedScene(temporaryFolder(), {.animated = true}), settings);
  render(0.0);
  const Image low = linear();
  render(1.0);
  EXPECT_NE(linear().pixels, low.pixels);
  render(0.0);
  EXPECT_EQ(linear().pixels, low.pixels);
}

}  // namespace
}  // namespace overcast::test
