// What readScene makes of glTF files that the tests build themselves.
#include "formats/scene.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/extension_json.h"
#include "tests/formats/gltf_builder.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using test::GltfBuilder;
using test::TemporaryFolder;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

Scene read(const GltfBuilder& builder) {
  const TemporaryFolder folder;
  auto scene = readScene(builder.gltf(folder.path));
  EXPECT_TRUE(scene) << message(scene.error());
  return scene ? scene.value() : Scene{};
}

std::string errorOf(const GltfBuilder& builder) {
  const TemporaryFolder folder;
  auto scene = readScene(builder.gltf(folder.path));
  EXPECT_FALSE(scene);
  if (scene) return "";
  EXPECT_THAT(scene.error().file, HasSubstr("scene.gltf"));
  EXPECT_EQ(message(scene.error()).find('\n'), std::string::npos);
  return scene.error().place + ": " + scene.error().reason;
}

/// Positions 0, 1, 2, ... along x, so that a triangle's corners can be told apart.
GltfBuilder numbered(int count, int mode, std::vector<std::uint16_t> indices = {}) {
  GltfBuilder builder;
  std::vector<float> positions;
  for (int i = 0; i < count; ++i) positions.insert(positions.end(), {static_cast<float>(i), 0.0f, 0.0f});
  const int position = builder.floats(positions, 3);
  builder.show(position, indices.empty() ? -1 : builder.indices(indices), mode);
  return builder;
}

using Triangles = std::vector<glm::uvec3>;

TEST(Scene, KnowsItsFileNames) {
  EXPECT_TRUE(isSceneFile("a/b.gltf"));
  EXPECT_TRUE(isSceneFile("b.GLB"));
  EXPECT_FALSE(isSceneFile("b.obj"));
  EXPECT_FALSE(isSceneFile("gltf"));
}

