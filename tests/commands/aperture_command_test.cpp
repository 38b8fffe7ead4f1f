// overcast-bake --apertures: what lands in the scene, and what is refused.
#include <algorithm>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/aperture.h"
#include "formats/aperture_map.h"
#include "formats/scene.h"
#include "tests/commands/bake_fixture.h"
#include "tests/reference/shapes.h"

namespace overcast::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ApertureCommand : public testing::Test {
 protected:
  void SetUp() override {
    folder = scratchFolder();
    ASSERT_TRUE(writeOff(folder / "ring.off", reference::torusMesh(1.0, 0.6, 32, 16)).ok());
    ASSERT_TRUE(writeOff(folder / "box.off", reference::boxMesh({1.0, 2.0, 3.0})).ok());
  }

  ShellResult bake(const std::string& arguments) const {
    return shell(fmt::format("{} {} -o out --resolution 16 --error-samples 0", kBake, arguments), folder);
  }

  Scene scene() const {
    auto read = readScene(folder / "out" / "scene.gltf");
    EXPECT_TRUE(read) << message(read.error());
    return read ? read.value() : Scene{};
  }

  fs::path folder;
};

TEST_F(ApertureCommand, EveryVertexOfEveryMeshGetsOne) {
  const ShellResult result = bake("ring.off box.off --apertures vertex --rays 128");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("ring.off: apertures: 512 vertices"));
  const Scene read = scene();
  ASSERT_EQ(read.meshes.size(), 2u);
  for (const Mesh& mesh : read.meshes) {
    ASSERT_TRUE(mesh.visibility);
    EXPECT_EQ(mesh.visibility->bits, ApertureBits::packed32);
    ASSERT_EQ(mesh.visibility->apertures.size(), mesh.positions.size());
    EXPECT_TRUE(mesh.visibility->transfer.empty());
  }
  for (const Aperture& aperture : read.meshes[1].visibility->apertures) EXPECT_EQ(aperture.radius, capRadius(1.0));
  float least = 2.0f;
  for (const Aperture& aperture : read.meshes[0].visibility->apertures) least = std::min(least, aperture.radius);
  EXPECT_LT(least, 1.2f);  // the inside of the ring sees part of the sky
  EXPECT_THAT(shell(fmt::format("{} inspect out/scene.gltf", kBake), folder).output, HasSubstr("apertures at 512 vertices, 4 bytes each"));
}

TEST_F(ApertureCommand, EightBytesBringAmbientVisibilityAndTransferBringsHarmonics) {
  const ShellResult result = bake("ring.off --apertures vertex --aperture-bytes 8 --transfer --json --quiet");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  const auto json = nlohmann::json::parse(result.output);
  EXPECT_EQ(json["inputs"][0]["meshes"][0]["apertures"]["vertices"], 512);
  EXPECT_LT(json["inputs"][0]["meshes"][0]["apertures"]["error"]["ambient"], 0.02);
  const Scene read = scene();
  ASSERT_TRUE(read.meshes[0].visibility);
  const VertexVisibility& visibility = *read.meshes[0].visibility;
  EXPECT_EQ(visibility.bits, ApertureBits::packed64);
  ASSERT_EQ(visibility.ambient.size(), read.meshes[0].positions.size());
  ASSERT_EQ(visibility.transfer.size(), read.meshes[0].positions.size());
  // Under a sky of radiance 1, L_0 = sqrt(4 pi): the transfer and the ambient visibility say the same.
  for (std::size_t i = 0; i < visibility.ambient.size(); ++i)
    EXPECT_NEAR(visibility.transfer[i][0] * 3.5449077f, visibility.ambient[i], 1e-3f);
}

