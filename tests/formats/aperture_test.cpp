// Apertures: the codes against the accuracy they promise, and what the glTF reader does with attributes that are not ours.
#include "formats/aperture.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <glm/geometric.hpp>

#include "formats/scene.h"
#include "formats/shared/aperture.h"
#include "tests/formats/gltf_builder.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using test::GltfBuilder;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;

/// Evenly spread directions (spherical Fibonacci).
glm::dvec3 direction(int i, int count) {
  const double z = 1.0 - (2.0 * i + 1.0) / count;
  const double turn = 2.399963229728653 * i;
  return {std::sqrt(1.0 - z * z) * std::cos(turn), std::sqrt(1.0 - z * z) * std::sin(turn), z};
}

double angle(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// Root mean square and largest angle between directions and their codes, radians.
template <class Coded>
std::pair<double, double> directionError(const Coded& coded) {
  double sum = 0.0, most = 0.0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const glm::dvec3 d = direction(i, kCount);
    const double off = angle(d, glm::dvec3(coded(Aperture{glm::vec3(d), 1.0f}).direction));
    sum += off * off;
    most = std::max(most, off);
  }
  return {std::sqrt(sum / kCount), most};
}

TEST(Aperture, DirectionsAreAsNearAsTheirBitsAllow) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const auto narrow = directionError([](const Aperture& a) { return unpackAperture32(packAperture32(a)); });
  EXPECT_LT(narrow.first, 0.046 * kDegree);  // MEASURED 3
  EXPECT_LT(narrow.second, 0.1 * kDegree);
  const auto wide = directionError([](const Aperture& a) { return unpackAperture64(packAperture64(a, 0.5f)); });
  EXPECT_LT(wide.first, 0.046 / 32 * kDegree + 1e-7);
  EXPECT_LT(wide.second, 0.004 * kDegree);
}

TEST(Aperture, AxesAndTheEndsOfTheRadiusAreExact) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0f, 1.0f}) {
      Aperture aperture;
      aperture.direction = glm::vec3(0.0f);
      aperture.direction[axis] = sign;
      for (const float radius : {0.0f, capRadius(1.0)}) {
        aperture.radius = radius;
        const Aperture narrow = unpackAperture32(packAperture32(aperture));
        const Aperture wide = unpackAperture64(packAperture64(aperture, 1.0f));
        EXPECT_EQ(narrow.direction, aperture.direction);
        EXPECT_EQ(wide.direction, aperture.direction);
        EXPECT_EQ(narrow.radius, radius);
        EXPECT_EQ(wide.radius, radius);
      }
    }
  }
  EXPECT_FLOAT_EQ(capRadius(1.0), static_cast<float>(std::numbers::pi / 2));
}

TEST(Aperture, RadiusAndAmbientAreRoundedToNearest) {
  for (int i = 0; i <= 5000; ++i) {
    const float share = static_cast<float>(i) / 5000.0f;
    const Aperture aperture{{0.0f, 0.0f, 1.0f}, share * capRadius(1.0)};
    EXPECT_NEAR(unpackAperture32(packAperture32(aperture)).radius, aperture.radius, 0.5 * 1.5708 / 1023 + 1e-7);
    const std::uint64_t code = packAperture64(aperture, share);
    EXPECT_NEAR(unpackAperture64(code).radius, aperture.radius, 0.5 * 1.5708 / 65535 + 2e-7);
    EXPECT_NEAR(unpackAmbient64(code), share, 0.5 / 65535 + 1e-7);
  }
}

bool near(const Aperture& a, const Aperture& b) {
  return angle(glm::dvec3(a.direction), glm::dvec3(b.direction)) < 1e-6 && a.radius == b.radius;
}

RC_GTEST_PROP(Aperture, EveryCodeDecodesToAnApertureThatPacksToOneCodeForGood, (std::uint32_t low, std::uint32_t high)) {
  const Aperture narrow = unpackAperture32(low);
  RC_ASSERT(std::abs(glm::length(narrow.direction) - 1.0f) < 1e-6f);
  RC_ASSERT(narrow.radius >= 0.0f && narrow.radius <= capRadius(1.0));
  const std::uint32_t packed32 = packAperture32(narrow);
  RC_ASSERT(near(unpackAperture32(packed32), narrow));
  RC_ASSERT(packAperture32(unpackAperture32(packed32)) == packed32);
  const std::uint64_t code = low | static_cast<std::uint64_t>(high) << 32;
  const Aperture wide = unpackAperture64(code);
  const std::uint64_t packed64 = packAperture64(wide, unpackAmbient64(code));
  RC_ASSERT(near(unpackAperture64(packed64), wide));
  RC_ASSERT(packAperture64(unpackAperture64(packed64), unpackAmbient64(packed64)) == packed64);
  RC_ASSERT(unpackAmbient64(packed64) == unpackAmbient64(code));
}

TEST(Aperture, CodesOnTheBorderOfTheMapStayWhatTheyAre) {
  for (std::uint64_t i = 0; i <= 65534; i += 13) {
    const std::uint64_t codes[] = {i, i | 65534u << 16, i << 16, 65534u | i << 16};
    for (const std::uint64_t code : codes) {
      const std::uint64_t packed = packAperture64(unpackAperture64(code), 0.0f);
      ASSERT_EQ(packAperture64(unpackAperture64(packed), 0.0f), packed) << code;
      ASSERT_TRUE(near(unpackAperture64(packed), unpackAperture64(code))) << code;
    }
  }
}