TEST(Scene, ReadsTrianglesIndexedOrNot) {
  EXPECT_EQ(read(numbered(6, 4)).meshes[0].triangles, (Triangles{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_EQ(read(numbered(4, 4, {2, 1, 0, 3, 2, 0})).meshes[0].triangles, (Triangles{{2, 1, 0}, {3, 2, 0}}));
}

TEST(Scene, StripsAndFansKeepTheirWinding) {  // glTF 2.0, 3.7.2.1
  EXPECT_EQ(read(numbered(5, 5)).meshes[0].triangles, (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
  EXPECT_EQ(read(numbered(5, 6)).meshes[0].triangles, (Triangles{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}));
  EXPECT_EQ(read(numbered(6, 5, {5, 4, 3, 2})).meshes[0].triangles, (Triangles{{5, 4, 3}, {4, 2, 3}}));
}

TEST(Scene, PointsAndLinesAreLeftOutWithANote) {
  const Scene scene = read(numbered(5, 1));
  EXPECT_TRUE(scene.meshes.empty());
  EXPECT_EQ(scene.nodes[0].mesh, -1);
  EXPECT_THAT(scene.notes, Contains(HasSubstr("points or lines")));
}

TEST(Scene, NoTrianglesAtAllIsNoError) {
  GltfBuilder builder;
  builder.json["nodes"].push_back({{"name", "empty"}});
  const Scene scene = read(builder);
  EXPECT_TRUE(scene.meshes.empty());
  EXPECT_EQ(scene.nodes.size(), 1u);
}

TEST(Scene, PrimitivesBecomePartsAndShareVertices) {
  GltfBuilder builder;
  builder.json["materials"] = {{{"name", "a"}}, {{"name", "b"}}};
  const int position = builder.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, 3);
  builder.show(position, builder.indices({0, 1, 2}));
  auto& primitives = builder.json["meshes"][0]["primitives"];
  primitives[0]["material"] = 1;
  primitives.push_back({{"attributes", {{"POSITION", position}}}, {"indices", builder.indices({2, 1, 3})}});
  const Scene scene = read(builder);
  const Mesh& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.triangles, (Triangles{{0, 1, 2}, {2, 1, 3}}));
  ASSERT_EQ(mesh.parts.size(), 2u);
  EXPECT_EQ(mesh.parts[0].material, 1);
  EXPECT_EQ(mesh.parts[1].material, -1);
  EXPECT_EQ(mesh.parts[1].firstTriangle, 1u);
}

TEST(Scene, OutOfRangeIndicesNameThePrimitive) {
  EXPECT_THAT(errorOf(numbered(3, 4, {0, 1, 3})), HasSubstr("meshes/0/primitives/0: indices: 3 is outside the 3 vertices"));
}

TEST(Scene, TrianglesOfNonFinitePositionsAreLeftOut) {
  GltfBuilder builder;
  builder.show(builder.floats({0, 0, 0, 1, 0, 0, 0, kNan, 0, 1, 1, 0}, 3), builder.indices({0, 1, 2, 0, 1, 3}));
  const Scene scene = read(builder);
  EXPECT_EQ(scene.meshes.at(0).triangles, (Triangles{{0, 1, 3}}));
  for (const glm::dvec3& p : scene.meshes[0].positions) EXPECT_TRUE(std::isfinite(p.y));
  EXPECT_THAT(scene.notes, Contains(HasSubstr("1 vertices are not finite")));
}

TEST(Scene, ReadsInterleavedVertices) {
  GltfBuilder builder;
  const int view = builder.view(std::vector<float>{9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0}, 16);
  builder.show(builder.accessor({{"bufferView", view}, {"byteOffset", 4}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}));
  EXPECT_EQ(read(builder).meshes.at(0).positions, (std::vector<glm::dvec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
}

TEST(Scene, ReadsNormalisedAndPlainIntegers) {  // KHR_mesh_quantization
  GltfBuilder builder;
  builder.json["extensionsRequired"] = {"KHR_mesh_quantization"};
  const int bytes = builder.view(std::vector<std::int8_t>{127, -127, -128, 0, 64, 0, 0, 0, 0, 127, 0, 0}, 4);
  builder.show(builder.accessor({{"bufferView", bytes}, {"componentType", 5120}, {"normalized", true}, {"count", 3}, {"type", "VEC3"}}));
  const int shorts = builder.view(std::vector<std::uint16_t>{65535, 0, 1, 0, 7, 8, 9, 0, 1, 1, 1, 0}, 8);
  builder.show(builder.accessor({{"bufferView", shorts}, {"componentType", 5123}, {"normalized", true}, {"count", 3}, {"type", "VEC3"}}));
  builder.show(builder.accessor({{"bufferView", shorts}, {"componentType", 5122}, {"count", 3}, {"type", "VEC3"}}));
  const Scene scene = read(builder);
  EXPECT_EQ(scene.meshes.at(0).positions[0], glm::dvec3(1.0, -1.0, -1.0));
  EXPECT_EQ(scene.meshes.at(0).positions[1], glm::dvec3(64.0 / 127.0, 0.0, 0.0));
  EXPECT_EQ(scene.meshes.at(1).positions[0], glm::dvec3(1.0, 0.0, 1.0 / 65535.0));
  EXPECT_EQ(scene.meshes.at(2).positions[0], glm::dvec3(-1.0, 0.0, 1.0));
}

TEST(Scene, ReadsSparseAccessorsOverDataAndOverZeros) {
  GltfBuilder builder;
  const int dense = builder.view(std::vector<float>{1, 1, 1, 2, 2, 2, 3, 3, 3});
  const int where = builder.view(std::vector<std::uint16_t>{2, 0});
  const int what = builder.view(std::vector<float>{7, 8, 9, 4, 5, 6});
  const nlohmann::ordered_json sparse = {
      {"count", 2}, {"indices", {{"bufferView", where}, {"componentType", 5123}}}, {"values", {{"bufferView", what}}}};
  builder.show(builder.accessor({{"bufferView", dense}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}, {"sparse", sparse}}));
  builder.show(builder.accessor({{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}, {"sparse", sparse}}));
  const Scene scene = read(builder);
  EXPECT_THAT(scene.meshes.at(0).positions, ElementsAre(glm::dvec3(4, 5, 6), glm::dvec3(2, 2, 2), glm::dvec3(7, 8, 9)));
  EXPECT_THAT(scene.meshes.at(1).positions, ElementsAre(glm::dvec3(4, 5, 6), glm::dvec3(0), glm::dvec3(7, 8, 9)));
  builder.json["accessors"][0]["sparse"]["count"] = 4;
  EXPECT_THAT(errorOf(builder), HasSubstr("accessors/0/sparse/count"));
}

TEST(Scene, AccessorsOutsideTheirBytesAreErrors) {
  const auto broken = [](const char* list, const char* key, const nlohmann::ordered_json& value) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json[list][0][key] = value;
    return errorOf(builder);
  };
  EXPECT_THAT(broken("accessors", "count", 4), HasSubstr("accessors/0/bufferViews/0: 4 elements"));
  EXPECT_THAT(broken("accessors", "count", 18446744073709551615ull), HasSubstr("accessors/0/count"));
  EXPECT_THAT(broken("accessors", "byteOffset", 18446744073709551612ull), HasSubstr("bufferViews/0"));
  EXPECT_THAT(broken("accessors", "bufferView", 7), HasSubstr("bufferViews/7: does not exist"));
  EXPECT_THAT(broken("accessors", "type", "VEC2"), HasSubstr("has 2 components where 3 are needed"));
  EXPECT_THAT(broken("accessors", "componentType", 5124), HasSubstr("componentType"));
  EXPECT_THAT(broken("bufferViews", "byteLength", 18446744073709551615ull), HasSubstr("are outside buffer 0"));
  EXPECT_THAT(broken("bufferViews", "byteOffset", 18446744073709551615ull), HasSubstr("are outside buffer 0"));
  EXPECT_THAT(broken("bufferViews", "buffer", 1), HasSubstr("buffer 1 does not exist"));
}

TEST(Scene, ACountWithoutDataIsBounded) {
  GltfBuilder builder;
  builder.show(builder.accessor({{"componentType", 5126}, {"count", 4000000000u}, {"type", "VEC3"}}));
  EXPECT_THAT(errorOf(builder), HasSubstr("accessors/0/count"));
}

TEST(Scene, ReadsTransformsOfEveryKind) {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["nodes"][0]["scale"] = {-1, 2, 0};
  builder.json["nodes"][0]["translation"] = {1, 2, 3};
  builder.json["nodes"][0]["rotation"] = {0, 0, 2, 2};  // a quarter turn about z, not of unit length
  builder.json["nodes"].push_back({{"matrix", {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 10, 0, 11, 12, 13, 1}}});
  builder.root(1);
  const Scene scene = read(builder);
  const auto world = worldFromLocal(scene, 0.0);
  const glm::dvec4 p = world[0] * glm::dvec4(1, 1, 1, 1);
  EXPECT_NEAR(p.x, 1.0 - 2.0, 1e-15);
  EXPECT_NEAR(p.y, 2.0 - 1.0, 1e-15);
  EXPECT_NEAR(p.z, 3.0, 1e-15);
  EXPECT_EQ(world[1] * glm::dvec4(1, 0, 0, 1), glm::dvec4(12, 14, 16, 1));
}

TEST(Scene, BrokenTransformsNameTheirField) {
  const auto broken = [](const char* key, const nlohmann::ordered_json& value) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["nodes"][0][key] = value;
    return errorOf(builder);
  };
  EXPECT_THAT(broken("translation", {1, 2}), HasSubstr("nodes/0/translation: has 2 numbers, not 3"));
  EXPECT_THAT(broken("rotation", {0, 0, 0, 0}), HasSubstr("nodes/0/rotation: is not a unit quaternion"));
  EXPECT_THAT(broken("matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}), HasSubstr("nodes/0/matrix: is not affine"));
  EXPECT_THAT(broken("mesh", 1), HasSubstr("nodes/0/mesh: 1 does not exist"));
  EXPECT_THAT(broken("camera", 0), HasSubstr("nodes/0/camera: 0 does not exist"));
}

TEST(Scene, OnlyTheDefaultSceneIsRead) {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["nodes"] = {{{"name", "elsewhere"}, {"mesh", 0}}, {{"name", "child"}}, {{"name", "root"}, {"children", {1}}}};
  builder.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {2}}, {"name", "shown"}}};
  builder.json["scene"] = 1;
  const Scene scene = read(builder);
  EXPECT_EQ(scene.name, "shown");
  ASSERT_EQ(scene.nodes.size(), 2u);
  EXPECT_EQ(scene.nodes[0].name, "child");
  EXPECT_EQ(scene.nodes[0].parent, 1);
  EXPECT_THAT(scene.nodes[1].children, ElementsAre(0));
  EXPECT_TRUE(scene.meshes.empty()) << "no node of the default scene shows it";
  EXPECT_THAT(scene.notes, Contains(HasSubstr("1 nodes outside the default scene")));
}

TEST(Scene, NodesMustFormTrees) {
  GltfBuilder builder;
  builder.json["nodes"] = {{{"children", {1}}}, {{"children", {0}}}};
  EXPECT_THAT(errorOf(builder), HasSubstr("is part of a cycle"));
  builder.json["nodes"] = {{{"children", {0}}}};
  EXPECT_THAT(errorOf(builder), HasSubstr("nodes/0: is part of a cycle"));
  builder.json["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"name", "shared"}}};
  EXPECT_THAT(errorOf(builder), HasSubstr("nodes/2: has more than one parent"));
  builder.json["nodes"] = {{{"children", {5}}}};
  EXPECT_THAT(errorOf(builder), HasSubstr("nodes/0/children: 5 does not exist"));
}

TEST(Scene, DeepHierarchiesNeedNoDeepStack) {
  constexpr int kDepth = 30000;
  GltfBuilder builder;
  for (int i = 0; i < kDepth; ++i) {
    builder.json["nodes"].push_back({{"translation", {1, 0, 0}}});
    if (i + 1 < kDepth) builder.json["nodes"][static_cast<std::size_t>(i)]["children"] = {i + 1};
  }
  builder.root(0);
  const Scene scene = read(builder);
  EXPECT_EQ(worldFromLocal(scene, 0.0).back()[3].x, kDepth);
}

TEST(Scene, ReadsBaseColours) {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["materials"] = {{{"name", "plain"}},
                               {{"pbrMetallicRoughness", {{"baseColorFactor", {0.25, 0.5, 0.75, 1.0}}}}},
                               {{"extensions", {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {0.5, 0, 1, 0.5}}}}}}},
                               {{"pbrMetallicRoughness", {{"baseColorFactor", {2.0, -1.0, 0.5, 1.0}}}}}};
  const Scene scene = read(builder);
  EXPECT_EQ(scene.materials.at(0).baseColour, glm::vec4(1.0f)) << "glTF's default";
  EXPECT_EQ(scene.materials.at(1).baseColour, glm::vec4(0.25f, 0.5f, 0.75f, 1.0f));
  EXPECT_EQ(scene.materials.at(2).baseColour, glm::vec4(0.5f, 0.0f, 1.0f, 0.5f));
  EXPECT_EQ(scene.materials.at(3).baseColour, glm::vec4(1.0f, 0.0f, 0.5f, 1.0f));
  EXPECT_THAT(scene.notes, Contains(HasSubstr("1 base colours")));
}

