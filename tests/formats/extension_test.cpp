// The JSON of OVERCAST_occluder and OVERCAST_lighting, and the schemas that describe it.
#include "formats/extension_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <nlohmann/json.hpp>

#include "tests/formats/json_schema.h"
#include "tests/formats/random_scene.h"

namespace overcast {
namespace {

using Json = nlohmann::ordered_json;
using test::schema;
using test::violation;
using testing::HasSubstr;

/// All objects inside `json`, as pointers.
void objects(const Json& json, const std::string& at, std::vector<std::string>& found) {
  if (json.is_object()) found.push_back(at);
  if (!json.is_structured()) return;
  for (const auto& [key, value] : json.items()) objects(value, at + "/" + key, found);
}

Json parsed(const std::string& text) {
  return Json::parse(text);
}

template <class Parse>
std::string errorOf(Parse parse, const Json& json) {
  auto result = parse(json.dump(), "x");
  return result ? "" : result.error().place + ": " + result.error().reason;
}

TEST(Extension, ReadsBackBitForBit) {
  EXPECT_TRUE(rc::check("occluder", [](std::uint64_t seed) {
    const Occluder made = test::randomOccluder(seed);
    auto read = parseOccluder(occluderJson(made), "x");
    RC_ASSERT(read.ok());
    const Occluder& again = read.value();
    RC_ASSERT(again.representation == made.representation && again.primitive.has_value() == made.primitive.has_value());
    if (made.primitive) {
      const Primitive &a = *again.primitive, &m = *made.primitive;
      RC_ASSERT(a.shape == m.shape && a.centre == m.centre && a.rotation == m.rotation && a.halfExtents == m.halfExtents);
    }
    RC_ASSERT(again.uri == made.uri && again.contentHash == made.contentHash && again.bytes == made.bytes);
    RC_ASSERT(again.bits == made.bits);
    RC_ASSERT(again.inside == made.inside && again.sheetThickness == made.sheetThickness);
    RC_ASSERT(again.bounds.min == made.bounds.min && again.bounds.max == made.bounds.max);
    RC_ASSERT(again.influenceRadius == made.influenceRadius && again.lipschitz == made.lipschitz && again.signMethod == made.signMethod);
    RC_ASSERT(again.error.max == made.error.max && again.error.rms == made.error.rms && again.error.seed == made.error.seed);
    RC_ASSERT(again.error.signErrors == made.error.signErrors && again.error.samples == made.error.samples);
    RC_ASSERT(again.error.p99 == made.error.p99 && again.error.surfaceRms == made.error.surfaceRms);
    RC_ASSERT(again.error.skyRmse == made.error.skyRmse && again.error.method == made.error.method);
    RC_ASSERT(again.source == made.source && again.settingsHash == made.settingsHash);
  }));
  EXPECT_TRUE(rc::check("aperture", [](std::uint64_t seed) {
    const ApertureLink made = test::randomApertureLink(seed);
    const auto read = parseAperture(apertureJson(made), "x");
    RC_ASSERT(read.ok());
    const ApertureLink& again = read.value();
    RC_ASSERT(again.uri == made.uri && again.contentHash == made.contentHash && again.bytes == made.bytes);
    RC_ASSERT(again.texCoord == made.texCoord && again.sceneOccludes == made.sceneOccludes && again.radiusError == made.radiusError);
    RC_ASSERT(again.ambientError == made.ambientError && again.directionError == made.directionError);
  }));
  EXPECT_TRUE(rc::check("aperture bake", [](std::uint64_t seed) {
    const ApertureBake made = test::randomApertureBake(seed);
    const auto read = parseApertureBake(apertureBakeJson(made), "x");
    RC_ASSERT(read.ok());
    const ApertureBake& again = read.value();
    RC_ASSERT(again.rays == made.rays && again.sceneOccludes == made.sceneOccludes && again.fitted == made.fitted);
    RC_ASSERT(again.samples == made.samples && again.seed == made.seed && again.radiusError == made.radiusError);
    RC_ASSERT(again.ambientError == made.ambientError && again.directionError == made.directionError);
  }));
  EXPECT_TRUE(rc::check("lighting", [](std::uint64_t seed) {
    const Lighting made = test::randomLighting(seed);
    auto read = parseLighting(lightingJson(made), "x");
    RC_ASSERT(read.ok());
    const Lighting& again = read.value();
    RC_ASSERT(again.skyColour == made.skyColour && again.skyImage == made.skyImage && again.up == made.up &&
              again.exposure == made.exposure);
    RC_ASSERT(again.sun.has_value() == made.sun.has_value());
    if (made.sun) RC_ASSERT(again.sun->direction == made.sun->direction && again.sun->angularRadius == made.sun->angularRadius);
    if (made.sun) RC_ASSERT(again.sun->colour == made.sun->colour);
    RC_ASSERT(again.areaLights.size() == made.areaLights.size());
    for (std::size_t i = 0; i < made.areaLights.size(); ++i) {
      RC_ASSERT(again.areaLights[i].position == made.areaLights[i].position && again.areaLights[i].radius == made.areaLights[i].radius);
      RC_ASSERT(again.areaLights[i].colour == made.areaLights[i].colour && again.areaLights[i].node == made.areaLights[i].node);
    }
    RC_ASSERT(again.globalVolume.bounds.has_value() == made.globalVolume.bounds.has_value());
    if (made.globalVolume.bounds) RC_ASSERT(again.globalVolume.bounds->min == made.globalVolume.bounds->min);
    RC_ASSERT(again.globalVolume.resolution == made.globalVolume.resolution);
    RC_ASSERT(again.estimator.name == made.estimator.name && again.estimator.taps == made.estimator.taps);
    RC_ASSERT(again.estimator.k == made.estimator.k && again.estimator.skyWeight == made.estimator.skyWeight);
    RC_ASSERT(again.estimator.fitError == made.estimator.fitError);
    RC_ASSERT(again.estimator.heldOutError == made.estimator.heldOutError);
    RC_ASSERT(again.estimator.steps.size() == made.estimator.steps.size());
    for (std::size_t i = 0; i < made.estimator.steps.size(); ++i) {
      const SkyStep &is = again.estimator.steps[i], &was = made.estimator.steps[i];
      RC_ASSERT(is.weights == was.weights && is.gaps == was.gaps && is.start == was.start);
      RC_ASSERT(is.slant == was.slant && is.height == was.height);
    }
    RC_ASSERT(again.estimator.cones.has_value() == made.estimator.cones.has_value());
    if (made.estimator.cones) {
      RC_ASSERT(again.estimator.cones->directions == made.estimator.cones->directions);
      RC_ASSERT(again.estimator.cones->spread == made.estimator.cones->spread && again.estimator.cones->bias == made.estimator.cones->bias);
      RC_ASSERT(again.estimator.cones->power == made.estimator.cones->power);
    }
  }));
}

// What version 1 wrote before these figures existed.
TEST(Extension, AssetsWithoutTheLaterErrorFiguresLoad) {
  Json json = parsed(occluderJson(test::randomOccluder(0)));
  for (const char* key : {"p99", "surfaceRms", "skyRmse", "method"}) json["error"].erase(key);
  const auto read = parseOccluder(json.dump(), "x");
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read.value().error.max, json["error"]["max"]);
  EXPECT_LT(read.value().error.p99, 0.0);
  EXPECT_LT(read.value().error.surfaceRms, 0.0);
  EXPECT_LT(read.value().error.skyRmse, 0.0);
  EXPECT_EQ(read.value().error.method, "");
}

TEST(Extension, FloatsAreShort) {
  Lighting lighting;
  lighting.estimator.k = 0.05f;
  lighting.skyColour = {0.8f, 0.9f, 1.0f};
  EXPECT_THAT(lightingJson(lighting), HasSubstr("\"k\":0.05,"));
  EXPECT_THAT(lightingJson(lighting), HasSubstr("[0.8,0.9,1.0]"));
}

TEST(Extension, WhatIsWrittenFollowsTheSchema) {
  const Json occluder = schema("OVERCAST_occluder");
  const Json lighting = schema("OVERCAST_lighting");
  const Json aperture = schema("OVERCAST_aperture");
  const Json apertureBake = schema("OVERCAST_aperture_bake");
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    EXPECT_EQ(violation(occluder, parsed(occluderJson(test::randomOccluder(seed))), occluder), "");
    EXPECT_EQ(violation(lighting, parsed(lightingJson(test::randomLighting(seed))), lighting), "");
    EXPECT_EQ(violation(aperture, parsed(apertureJson(test::randomApertureLink(seed))), aperture), "");
    EXPECT_EQ(violation(apertureBake, parsed(apertureBakeJson(test::randomApertureBake(seed))), apertureBake), "");
  }
}