TEST(Aperture, TheCapIsAsLargeAsWhatIsVisible) {
  for (const double visible : {1e-8, 1e-4, 0.1, 0.5, 0.9, 1.0}) {
    const double radius = static_cast<double>(capRadius(visible));
    EXPECT_NEAR(2.0 * std::pow(std::sin(radius / 2.0), 2.0) / visible, 1.0, 1e-6);  // area / 2 pi, without the cancellation of 1 - cos
  }
  EXPECT_EQ(capRadius(0.0), 0.0f);
  EXPECT_EQ(capRadius(-1.0), 0.0f);
  EXPECT_EQ(capRadius(2.0), capRadius(1.0));
}

TEST(Aperture, WhatCannotBelongToAMeshIsNamed) {
  VertexVisibility visibility;
  visibility.apertures = {{{0, 0, 1}, 0.5f}, {{0, 1, 0}, 0.0f}};
  EXPECT_EQ(brokenVisibility(visibility, 2), "");
  EXPECT_THAT(brokenVisibility(visibility, 3), HasSubstr("another number"));
  visibility.bits = ApertureBits::packed64;
  EXPECT_THAT(brokenVisibility(visibility, 2), HasSubstr("without ambient"));
  visibility.ambient = {0.5f, 1.5f};
  EXPECT_THAT(brokenVisibility(visibility, 2), HasSubstr("ambient"));
  visibility.ambient[1] = 1.0f;
  EXPECT_EQ(brokenVisibility(visibility, 2), "");
  visibility.apertures[0].radius = 1.6f;
  EXPECT_THAT(brokenVisibility(visibility, 2), HasSubstr("out of range"));
  visibility.apertures[0].radius = std::nanf("");
  EXPECT_THAT(brokenVisibility(visibility, 2), HasSubstr("out of range"));
  visibility.apertures[0] = {{0, 0, 2}, 0.5f};
  EXPECT_THAT(brokenVisibility(visibility, 2), HasSubstr("out of range"));
}

/// The triangle with normals and an accessor of the given kind as _APERTURE.
template <class T>
GltfBuilder withAttribute(const std::vector<T>& values, int componentType, const char* type, bool normalized = false) {
  GltfBuilder builder = GltfBuilder::triangle();
  const int normal = builder.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
  const int view = builder.view(values);
  const int aperture =
      builder.accessor({{"bufferView", view}, {"componentType", componentType}, {"count", 3}, {"type", type}, {"normalized", normalized}});
  builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normal;
  builder.json["meshes"][0]["primitives"][0]["attributes"]["_APERTURE"] = aperture;
  return builder;
}

const std::vector<std::uint8_t> kBytes = {1, 2, 3, 255, 4, 5, 6, 7, 0, 0, 0, 0};

TEST(Aperture, AttributesReadBackAsTheirCodesSay) {
  const TemporaryFolder folder;
  const auto read = readScene(withAttribute(kBytes, 5121, "VEC4").gltf(folder.path));
  ASSERT_TRUE(read) << message(read.error());
  ASSERT_TRUE(read.value().meshes[0].visibility);
  const VertexVisibility& visibility = *read.value().meshes[0].visibility;
  ASSERT_EQ(visibility.apertures.size(), 3u);
  EXPECT_TRUE(visibility.ambient.empty());
  EXPECT_EQ(visibility.apertures[0].direction, unpackAperture32(0xff030201u).direction);
  EXPECT_EQ(visibility.apertures[1].radius, unpackAperture32(0x07060504u).radius);
  EXPECT_EQ(visibility.apertures[2].radius, 0.0f);
}

TEST(Aperture, ForeignAttributesOfThatNameAreLeftOutWithANote) {
  const TemporaryFolder folder;
  const std::vector<float> floats(12, 0.5f);
  const GltfBuilder foreign[] = {withAttribute(floats, 5126, "VEC4"), withAttribute(kBytes, 5121, "VEC4", true),
                                 withAttribute(kBytes, 5120, "VEC4"), withAttribute(floats, 5126, "VEC3")};
  for (const GltfBuilder& builder : foreign) {
    const auto read = readScene(builder.gltf(folder.path));
    ASSERT_TRUE(read) << message(read.error());
    EXPECT_FALSE(read.value().meshes[0].visibility);
    EXPECT_THAT(read.value().notes, ElementsAre(HasSubstr("_APERTURE")));
  }
}

TEST(Aperture, VisibilityWithoutNormalsOrOnOnePrimitiveOnlyIsLeftOutWithANote) {
  const TemporaryFolder folder;
  GltfBuilder bare = withAttribute(kBytes, 5121, "VEC4");
  bare.json["meshes"][0]["primitives"][0]["attributes"].erase("NORMAL");
  GltfBuilder partial = withAttribute(kBytes, 5121, "VEC4");
  nlohmann::ordered_json second = partial.json["meshes"][0]["primitives"][0];
  second["attributes"].erase("_APERTURE");
  partial.json["meshes"][0]["primitives"].push_back(second);
  for (const GltfBuilder& builder : {bare, partial}) {
    const auto read = readScene(builder.gltf(folder.path));
    ASSERT_TRUE(read) << message(read.error());
    EXPECT_FALSE(read.value().meshes[0].visibility);
    EXPECT_THAT(read.value().notes, ElementsAre(HasSubstr("visibility")));
  }
}

TEST(Aperture, AnAttributeOfAnotherLengthIsAnError) {
  const TemporaryFolder folder;
  GltfBuilder builder = withAttribute(kBytes, 5121, "VEC4");
  builder.json["accessors"].back()["count"] = 2;
  const auto read = readScene(builder.gltf(folder.path));
  ASSERT_FALSE(read);
  EXPECT_THAT(message(read.error()), HasSubstr("_APERTURE"));
}

}  // namespace
}  // namespace overcast