TEST(Scene, TexturesDoNotMatter) {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["images"] = {
      {{"uri", "missing.png"}}, {{"uri", "data:image/ktx2;base64,AAAA"}}, {{"bufferView", 99}, {"mimeType", "image/png"}}};
  builder.json["textures"] = {{{"source", 0}}};
  EXPECT_EQ(read(builder).meshes.size(), 1u);
}

TEST(Scene, CamerasThatAreNotPerspectiveAreLeftOut) {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["cameras"] = {{{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"zfar", 10}, {"znear", 1}}}},
                             {{"type", "perspective"}, {"name", "eye"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.25}}}}};
  builder.json["nodes"][0]["camera"] = 1;
  builder.json["nodes"].push_back({{"camera", 0}});
  builder.root(1);
  const Scene scene = read(builder);
  ASSERT_EQ(scene.cameras.size(), 1u);
  EXPECT_EQ(scene.cameras[0].verticalFieldOfView, 0.5);
  EXPECT_EQ(scene.nodes[0].camera, 0);
  EXPECT_EQ(scene.nodes[1].camera, -1);
  EXPECT_THAT(scene.notes, Contains(HasSubstr("1 cameras")));
}

TEST(Scene, SkinsAndMorphTargetsAreShownUndeformed) {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}};
  builder.json["nodes"][0]["skin"] = 0;
  builder.json["skins"] = {{{"joints", {0}}}};
  const Scene scene = read(builder);
  EXPECT_EQ(scene.meshes.at(0).triangles.size(), 1u);
  EXPECT_THAT(scene.notes, Contains(HasSubstr("1 skinned nodes")));
  EXPECT_THAT(scene.notes, Contains(HasSubstr("1 primitives with morph targets")));
}

