// writeScene: what is written reads back, is the same bytes every time, and is valid glTF 2.0.
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <glm/gtc/matrix_transform.hpp>

#include "formats/files.h"
#include "formats/normals.h"
#include "formats/scene.h"
#include "formats/scene_bytes.h"
#include "formats/trs.h"
#include "tests/formats/random_scene.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using test::randomScene;
using test::TemporaryFolder;
using testing::HasSubstr;

std::vector<std::byte> bytesOf(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return {};
  auto bytes = readFile(path);
  EXPECT_TRUE(bytes) << message(bytes.error());
  return bytes ? bytes.value() : std::vector<std::byte>{};
}

Scene writtenAndRead(const Scene& scene, const std::filesystem::path& path) {
  auto written = writeScene(path, scene);
  EXPECT_TRUE(written) << message(written.error());
  auto read = readScene(path);
  EXPECT_TRUE(read) << message(read.error());
  return read ? read.value() : Scene{};
}

TEST(SceneWriter, WhatIsWrittenReadsBackBitForBitAndWritesTheSameBytes) {
  EXPECT_TRUE(
      rc::check("read(write(scene)) == scene, write(read(write(scene))) == write(scene)", [](std::uint64_t seed, bool withoutNormals) {
        const TemporaryFolder folder;
        Scene scene = randomScene(seed);
        for (Mesh& mesh : scene.meshes)
          if (withoutNormals) {
            mesh.normals.clear();
            mesh.visibility.reset();
            mesh.apertureBake.reset();
            mesh.apertureMap.reset();
          }
        const Scene again = writtenAndRead(scene, folder.path / "a" / "scene.gltf");
        RC_ASSERT(again.notes.empty());
        RC_ASSERT(again.nodes.size() == scene.nodes.size());
        RC_ASSERT(again.meshes.size() == scene.meshes.size());
        RC_ASSERT(again.animations.size() == scene.animations.size());
        const bool equal = packScene(again) == packScene(scene);  // not in the assertion, which would print a megabyte
        RC_ASSERT(equal || (withoutNormals && !scene.meshes.empty()));
        auto written = writeScene(folder.path / "b" / "scene.gltf", again);
        RC_ASSERT(written.ok());
        for (const std::filesystem::path& file : written.value()) {
          const bool sameBytes = bytesOf(folder.path / "a" / file.filename()) == bytesOf(file);
          RC_ASSERT(sameBytes);
        }
      }));
}

TEST(SceneWriter, DamagedBytesOfASceneAreRefused) {
  const std::vector<std::byte> whole = packScene(randomScene(5));
  ASSERT_TRUE(unpackScene(whole));
  std::mt19937_64 dice(1);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> damaged = whole;
    if (i % 2 == 0) damaged.resize(dice() % damaged.size());
    for (int k = 0; k < 3 && !damaged.empty(); ++k) damaged[dice() % damaged.size()] = static_cast<std::byte>(dice());
    (void)unpackScene(damaged);
  }
  EXPECT_FALSE(unpackScene(std::span(whole).first(whole.size() - 1)));
}

/// A matrix whose parts are anything: rotation, non-uniform scale, rotation again, hence shear.
glm::dmat4 randomAffine(std::mt19937_64& dice, const glm::dvec3& scale) {
  std::uniform_real_distribution<double> real(-1.0, 1.0);
  const auto turn = [&] { return glm::mat4_cast(glm::normalize(glm::dquat(real(dice), real(dice), real(dice), real(dice)))); };
  return glm::scale(glm::translate(glm::dmat4(1.0), {real(dice), real(dice), real(dice)}) * turn(), scale) * turn();
}

double distanceBetween(const glm::dmat4& a, const glm::dmat4& b) {
  double largest = 0.0;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) largest = std::max(largest, std::abs(a[c][r] - b[c][r]));
  return largest;
}

glm::dmat4 composed(const Trs& trs) {
  glm::dmat4 matrix = glm::scale(glm::translate(glm::dmat4(1.0), trs.translation) * glm::mat4_cast(trs.rotation), trs.scale);
  return trs.inner ? matrix * glm::mat4_cast(*trs.inner) : matrix;
}

