// Honest apertures are verified, whatever the mesh and the settings; false ones are found.
#include "bake/verify_apertures.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "formats/normals.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A potato with dents, beside a wall that stands in its middle when `walled`.
Mesh potato(std::uint64_t seed, bool walled) {
  const auto s = static_cast<double>(seed % 97);
  Mesh mesh = reference::icosphere(1.0, 3);
  for (glm::dvec3& p : mesh.positions)
    p *= glm::dvec3(1.3, 0.7, 1.0) * (1.0 + 0.35 * std::sin(5.0 * p.x + s) * std::cos(4.0 * p.z - s) * std::sin(3.0 * p.y));
  return walled ? reference::joined(mesh, reference::boxMesh({0.02, 2.0, 2.0})) : mesh;
}

/// The scene with apertures, as its file would give it back.
Scene baked(Scene scene, const SceneApertureSettings& settings) {
  SceneBake bake;
  bake.scene = std::move(scene);
  bake.inputs = {"test"};
  for (std::size_t i = 0; i < bake.scene.meshes.size(); ++i) {
    bake.meshes.emplace_back();
    bake.meshes.back().mesh = static_cast<int>(i);
    bake.meshes.back().input = 0;
  }
  bakeSceneApertures(bake, settings);
  for (Mesh& mesh : bake.scene.meshes) {
    for (glm::dvec3& p : mesh.positions) p = glm::dvec3(glm::vec3(p));
    mesh.visibility = asStored(std::move(*mesh.visibility));
  }
  return std::move(bake.scene);
}

/// Whether something is found after `change` of one vertex's visibility.
template <class Change>
bool isFound(Scene scene, std::size_t vertex, Change change) {
  VertexVisibility& visibility = *scene.meshes[0].visibility;
  change(visibility, vertex % visibility.apertures.size());
  return !verifyApertures(scene).empty();
}

class VerifyEvery : public testing::TestWithParam<std::uint64_t> {};

TEST_P(VerifyEvery, HonestBakesPassAndFalseVerticesAreFound) {
  const std::uint64_t seed = GetParam();
  const bool walled = seed % 2 == 1, wide = seed % 4 > 1, transfer = seed % 3 == 0, few = seed % 5 == 0;
  SceneApertureSettings settings;
  settings.aperture.visibility = {few ? 64 : 256, transfer};
  settings.aperture.bits = wide ? ApertureBits::packed64 : ApertureBits::packed32;
  settings.aperture.errorSamples = 1000;
  settings.aperture.seed = seed;
  const Scene scene = baked(sceneFromMesh(potato(seed, walled)), settings);
  EXPECT_THAT(verifyApertures(scene), ElementsAre());
  const std::size_t vertex = 7919 * (seed + 1);
  EXPECT_TRUE(isFound(scene, vertex, [](VertexVisibility& visibility, std::size_t v) {
    float& radius = visibility.apertures[v].radius;
    radius += radius > 0.7f ? -0.5f : 0.5f;
  }));
  EXPECT_TRUE(isFound(scene, vertex, [](VertexVisibility& visibility, std::size_t v) {
    Aperture& aperture = visibility.apertures[v];
    if (aperture.radius > 1.0f)
      aperture.direction = -aperture.direction;
    else
      aperture.radius += 0.5f;
  }));
  if (!transfer) return;
  EXPECT_TRUE(isFound(scene, vertex, [](VertexVisibility& visibility, std::size_t v) { visibility.transfer[v][v % 9] += 0.3f; }));
}

INSTANTIATE_TEST_SUITE_P(Seeds, VerifyEvery, testing::Range<std::uint64_t>(0, 6));

TEST(VerifyApertures, WhatAllAreALittleOffIsFoundByTheStatedError) {
  SceneApertureSettings settings;
  settings.aperture.bits = ApertureBits::packed64;
  const Scene honest = baked(sceneFromMesh(potato(3, false)), settings);
  ASSERT_THAT(verifyApertures(honest), ElementsAre());
  Scene scene = honest;
  for (Aperture& aperture : scene.meshes[0].visibility->apertures) aperture.radius *= 0.98f;
  EXPECT_THAT(verifyApertures(scene), ElementsAre(HasSubstr("states an aperture error of radius")));
  scene = honest;
  for (float& ambient : scene.meshes[0].visibility->ambient) ambient *= 0.97f;
  EXPECT_THAT(verifyApertures(scene), ElementsAre(HasSubstr("states an aperture error of ambient visibility")));
  scene = honest;
  scene.meshes[0].apertureBake->directionError *= 0.9;
  EXPECT_THAT(verifyApertures(scene), ElementsAre(HasSubstr("states an aperture error of direction")));
  scene = honest;
  scene.meshes[0].apertureBake.reset();
  EXPECT_THAT(verifyApertures(scene), ElementsAre(HasSubstr("bake it again")));
  scene = honest;
  scene.meshes[0].visibility->apertures.clear();
  scene.meshes[0].visibility->transfer.resize(scene.meshes[0].positions.size());
  EXPECT_THAT(verifyApertures(scene), ElementsAre(HasSubstr("holds a transfer without apertures")));
}

TEST(VerifyApertures, NeighboursBelongToTheTruthWhereTheBakeSawThem) {
  Scene scene = sceneFromMesh(potato(1, false));
  scene.nodes.resize(2, scene.nodes[0]);
  scene.nodes[1].translation = {2.3, 0.0, 0.0};
  SceneApertureSettings settings;
  settings.occluders = Occluding::scene;
  Scene honest = baked(scene, settings);
  EXPECT_THAT(verifyApertures(honest), ElementsAre());
  honest.nodes[1].translation = {4.0, 0.0, 0.0};
  EXPECT_FALSE(verifyApertures(honest).empty());
}

}  // namespace
}  // namespace overcast
