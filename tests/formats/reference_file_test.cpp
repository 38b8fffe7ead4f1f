#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/files.h"
#include "formats/reference.h"
#include "formats/view_options.h"
#include "tests/formats/json_schema.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using Json = nlohmann::ordered_json;
using test::TemporaryFolder;
using testing::HasSubstr;

Reference smallReference(ReferenceKind kind) {
  Reference made;
  ReferenceInfo& info = made.info;
  info.kind = kind;
  info.scene = "room.gltf";
  info.sceneHash = info.inputs = std::string(32, 'a');
  info.frame = 3;
  info.time = 0.1;
  info.width = 3;
  info.height = 2;
  info.camera = "scene";
  info.view = lookAt({1, 2, 3}, {0, 0.5, 0}, {0, 1, 0}, 0.7);
  info.points = 5;
  info.origin = {1e6, -2.0, 0.1};
  info.distanceBound = 0.5;
  info.targetError = 0.003;
  info.seed = std::uint64_t{1} << 60;
  info.seconds = 2.5;
  info.quantities = {{"sky", 1024, 0.5, 0.002, 0.1}, {"colour", 1024, 0.3, 0.001, 0.2}};
  made.image = {3, 2, {"depth", "normal.X", "normal.Y", "normal.Z", "object", "sky", "sky.error", "R", "G", "B", "colour.error"}, {}};
  if (kind == ReferenceKind::points) made.image.channels.insert(made.image.channels.end(), {"position.X", "position.Y", "position.Z"});
  made.image.pixels.resize(6 * made.image.channels.size());
  for (std::size_t i = 0; i < made.image.pixels.size(); ++i) made.image.pixels[i] = 1.0f / static_cast<float>(i + 1);
  return made;
}

TEST(ReferenceFile, IsReadBackAsItWas) {
  const TemporaryFolder folder;
  for (const ReferenceKind kind : {ReferenceKind::view, ReferenceKind::points}) {
    Reference made = smallReference(kind);
    ASSERT_TRUE(writeReference(folder.path / "a.json", made).ok());
    const auto read = readReference(folder.path / "a.json");
    ASSERT_TRUE(read.ok()) << message(read.error());
    EXPECT_EQ(referenceJson(read.value().info), referenceJson(made.info));
    EXPECT_EQ(read.value().info.view.worldFromView == made.info.view.worldFromView, kind == ReferenceKind::view);
    EXPECT_EQ(read.value().info.seed, made.info.seed);
    ASSERT_NE(quantityNamed(read.value().info, "sky"), nullptr);
    EXPECT_EQ(quantityNamed(read.value().info, "sky")->meanError, 0.002);
    EXPECT_EQ(quantityNamed(read.value().info, "light"), nullptr);
    const Image& image = read.value().image;
    for (std::size_t c = 0; c < made.image.channels.size(); ++c)
      EXPECT_EQ(at(image, 2, 1, channelIndex(image, made.image.channels[c])), at(made.image, 2, 1, static_cast<int>(c)))
          << "single floats, bit for bit: " << made.image.channels[c];
    EXPECT_EQ(listReferences(folder.path).value(), std::vector{folder.path / "a.json"});
  }
}

TEST(ReferenceFile, KeepsToItsSchema) {
  const Json schema = test::schema("reference");
  for (const ReferenceKind kind : {ReferenceKind::view, ReferenceKind::points}) {
    Reference made = smallReference(kind);
    made.info.picture = made.info.pictureHash = "x";
    EXPECT_EQ(test::violation(schema, Json::parse(referenceJson(made.info)), schema), "");
  }
}

TEST(ReferenceFile, WhatIsWrongIsNamed) {
  Reference made = smallReference(ReferenceKind::view);
  made.info.picture = made.info.pictureHash = "x";
  const Json good = Json::parse(referenceJson(made.info));
  const auto with = [&](const std::string& pointer, const Json& value) {
    Json changed = good;
    changed[Json::json_pointer(pointer)] = value;
    const auto parsed = parseReferenceInfo(changed.dump(), "x");
    return parsed ? "" : message(parsed.error());
  };
  EXPECT_EQ(with("/later", 1), "") << "fields of later versions are passed over";
  EXPECT_THAT(with("/version", 2), HasSubstr("newer"));
  EXPECT_THAT(with("/format", "picture"), HasSubstr("picture"));
  EXPECT_THAT(with("/kind", "film"), HasSubstr("film"));
  EXPECT_THAT(with("/picture", "../x.exr"), HasSubstr("same folder"));
  EXPECT_THAT(with("/width", 20000), HasSubstr("width"));
  EXPECT_THAT(with("/quantities/1/name", "smell"), HasSubstr("quantities/1/name"));
  EXPECT_THAT(with("/quantities/0/meanError", -1), HasSubstr("quantities/0/meanError"));
  EXPECT_THAT(with("/camera/eye", 1), HasSubstr("camera/eye"));
}