TEST(Scene, ExtensionsThatChangeGeometryAreErrors) {
  const auto required = [](const char* name) {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.json["extensionsRequired"] = {name};
    builder.json["extensionsUsed"] = {name};
    return builder;
  };
  EXPECT_THAT(errorOf(required("KHR_draco_mesh_compression")), HasSubstr("extensionsRequired: KHR_draco_mesh_compression"));
  EXPECT_THAT(errorOf(required("ACME_unheard_of")), HasSubstr("ACME_unheard_of"));
  EXPECT_EQ(read(required("KHR_texture_transform")).meshes.size(), 1u);
  EXPECT_EQ(read(required("KHR_materials_unlit")).meshes.size(), 1u);
  EXPECT_THAT(read(required("CESIUM_RTC")).notes, Contains("extension CESIUM_RTC was left out"));
}

TEST(Scene, CompressedGeometryNeedsPlainDataBesideIt) {
  GltfBuilder draco = GltfBuilder::triangle();
  draco.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0},
                                                                                          {"attributes", {{"POSITION", 0}}}};
  EXPECT_EQ(read(draco).meshes.size(), 1u);
  draco.json["accessors"][0].erase("bufferView");
  EXPECT_THAT(errorOf(draco), HasSubstr("meshes/0/primitives/0: KHR_draco_mesh_compression without plain data"));

  GltfBuilder meshopt = GltfBuilder::triangle();
  meshopt.json["extensionsRequired"] = {"EXT_meshopt_compression"};
  EXPECT_EQ(read(meshopt).meshes.size(), 1u);
  meshopt.json["buffers"] = {{{"byteLength", 42}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  EXPECT_THAT(errorOf(meshopt), HasSubstr("buffers/0: EXT_meshopt_compression without a fallback buffer"));
}

TEST(Scene, OtherVersionsAreErrors) {
  GltfBuilder builder;
  builder.json["asset"]["version"] = "1.0";
  EXPECT_THAT(errorOf(builder), HasSubstr("asset/version: '1.0' is not supported"));
  builder.json["asset"] = {{"version", "2.1"}, {"minVersion", "2.1"}};
  EXPECT_THAT(errorOf(builder), HasSubstr("asset/minVersion"));
  builder.json["asset"] = {{"version", "2.1"}};
  EXPECT_TRUE(read(builder).nodes.empty());
  builder.json.erase("asset");
  EXPECT_THAT(errorOf(builder), HasSubstr("asset/version: is missing"));
}

TEST(Scene, BuffersStayInsideTheFolder) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path / "inside" / "a b");
  GltfBuilder builder = GltfBuilder::triangle();
  GltfBuilder::save(folder.path / "outside.bin", builder.bytes);
  GltfBuilder::save(folder.path / "inside" / "a b" / "longer.bin", builder.bytes + "trailing bytes are legal");
  GltfBuilder::save(folder.path / "inside" / "short.bin", builder.bytes.substr(1));
  const auto with = [&](const std::string& uri) {
    builder.json["buffers"] = {{{"uri", uri}, {"byteLength", builder.bytes.size()}}};
    return readScene(builder.gltf(folder.path / "inside"));
  };
  EXPECT_TRUE(with("a%20b/longer.bin"));
  for (const std::string uri : {"../outside.bin", "%2e%2e/outside.bin", "file:///etc/passwd", "/etc/passwd", "missing.bin"}) {
    auto scene = with(uri);
    ASSERT_FALSE(scene) << uri;
    EXPECT_EQ(scene.error().place, "buffers/0/uri") << uri;
  }
  auto cut = with("short.bin");
  ASSERT_FALSE(cut);
  EXPECT_THAT(message(cut.error()), HasSubstr("buffers/0: has 41 bytes but byteLength says 42"));
}