TEST_F(ApertureCommand, TheSameInputGivesTheSameBytesWithAnyNumberOfThreads) {
  std::string first;
  for (const char* threads : {"1", "3"}) {
    ASSERT_EQ(bake(fmt::format("ring.off --apertures vertex --transfer --threads {}", threads)).exitCode, 0);
    const ShellResult sums = shell("cd out && md5sum *.gltf *.bin", folder);
    if (first.empty()) first = sums.output;
    EXPECT_EQ(sums.output, first);
  }
}

/// Three times the same ball: two at rest side by side along x, one that moves between them and above.
Scene balls() {
  Scene scene = sceneFromMesh(reference::icosphere(1.0, 3));
  scene.nodes.resize(3, scene.nodes[0]);
  scene.nodes[1].translation = {2.2, 0.0, 0.0};
  scene.nodes[2].translation = {1.1, 2.0, 0.0};
  scene.animations = {{"", {{2, AnimatedProperty::translation, Interpolation::linear, {0.0, 1.0}, {{1.1, 2, 0, 0}, {1.1, 3, 0, 0}}}}}};
  return scene;
}

/// The radius at the vertex of `mesh` that lies furthest along x, times `sign`.
float radiusAlongX(const Mesh& mesh, double sign) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    if (sign * mesh.positions[i].x > sign * mesh.positions[best].x) best = i;
  return mesh.visibility->apertures[best].radius;
}

TEST_F(ApertureCommand, RestingObjectsOfASceneSeeEachOther) {
  ASSERT_TRUE(writeScene(folder / "scene.gltf", balls()).ok());
  const ShellResult result = bake("scene.gltf --apertures vertex --occluders scene");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  const Scene read = scene();
  ASSERT_EQ(read.nodes.size(), 3u);
  const auto meshOf = [&](std::size_t node) -> const Mesh& { return read.meshes[static_cast<std::size_t>(read.nodes[node].mesh)]; };
  const float open = capRadius(1.0);
  // Where the balls nearly touch, at a distance of 0.2 from a sphere of radius 1, asin(1 / 1.2) is hidden.
  const float facing = capRadius(std::cos(std::asin(1.0 / 1.2)));
  EXPECT_NEAR(radiusAlongX(meshOf(0), 1.0), facing, 0.02);
  EXPECT_NEAR(radiusAlongX(meshOf(1), -1.0), facing, 0.02);
  EXPECT_EQ(radiusAlongX(meshOf(0), -1.0), open);
  EXPECT_EQ(radiusAlongX(meshOf(1), 1.0), open);
  for (const Aperture& aperture : meshOf(2).visibility->apertures) EXPECT_EQ(aperture.radius, open);
  EXPECT_EQ(read.nodes[0].occluder->uri, read.nodes[1].occluder->uri);
  EXPECT_EQ(read.nodes[0].occluder->uri, read.nodes[2].occluder->uri);

  ASSERT_EQ(bake("scene.gltf --apertures vertex --occluders self").exitCode, 0);
  const Scene alone = scene();
  ASSERT_EQ(alone.meshes.size(), 1u);
  EXPECT_EQ(radiusAlongX(alone.meshes[0], 1.0), open);
}

TEST_F(ApertureCommand, VerifyAndValidateHoldAperturesToTheirWord) {
  const std::string settings = "-o out --resolution 16 --error-samples 500 --apertures vertex --rays 128";
  ASSERT_EQ(shell(fmt::format("{} ring.off box.off {}", kBake, settings), folder).exitCode, 0);
  const auto check = [&](const std::string& arguments) { return shell(fmt::format("{} {}", kBake, arguments), folder); };
  ShellResult found = check("verify out/scene.gltf --source ring.off --source box.off");
  EXPECT_EQ(found.exitCode, 0) << found.output;
  EXPECT_EQ(check("validate out/scene.gltf").exitCode, 0);
  Scene lie = scene();
  lie.meshes[0].visibility->apertures[100].radius *= 0.5f;
  ASSERT_TRUE(writeScene(folder / "out/lie.gltf", lie).ok());
  found = check("verify out/lie.gltf --source ring.off --source box.off");
  EXPECT_EQ(found.exitCode, 5);
  EXPECT_THAT(found.output,
              HasSubstr("out/lie.gltf: mesh 0 'ring': apertures of 1 in 512 vertices are not what is seen there; vertex 100"));
  EXPECT_EQ(check("validate out/lie.gltf").exitCode, 0);  // nothing is wrong but what only rays can tell

  // What the reader has to leave out is a finding.
  nlohmann::json document = nlohmann::json::parse(std::ifstream(folder / "out/scene.gltf"));
  nlohmann::json& attributes = document["meshes"][0]["primitives"][0]["attributes"];
  attributes["_APERTURE"] = attributes["NORMAL"];
  std::ofstream(folder / "out/broken.gltf") << document;
  found = check("validate out/broken.gltf");
  EXPECT_EQ(found.exitCode, 5);
  EXPECT_THAT(found.output, HasSubstr("_APERTURE"));
}