TEST(SceneWriter, EveryAffineMatrixHasParts) {
  std::mt19937_64 dice(7);
  std::uniform_real_distribution<double> real(-2.0, 2.0);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 scale(real(dice), i % 5 == 0 ? 0.0 : real(dice), i % 7 == 0 ? 0.0 : real(dice));
    const glm::dmat4 matrix = randomAffine(dice, i % 35 == 0 ? glm::dvec3(0.0) : scale);
    EXPECT_LT(distanceBetween(composed(decompose(matrix)), matrix), 1e-12);
    const glm::dmat4 plain = glm::scale(glm::mat4_cast(decompose(matrix).rotation), scale);
    const Trs parts = decompose(plain);
    EXPECT_FALSE(parts.inner);
    EXPECT_LT(distanceBetween(composed(parts), plain), 1e-12);
  }
}

Mesh soup() {  // a cube as STL has it: three vertices per triangle
  Mesh mesh;
  const int quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  const auto corner = [](int i) { return glm::dvec3(i & 1, (i >> 1) & 1, (i >> 2) & 1); };
  for (const auto& q : quads) {
    for (const int k : {0, 1, 2, 0, 2, 3}) mesh.positions.push_back(corner(q[k]));
  }
  for (std::uint32_t i = 0; i < 12; ++i) mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  return mesh;
}

/// Scenes whose matrices glTF forbids as they are.
Scene sheared() {
  std::mt19937_64 dice(3);
  Scene scene = sceneFromMesh(soup());
  scene.nodes.clear();
  const glm::dvec3 scales[] = {{1, 2, 3}, {1, 0, 2}, {0, 0, 0}, {-1, 2, 500}, {1e-4, 1e4, 1}, {100, 200, 300}};
  for (const glm::dvec3& scale : scales) {
    Node node;
    node.matrix = randomAffine(dice, scale);
    node.mesh = 0;
    scene.nodes.push_back(node);
  }
  scene.nodes[1].children = {2};
  scene.nodes[2].parent = 1;
  Node rounded;  // single floats at a scale of 1000: free of shear but for the rounding
  rounded.matrix = glm::dmat4(glm::mat4(glm::scale(glm::mat4_cast(glm::dquat(0.5, 0.5, 0.1, 0.7)), glm::dvec3(1000))));
  rounded.mesh = 0;
  scene.nodes.push_back(rounded);
  return scene;
}

TEST(SceneWriter, ShearedMatricesBecomeTwoNodesInTheSamePlace) {
  const TemporaryFolder folder;
  const Scene scene = sheared();
  const Scene again = writtenAndRead(scene, folder.path / "sheared.gltf");
  EXPECT_GT(again.nodes.size(), scene.nodes.size());
  EXPECT_LT(again.nodes.size(), 2 * scene.nodes.size()) << "the last one shears only by rounding";
  const auto world = worldFromLocal(scene, 0.0);
  const auto worldAgain = worldFromLocal(again, 0.0);
  std::vector<glm::dmat4> shown;
  for (std::size_t i = 0; i < again.nodes.size(); ++i)
    if (again.nodes[i].mesh >= 0) shown.push_back(worldAgain[i]);
  ASSERT_EQ(shown.size(), world.size());
  for (const glm::dmat4& matrix : world) {
    const double size = 1e-12 + distanceBetween(matrix, glm::dmat4(0.0));
    const bool found =
        std::any_of(shown.begin(), shown.end(), [&](const glm::dmat4& s) { return distanceBetween(s, matrix) < 1e-6 * size; });
    EXPECT_TRUE(found);
  }
}

TEST(SceneWriter, LampsStayWithShearedNodes) {
  const TemporaryFolder folder;
  Scene scene = sheared();
  scene.lighting.emplace();
  for (int i = 0; i < static_cast<int>(scene.nodes.size()); ++i)
    scene.lighting->areaLights.push_back({{0.3f, -0.4f, 0.7f}, 0.1f, {1, 1, 1}, i});
  const Scene again = writtenAndRead(scene, folder.path / "lamps.gltf");
  ASSERT_EQ(again.lighting->areaLights.size(), scene.nodes.size());
  const auto placed = [](const Scene& in, const AreaLight& light) {
    return worldFromLocal(in, 0.0)[static_cast<std::size_t>(light.node)] * glm::dvec4(light.position, 1.0);
  };
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const glm::dvec4 was = placed(scene, scene.lighting->areaLights[i]), is = placed(again, again.lighting->areaLights[i]);
    EXPECT_LT(glm::distance(was, is), 1e-6 * glm::length(was)) << i;
  }
}

