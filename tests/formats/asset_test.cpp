// Assets: every kind through its file and back, and what readAsset refuses.
#include "formats/asset.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "formats/extension_json.h"
#include "formats/files.h"
#include "tests/formats/temporary_folder.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using testing::HasSubstr;

Volume smallVolume() {
  Volume volume;
  volume.size = {4, 5, 6};
  volume.origin = {-1.0, -1.5, -2.0};
  volume.voxelSize = 0.5;
  volume.signMethod = "closed-form";
  for (int k = 0; k < 6; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 4; ++i)
        volume.distance.push_back(static_cast<float>(glm::length(volume.origin + 0.5 * glm::dvec3(i, j, k)) - 0.75));
  return asStored(volume);
}

Primitive smallPrimitive() {
  return {PrimitiveShape::ellipsoid, {0.1, 0.2, -0.3}, glm::normalize(glm::dquat(1.0, 0.3, -0.2, 0.5)), {0.5, 0.25, 1.0}};
}

class Assets : public testing::Test {
 protected:
  test::TemporaryFolder folder;
};

TEST_F(Assets, ReadBackWhatWasWrittenAndSampleTheSame) {
  for (const Asset& asset : {Asset(smallVolume()), Asset(smallPrimitive())}) {
    Occluder occluder;
    const auto bytes = writeAsset(folder.path, "assets/thing", asset, occluder);
    ASSERT_TRUE(bytes.ok()) << message(bytes.error());
    EXPECT_EQ(occluder.bytes, bytes.value());
    EXPECT_EQ(occluder.representation, representationOf(asset));
    EXPECT_EQ(occluder.lipschitz, lipschitzBound(asset));
    EXPECT_EQ(occluder.bounds.min, bounds(asset).min);
    const auto parsed = parseOccluder(occluderJson(occluder), "x");
    ASSERT_TRUE(parsed.ok()) << message(parsed.error());
    const auto read = readAsset(folder.path, parsed.value());
    ASSERT_TRUE(read.ok()) << message(read.error());
    for (const glm::dvec3& p : reference::randomPoints({glm::dvec3(-4.0), glm::dvec3(4.0)}, 300, 3))
      EXPECT_EQ(sampleAsset(read.value(), p), sampleAsset(asset, p));
  }
}

TEST_F(Assets, EncodeToTheBytesThatAreWritten) {
  for (const Asset& asset : {Asset(smallVolume()), Asset(smallPrimitive())}) {
    Occluder written, described;
    ASSERT_TRUE(writeAsset(folder.path, "thing", asset, written).ok());
    const auto encoded = encodeAsset(asset, described);
    ASSERT_TRUE(encoded.ok());
    EXPECT_EQ(described.uri, "");
    described.uri = encoded.value().extension.empty() ? "" : "thing" + encoded.value().extension;
    EXPECT_EQ(occluderJson(described), occluderJson(written));
    if (written.uri.empty()) continue;
    EXPECT_EQ(readFile(folder.path / written.uri).value(), encoded.value().bytes);
  }
}

// The URI in the JSON is percent-encoded once and decoded once.
TEST_F(Assets, AnyFileNameSurvivesTheUri) {
  Occluder occluder;
  ASSERT_TRUE(writeAsset(folder.path, "100%41 b", Asset(smallVolume()), occluder).ok());
  const auto parsed = parseOccluder(occluderJson(occluder), "x");
  ASSERT_TRUE(parsed.ok()) << message(parsed.error());
  EXPECT_TRUE(readAsset(folder.path, parsed.value()).ok());
}

TEST_F(Assets, AnOccluderThatChangesItsKindForgetsTheOldOne) {
  Occluder occluder;
  ASSERT_TRUE(writeAsset(folder.path, "thing", smallPrimitive(), occluder).ok());
  EXPECT_EQ(occluder.bytes, kPrimitiveBytes);
  ASSERT_TRUE(writeAsset(folder.path, "thing", smallVolume(), occluder).ok());
  EXPECT_FALSE(occluder.primitive);
  EXPECT_EQ(occluder.uri, "thing.vdb");
  EXPECT_EQ(occluder.signMethod, "closed-form");
  ASSERT_TRUE(writeAsset(folder.path, "thing", smallPrimitive(), occluder).ok());
  EXPECT_EQ(occluder.uri, "");
  EXPECT_EQ(occluder.contentHash, "");
}

TEST_F(Assets, FilesThatAreNotTheOnesBakedAreNamed) {
  Occluder occluder;
  ASSERT_TRUE(writeAsset(folder.path, "thing", smallVolume(), occluder).ok());
  const auto errorOf = [&](const Occluder& changed) { return message(readAsset(folder.path, changed).error()); };
  Occluder changed = occluder;
  changed.uri = "../thing.vdb";
  EXPECT_THAT(errorOf(changed), HasSubstr("thing.vdb"));
  changed.uri = "gone.vdb";
  EXPECT_THAT(errorOf(changed), HasSubstr("gone.vdb"));
  changed = occluder;
  changed.representation = Representation::primitive;
  EXPECT_THAT(errorOf(changed), HasSubstr("primitive: is missing"));
  std::ofstream(folder.path / "thing.vdb", std::ios::app) << "x";
  EXPECT_THAT(errorOf(occluder), HasSubstr("thing.vdb: its content hash is"));
}

TEST_F(Assets, PrimitivesOutOfRangeAreNotWritten) {
  Primitive thin = smallPrimitive();
  thin.halfExtents.x = 1e-9;
  Occluder occluder;
  EXPECT_FALSE(writeAsset(folder.path, "thing", thin, occluder).ok());
}

TEST(OccluderJson, TheFirstVersionsVolumesStillLoad) {
  const auto parsed = parseOccluder(
      R"({"version":1,"representation":"volume","uri":"volumes/a%20b.vdb","contentHash":"0123456789abcdef0123456789abcdef","bytes":12,)"
      R"("bounds":{"min":[-1,-1,-1],"max":[1,1,1]},"influenceRadius":2.5,"lipschitz":1.5,"signMethod":"signed-crossings",)"
      R"("error":{"max":0.1,"rms":0.01,"signErrors":0,"samples":4096,"seed":1},"source":"a.off","settingsHash":"f"})",
      "x");
  ASSERT_TRUE(parsed.ok()) << message(parsed.error());
  EXPECT_EQ(parsed.value().uri, "volumes/a b.vdb");
  EXPECT_EQ(parsed.value().representation, Representation::volume);
  EXPECT_FALSE(parsed.value().primitive);
}

}  // namespace
}  // namespace overcast