TEST(ReferenceFile, OnlyTheWholePictureItNamesIsTaken) {
  const TemporaryFolder folder;
  const auto json = folder.path / "a.json";
  Reference made = smallReference(ReferenceKind::view);
  ASSERT_TRUE(writeReference(json, made).ok());
  std::filesystem::resize_file(folder.path / "a.exr", std::filesystem::file_size(folder.path / "a.exr") - 1);
  EXPECT_THAT(message(readReference(json).error()), HasSubstr("a.exr"));
  std::filesystem::remove(folder.path / "a.exr");
  EXPECT_THAT(message(readReference(json).error()), HasSubstr("a.exr"));
  // A picture without what the .json promises, and one of another size.
  for (const char* change : {"sky.error", "size"}) {
    Image image = made.image;
    if (std::string(change) == "size") {
      image.width = 2;
      image.height = 3;
    } else {
      image.channels[6] = "other";
    }
    ASSERT_TRUE(writeExr(folder.path / "a.exr", image, ExrBits::single).ok());
    ReferenceInfo info = made.info;
    info.pictureHash = fileHash(folder.path / "a.exr").value();
    test::spill(json, referenceJson(info));
    EXPECT_THAT(message(readReference(json).error()), HasSubstr(std::string(change) == "size" ? "pixels" : change));
  }
}

TEST(ReferenceFile, DamagedJsonEndsInAnErrorOrInNumbersWithinTheirRange) {
  Reference made = smallReference(ReferenceKind::points);
  made.info.picture = made.info.pictureHash = "x";
  const std::string good = referenceJson(made.info);
  int errors = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (const char byte : {'\0', '9', '"', '-', '}'}) {
      std::string bad = good;
      bad[i] = byte;
      const auto parsed = parseReferenceInfo(bad, "x");
      errors += !parsed.ok();
      if (!parsed) continue;
      EXPECT_LE(parsed.value().points, static_cast<std::uint64_t>(parsed.value().width * parsed.value().height));
    }
  }
  EXPECT_GT(errors, 1000);
}

Scene trianglePlaced(double x) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.parts = {{0, 1, 0}};
  Scene scene;
  scene.meshes = {mesh};
  scene.materials.emplace_back();
  scene.nodes.emplace_back();
  scene.nodes[0].mesh = 0;
  scene.nodes[0].translation.x = x;
  return scene;
}

TEST(TracedHash, ChangesWithWhatRaysMeetAlone) {
  const Scene scene = trianglePlaced(0.0);
  const std::string hash = tracedHash(scene, 0.0);
  EXPECT_EQ(hash, "25b7af6e0892014413474606c1c60260")
      << "references that were traced stay good, whatever the defaults of what is not traced";
  EXPECT_NE(hash, tracedHash(trianglePlaced(1.0), 0.0));
  const auto changed = [&](auto change) {
    Scene other = scene;
    change(other);
    return tracedHash(other, 0.0) != hash;
  };
  EXPECT_FALSE(changed([](Scene& s) { s.lighting.emplace(); })) << "the default lighting";
  EXPECT_FALSE(changed([](Scene& s) { s.lighting.emplace().estimator.k = 3.0f; }));
  EXPECT_FALSE(changed([](Scene& s) { s.lighting.emplace().globalVolume.resolution = 64; }));
  EXPECT_FALSE(changed([](Scene& s) { s.nodes[0].occluder.emplace(); }));
  EXPECT_TRUE(changed([](Scene& s) { s.lighting.emplace().skyColour.y = 0.1f; }));
  EXPECT_TRUE(changed([](Scene& s) { s.lighting.emplace().areaLights.emplace_back(); }));
  EXPECT_TRUE(changed([](Scene& s) { s.materials[0].baseColour.x = 0.1f; }));
  EXPECT_TRUE(changed([](Scene& s) { s.meshes[0].positions[1].y = 0.1; }));
  EXPECT_TRUE(changed([](Scene& s) { s.meshes[0].triangles[0] = {0, 2, 1}; }));
}

TEST(ViewOptions, AskedForBeforeTheScenesOwnBeforeAll) {
  Scene scene = trianglePlaced(0.0);
  const Box bounds = worldBounds(scene);
  const glm::dmat4 all = frameBox(bounds, {0, 1, 0}, 2.0).worldFromView;
  EXPECT_EQ(chooseView(scene, bounds, std::nullopt, 0.0, 2.0).worldFromView, all);
  scene.cameras.emplace_back();
  scene.nodes.emplace_back().camera = 0;
  EXPECT_EQ(chooseView(scene, bounds, std::nullopt, 0.0, 2.0).worldFromView, glm::dmat4(1.0));
  const CameraOption camera = parseCamera("1,2,3,0,0,0,60").value();
  EXPECT_EQ(glm::dvec3(chooseView(scene, bounds, camera, 0.0, 2.0).worldFromView[3]), glm::dvec3(1, 2, 3));
}

}  // namespace
}  // namespace overcast