TEST_F(ApertureCommand, DetailsWithoutAperturesAreRefused) {
  for (const char* detail : {"--rays 256", "--transfer", "--occluders scene", "--aperture-bytes 8"}) {
    const ShellResult result = bake(std::string("ring.off ") + detail);
    EXPECT_EQ(result.exitCode, 2);
    EXPECT_THAT(result.output, HasSubstr("needs --apertures vertex"));
  }
  EXPECT_EQ(bake("ring.off --apertures face").exitCode, 2);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(ApertureCommand, AnAtlasBecomesAFileThatTheSceneNames) {
  const ShellResult result = bake("ring.off box.off --apertures texel --atlas --texels 128 --rays 128");
  ASSERT_EQ(result.exitCode, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("ring.off: aperture map: 128x128"));
  const Scene read = scene();
  for (const Mesh& mesh : read.meshes) {
    EXPECT_FALSE(mesh.visibility);
    ASSERT_TRUE(mesh.apertureMap);
    EXPECT_EQ(mesh.textureCoordinates.size(), mesh.positions.size());
    EXPECT_GE(mesh.apertureMap->ambientError, 0.0);
    const auto map = readApertureMap(folder / "out", *mesh.apertureMap);
    ASSERT_TRUE(map) << message(map.error());
    EXPECT_EQ(map.value().size, glm::ivec2(128));
  }
  EXPECT_EQ(shell(fmt::format("{} validate out/scene.gltf", kBake), folder).exitCode, 0);
  EXPECT_THAT(shell(fmt::format("{} inspect out/scene.gltf", kBake), folder).output, HasSubstr("apertures in apertures/ring-"));
  // A map that was lost comes back, and one that was changed is found.
  const fs::path file = folder / "out" / read.meshes[0].apertureMap->uri;
  fs::resize_file(file, 100);
  EXPECT_NE(shell(fmt::format("{} validate out/scene.gltf", kBake), folder).exitCode, 0);
  fs::remove(file);
  ASSERT_EQ(bake("ring.off box.off --apertures texel --atlas --texels 128 --rays 128").exitCode, 0);
  EXPECT_TRUE(fs::exists(file));
}

TEST_F(ApertureCommand, MeshesWithoutCoordinatesNeedAnAtlasAndDetailsTheirKind) {
  const ShellResult result = bake("box.off --apertures texel --texels 32");
  EXPECT_NE(result.exitCode, 0);
  EXPECT_THAT(result.output, HasSubstr("box.off: box: has no texture coordinates on all its triangles; --atlas"));
  EXPECT_THAT(bake("box.off --apertures vertex --atlas").output, HasSubstr("--atlas needs --apertures texel"));
  EXPECT_THAT(bake("box.off --apertures texel --transfer").output, HasSubstr("--transfer needs --apertures vertex"));
  EXPECT_THAT(bake("ring.off --apertures texel --atlas --texels 32").output, HasSubstr("--texels 128 holds them"));
}

}  // namespace
}  // namespace overcast::test