TEST(Scene, KnowsTheFilesItIsReadFrom) {
  const TemporaryFolder folder;
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["buffers"] = {{{"uri", "a%20b.bin"}, {"byteLength", 42}}, {{"uri", "data:,x"}}, {{"byteLength", 1}}, {{"uri", "c.bin"}}};
  builder.json["images"] = {{{"uri", "picture.png"}}};
  const auto path = builder.gltf(folder.path);
  const auto files = sceneFiles(path);
  ASSERT_TRUE(files) << message(files.error());
  EXPECT_THAT(files.value(), testing::ElementsAre(path, folder.path / "a b.bin", folder.path / "c.bin"));
  const auto glb = GltfBuilder::triangle().glb(folder.path);
  EXPECT_THAT(sceneFiles(glb).value(), testing::ElementsAre(glb));
  builder.json["buffers"] = {{{"uri", "../out.bin"}}};
  EXPECT_THAT(message(sceneFiles(builder.gltf(folder.path)).error()), HasSubstr("buffers/0/uri: leaves the folder"));
  EXPECT_FALSE(sceneFiles(folder.path / "missing.gltf"));
  GltfBuilder::save(folder.path / "no.gltf", "[1]");
  EXPECT_FALSE(sceneFiles(folder.path / "no.gltf"));
}