TEST(Normals, ACubeSplitsAtItsEdges) {
  const Mesh mesh = withNormals(soup());
  EXPECT_EQ(mesh.positions.size(), 36u) << "a soup has a vertex for every corner already";
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 n = glm::normalize(glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(glm::distance(glm::dvec3(mesh.normals[t[c]]), n), 0.0, 1e-6);
  }
  Mesh shared;
  for (int i = 0; i < 8; ++i) shared.positions.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  shared.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  EXPECT_EQ(withNormals(shared).positions.size(), 24u) << "three normals at each of the eight corners";
}

TEST(Normals, ASphereSoupComesOutSmooth) {
  Mesh mesh;
  constexpr int kRings = 24, kSegments = 48;
  const auto point = [](int r, int s) {
    const double theta = M_PI * r / kRings, phi = 2.0 * M_PI * (s % kSegments) / kSegments;
    const double ring = r == 0 || r == kRings ? 0.0 : std::sin(theta);
    return glm::dvec3(ring * std::cos(phi), r == 0 ? 1.0 : r == kRings ? -1.0 : std::cos(theta), ring * std::sin(phi));
  };
  for (int r = 0; r < kRings; ++r) {
    for (int s = 0; s < kSegments; ++s) {
      const glm::dvec3 corners[] = {point(r, s), point(r + 1, s + 1), point(r + 1, s), point(r, s), point(r, s + 1), point(r + 1, s + 1)};
      for (const int k : {0, 1, 2, 3, 4, 5}) mesh.positions.push_back(corners[k]);
    }
  }
  for (std::uint32_t i = 0; i < mesh.positions.size(); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
  const Mesh smooth = withNormals(mesh);
  for (const glm::uvec3& t : smooth.triangles) {
    const glm::dvec3 face = glm::cross(smooth.positions[t.y] - smooth.positions[t.x], smooth.positions[t.z] - smooth.positions[t.x]);
    for (int c = 0; c < 3 && glm::length(face) > 0.0; ++c)
      EXPECT_LT(glm::distance(glm::dvec3(smooth.normals[t[c]]), smooth.positions[t[c]]), 0.02)
          << "the normal of a unit sphere is the point";
  }
}

TEST(Normals, AreWeightedByAngleNotByTriangulation) {
  Mesh mesh;  // an octahedron's top, one of its four sides cut into many slivers: the tip's normal must stay +y
  mesh.positions = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {-1, 0, 0}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}};
  std::uint32_t last = 4;
  for (int i = 1; i < 10; ++i) {
    mesh.positions.push_back(glm::mix(glm::dvec3(0, 0, -1), glm::dvec3(1, 0, 0), i / 10.0));
    const auto next = static_cast<std::uint32_t>(mesh.positions.size()) - 1;
    mesh.triangles.push_back({0, next, last});
    last = next;
  }
  mesh.triangles.push_back({0, 1, last});
  for (glm::dvec3& p : mesh.positions) p.y *= 0.3;  // flat enough that no edge is a crease
  const Mesh made = withNormals(mesh);
  EXPECT_EQ(made.positions.size(), mesh.positions.size());
  EXPECT_NEAR(glm::distance(made.normals[0], glm::vec3(0, 1, 0)), 0.0, 1e-6);
}

TEST(Normals, DegenerateTrianglesGetUnitNormalsToo) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1e-200, 0, 0}, {0, 1e-200, 0}, {5, 5, 5}, {6, 6, 6}};
  mesh.triangles = {{0, 1, 2}, {3, 3, 3}, {3, 4, 3}};
  const Mesh made = withNormals(mesh);
  EXPECT_EQ(made.normals[0], glm::vec3(0, 0, 1)) << "tiny but not degenerate";
  for (const glm::vec3& n : made.normals) EXPECT_NEAR(glm::length(n), 1.0, 1e-6);
}