/// Takes every member away in turn, and puts a value of a wrong type or range in its place: schema and parser must agree each time.
template <class Parse>
void expectAgreement(const Json& schema, const Json& whole, Parse parse) {
  std::vector<std::string> places;
  objects(whole, "", places);
  const std::vector<Json> wrong = {nullptr, "text",        "",     -1,        0,          1e300,     -1e300,        0.5, 7, 100,
                                   4096,    Json::array(), {1, 2}, {9, 9, 9}, {-1, 0, 0}, {1, 0, 0}, Json::object()};
  for (const std::string& place : places) {
    const Json::json_pointer pointer(place);
    for (const auto& [key, value] : whole.at(pointer).items()) {
      Json changed = whole;
      changed.at(pointer).erase(key);
      EXPECT_EQ(errorOf(parse, changed).empty(), violation(schema, changed, schema).empty()) << place << "/" << key << " missing";
      for (const Json& other : wrong) {
        changed = whole;
        changed.at(pointer)[key] = other;
        const std::string error = errorOf(parse, changed);
        const std::string broken = violation(schema, changed, schema);
        if (!broken.empty()) {
          EXPECT_THAT(error, HasSubstr("x" + place + "/" + key)) << other << " breaks the schema: " << broken;
        }
      }
    }
  }
}