TEST(Scene, ReadsGlbAndDataUris) {
  const TemporaryFolder folder;
  GltfBuilder builder = GltfBuilder::triangle();
  auto glb = readScene(builder.glb(folder.path));
  ASSERT_TRUE(glb) << message(glb.error());
  EXPECT_EQ(glb.value().meshes.at(0).positions[1], glm::dvec3(1, 0, 0));
  GltfBuilder inlined;
  inlined.json["buffers"] = {
      {{"uri", "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}, {"byteLength", 36}}};
  inlined.json["bufferViews"] = {{{"buffer", 0}, {"byteLength", 36}}};
  inlined.show(inlined.accessor({{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}));
  EXPECT_EQ(read(inlined).meshes.at(0).positions[2], glm::dvec3(0, 1, 0));
}

TEST(Scene, BrokenGlbHeadersAreErrors) {
  const TemporaryFolder folder;
  const std::string whole = GltfBuilder::triangle().glbBytes();
  const auto with = [&](const std::string& bytes) {
    GltfBuilder::save(folder.path / "a.glb", bytes);
    auto scene = readScene(folder.path / "a.glb");
    return scene ? std::string("read") : scene.error().place + ": " + scene.error().reason;
  };
  EXPECT_EQ(with(whole), "read");
  EXPECT_THAT(with(whole.substr(0, 19)), HasSubstr("GLB header: is cut short"));
  EXPECT_THAT(with(whole.substr(0, whole.size() - 1)), HasSubstr("GLB header: says"));
  std::string broken = whole;
  broken[4] = 1;
  EXPECT_THAT(with(broken), HasSubstr("version 1 is not supported"));
  broken = whole;
  broken[15] = '\x7f';
  EXPECT_THAT(with(broken), HasSubstr("GLB chunk 0: is longer than the file"));
  broken = whole;
  broken[16] = 'B';
  EXPECT_THAT(with(broken), HasSubstr("GLB chunk 0: is not JSON"));
}

TEST(Scene, MissingAndEmptyFilesAreErrors) {
  const TemporaryFolder folder;
  GltfBuilder::save(folder.path / "empty.gltf", "");
  for (const char* file : {"empty.gltf", "missing.gltf", "."}) {
    auto scene = readScene(folder.path / file);
    ASSERT_FALSE(scene) << file;
    EXPECT_THAT(message(scene.error()), HasSubstr(folder.path.string()));
  }
}

TEST(Scene, FarMeshesAreRecentred) {
  Mesh mesh;
  mesh.name = "far";
  mesh.positions = {{1e6, 0, 0}, {1e6 + 1, 0, 0}, {1e6, 1.0 / 1024.0, 0}};
  mesh.triangles = {{0, 1, 2}};
  const Scene far = sceneFromMesh(mesh);
  EXPECT_EQ(far.nodes[0].translation, glm::dvec3(1e6 + 0.5, 1.0 / 2048.0, 0.0));
  EXPECT_EQ(far.meshes[0].positions[0], glm::dvec3(-0.5, -1.0 / 2048.0, 0.0));
  const Box box = worldBounds(far);
  EXPECT_EQ(box.min, glm::dvec3(1e6, 0, 0));
  EXPECT_EQ(box.max, glm::dvec3(1e6 + 1, 1.0 / 1024.0, 0));
  for (glm::dvec3& p : mesh.positions) p.x -= 1e6 - 60.0;
  const Scene near = sceneFromMesh(mesh);
  EXPECT_EQ(near.nodes[0].translation, glm::dvec3(0.0));
  ASSERT_EQ(near.meshes[0].parts.size(), 1u);
  EXPECT_EQ(near.meshes[0].parts[0].material, 0);
  EXPECT_EQ(near.materials.size(), 1u);
  EXPECT_EQ(near.nodes[0].name, "far");
}

TEST(Scene, LightsMoveWithTheNodesThatTheFileNames) {
  GltfBuilder builder = GltfBuilder::triangle();
  Lighting lighting;
  lighting.areaLights.resize(2);
  const auto attach = [&](int node) {
    lighting.areaLights[1].node = node;
    builder.json["scenes"][0]["extensions"]["OVERCAST_lighting"] = nlohmann::json::parse(lightingJson(lighting));
  };
  builder.json["nodes"] = {{{"name", "outside"}}, {{"name", "lamp"}}};
  builder.json["scenes"][0]["nodes"] = {1};
  attach(1);
  const Scene scene = read(builder);
  ASSERT_EQ(scene.nodes.size(), 1u);
  EXPECT_EQ(scene.lighting->areaLights[0].node, -1);
  EXPECT_EQ(scene.lighting->areaLights[1].node, 0) << "counted among the nodes of the scene";
  for (const int missing : {0, 2}) {
    attach(missing);
    EXPECT_THAT(errorOf(builder), HasSubstr(fmt::format("areaLights/1/node: {} is no node of the scene", missing)));
  }
}

TEST(Scene, BrokenOvercastExtensionsNameNodeAndField) {
  GltfBuilder builder = GltfBuilder::triangle();
  builder.json["nodes"][0]["extensions"]["OVERCAST_occluder"] = {{"version", 99}};
  EXPECT_THAT(errorOf(builder), HasSubstr("nodes/0/extensions/OVERCAST_occluder/version: 99 is newer than 1"));
  builder.json["nodes"][0].erase("extensions");
  builder.json["scenes"][0]["extensions"]["OVERCAST_lighting"] = {{"version", 1}};
  EXPECT_THAT(errorOf(builder), HasSubstr("scenes/0/extensions/OVERCAST_lighting/sky: is missing"));
}

}  // namespace
}  // namespace overcast