std::set<std::string> namesIn(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

TEST(SceneWriter, ReplacesASceneAndRemovesOnlyWhatItLeft) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path / "scene.gltf";
  std::set<std::string> others;
  for (const char* name : {"scene.bin", "scene-0123456.bin", "scene-012345678.bin", "scene-0123456G.bin", "scene-01234567.bin.old",
                           "scene-a-01234567.bin", "ascene-01234567.bin", "other-01234567.bin", "scene_01234567.bin"}) {
    std::ofstream(folder.path / name) << "not the scene's";
    others.insert(name);
  }
  std::ofstream(folder.path / "scene-01234567.bin") << "an older scene's";
  for (const Scene& scene : {sceneFromMesh(soup()), test::randomScene(5), test::randomScene(5), Scene{}}) {
    const auto written = writeScene(path, scene);
    ASSERT_TRUE(written);
    std::set<std::string> expected = others;
    for (const std::filesystem::path& file : written.value()) expected.insert(file.filename().string());
    EXPECT_EQ(written.value().back(), path);
    EXPECT_EQ(written.value().size(), scene.meshes.empty() ? 1u : 2u);
    EXPECT_EQ(namesIn(folder.path), expected);
    EXPECT_TRUE(readScene(path));
  }
}

TEST(SceneWriter, AFailureLeavesTheFolderAsItWas) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path / "scene.gltf" / "taken");
  EXPECT_FALSE(writeScene(folder.path / "scene.gltf", test::randomScene(5)));
  EXPECT_EQ(namesIn(folder.path), std::set<std::string>{"scene.gltf"});
}

TEST(SceneWriter, ErrorsNameWhatIsWrong) {
  const TemporaryFolder folder;
  const auto errorOf = [&](const Scene& scene) {
    auto written = writeScene(folder.path / "bad.gltf", scene);
    EXPECT_FALSE(written);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path));
    return written ? std::string() : message(written.error());
  };
  Scene scene = sceneFromMesh(soup());
  scene.nodes[0].occluder = test::randomOccluder(1);
  scene.nodes[0].occluder->error.rms = std::nan("");
  EXPECT_THAT(errorOf(scene), HasSubstr("bad.gltf: nodes/0/extensions/OVERCAST_occluder/error/rms: is not a number"));
  scene = sceneFromMesh(soup());
  scene.meshes[0].positions[0].x = 1e39;
  EXPECT_THAT(errorOf(scene), HasSubstr("meshes/0"));
  scene = sceneFromMesh(soup());
  scene.animations = {{"", {{0, AnimatedProperty::scale, Interpolation::step, {1.0, 1.0 + 1e-12}, {glm::dvec4(1), glm::dvec4(1)}}}}};
  EXPECT_THAT(errorOf(scene), HasSubstr("animations/0/channels/0"));
  EXPECT_FALSE(writeScene(folder.path / "scene.glb", sceneFromMesh(soup())));
}

TEST(SceneWriter, TheKhronosValidatorFindsNoErrors) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  const auto add = [&](const Scene& scene, const std::string& name) {
    files.push_back(folder.path / name);
    auto written = writeScene(files.back(), scene);
    ASSERT_TRUE(written) << message(written.error());
  };
  for (std::uint64_t seed = 0; seed < 40; ++seed) add(randomScene(seed), std::to_string(seed) + ".gltf");
  add(sheared(), "sheared.gltf");
  add(sceneFromMesh(soup()), "odd name #%\xC3\xBC.gltf");
  add(Scene{}, "empty.gltf");
  Mesh flat;
  flat.name = "\xFFnot UTF-8";
  flat.positions.assign(3, glm::dvec3(0.0));
  flat.normals.assign(3, glm::vec3(0.0f));
  flat.triangles = {{0, 1, 2}};
  add(sceneFromMesh(flat), "degenerate.gltf");
  std::string command = "node '" OVERCAST_SOURCE_FOLDER "/tests/validator/validate.mjs'";
  for (const auto& file : files) command += " '" + file.string() + "'";
  const int status = std::system(command.c_str());
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code == 77 || code == 127) GTEST_SKIP() << "node or its package gltf-validator is missing (set NODE_PATH to find the package)";
  EXPECT_EQ(code, 0);
}

}  // namespace
}  // namespace overcast