TEST(Extension, TheParserRefusesWhatTheSchemaRefusesAndNamesTheField) {
  Lighting lighting = test::randomLighting(3);
  lighting.sun = Sun{};
  lighting.skyImage = "sky.exr";
  lighting.globalVolume.bounds = Box{glm::dvec3(-1), glm::dvec3(1)};
  lighting.areaLights = {AreaLight{}};
  lighting.areaLights[0].node = 2;
  lighting.estimator.fitError = lighting.estimator.heldOutError = 0.25;
  lighting.estimator.taps = 3;
  lighting.estimator.steps = {{{0.25f, 1.0f, 0.0f}, {0.5f, 0.0f}, -1.0f, 0.5f, 2.0f}};
  expectAgreement(schema("OVERCAST_lighting"), parsed(lightingJson(lighting)), parseLighting);
  // Among these are occluders of all representations.
  for (std::uint64_t seed = 0; seed < 12; ++seed)
    expectAgreement(schema("OVERCAST_occluder"), parsed(occluderJson(test::randomOccluder(seed))), parseOccluder);
  for (std::uint64_t seed = 0; seed < 4; ++seed)
    expectAgreement(schema("OVERCAST_aperture"), parsed(apertureJson(test::randomApertureLink(seed))), parseAperture);
  expectAgreement(schema("OVERCAST_aperture_bake"), parsed(apertureBakeJson(test::randomApertureBake(1))), parseApertureBake);
}

TEST(Extension, WeightsOfAnOlderEstimatorAreRefused) {
  Json lighting = parsed(lightingJson(test::randomLighting(1)));
  lighting["estimator"]["weights"] = {0.5, 1.0, 0.0, 2.0};
  EXPECT_THAT(errorOf(parseLighting, lighting), HasSubstr("x/estimator/weights: are of taps along one line"));
}

TEST(Extension, TheParserRefusesWhatASchemaCannotSay) {
  Json occluder = parsed(occluderJson(test::randomOccluder(1)));
  occluder["bounds"] = {{"min", {0, 0, 2}}, {"max", {1, 1, 1}}};
  EXPECT_EQ(errorOf(parseOccluder, occluder), "x/bounds/min: 2 is above max 1");
  occluder = parsed(occluderJson(test::randomOccluder(1)));
  occluder["contentHash"] = "0123";
  EXPECT_THAT(errorOf(parseOccluder, occluder), HasSubstr("x/contentHash: is not 32"));
  Json lighting = parsed(lightingJson(Lighting{}));
  lighting["sky"]["up"] = {0, 0.5, 0};
  EXPECT_THAT(errorOf(parseLighting, lighting), HasSubstr("x/sky/up: is not a unit vector"));
  EXPECT_THAT(parseLighting("no JSON", "x").error().place, "x");
}

TEST(Extension, NewerVersionsAreRefusedAndUnknownFieldsIgnored) {
  Json occluder = parsed(occluderJson(test::randomOccluder(1)));
  occluder["later"] = 1;
  EXPECT_EQ(errorOf(parseOccluder, occluder), "");
  occluder["version"] = kOccluderVersion + 1;
  EXPECT_THAT(errorOf(parseOccluder, occluder), HasSubstr("x/version: 2 is newer than 1"));
}

}  // namespace
}  // namespace overcast
