#include "formats/extension_json.h"

#include <charconv>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>
#include <nlohmann/json.hpp>

#include "formats/json_fields.h"
#include "formats/uri.h"

namespace overcast {
namespace {

constexpr int kLargestTexCoord = 31;
constexpr std::uint32_t kMostApertureRays = 1u << 20;
constexpr const char* kSelfOccludes = "self";
constexpr const char* kSceneOccludes = "scene";
constexpr double kLargestFloat = 3.4e38;
constexpr double kMostOfEstimator = 1e3;  ///< of weights, spreads and powers
constexpr double kTinyFloat = std::numeric_limits<float>::min();

using overcast::arrayOf;  // of double vectors: hidden by the next line, which would round them
Json arrayOf(const glm::vec3& v) {
  return Json::array({shortest(v.x), shortest(v.y), shortest(v.z)});
}
Json boxJson(const Box& box) {
  return {{"min", arrayOf(box.min)}, {"max", arrayOf(box.max)}};
}

bool isContentHash(const std::string& text) {
  return text.empty() || (text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string::npos);
}

void readFileOf(Fields& fields, std::string& uri, std::string& contentHash) {
  std::string text;
  fields.text("uri", text, false);
  uri = pathFromUri(text);
  fields.text("contentHash", contentHash, true);
  if (!isContentHash(contentHash)) fields.fail("contentHash", "is not 32 lower-case hexadecimal digits");
}

void readPrimitive(Fields fields, Primitive& primitive) {
  std::string shape;
  fields.text("shape", shape, false);
  const bool ellipsoid = shape == name(PrimitiveShape::ellipsoid);
  if (!ellipsoid && shape != name(PrimitiveShape::cuboid)) fields.fail("shape", fmt::format("'{}' is neither cuboid nor ellipsoid", shape));
  primitive.shape = ellipsoid ? PrimitiveShape::ellipsoid : PrimitiveShape::cuboid;
  fields.vector("centre", primitive.centre, -kLargestHalfExtent, kLargestHalfExtent);
  fields.rotation("rotation", primitive.rotation);
  fields.vector("halfExtents", primitive.halfExtents, kSmallestHalfExtent, kLargestHalfExtent);
  if (!isWhole(primitive)) fields.fail("halfExtents", fmt::format("has a smallest below {:.6g} of its largest", kThinnestPrimitive));
}

void readMeasuredError(Fields fields, MeasuredError& error) {
  constexpr std::uint64_t largest = std::numeric_limits<std::uint64_t>::max();
  fields.number("max", error.max, 0.0, kLargestNumber);
  fields.number("rms", error.rms, 0.0, kLargestNumber);
  fields.integer("signErrors", error.signErrors, std::uint64_t{0}, largest);
  fields.integer("samples", error.samples, std::uint64_t{0}, largest);
  fields.integer("seed", error.seed, std::uint64_t{0}, largest);
  if (fields.has("p99")) fields.number("p99", error.p99, 0.0, kLargestNumber);
  if (fields.has("surfaceRms")) fields.number("surfaceRms", error.surfaceRms, 0.0, kLargestNumber);
  if (fields.has("skyRmse")) fields.number("skyRmse", error.skyRmse, 0.0, 1.0);
  if (fields.has("method")) fields.text("method", error.method, false);
}

void readInside(Fields& fields, Occluder& occluder) {
  std::string text;
  fields.text("inside", text, false);
  const auto inside = insideNamed(text);
  if (!inside) fields.fail("inside", fmt::format("'{}' is not known", text));
  occluder.inside = inside.value_or(Inside::unstated);
  if (fields.has("sheetThickness")) fields.number("sheetThickness", occluder.sheetThickness, kSmallestNumber, kLargestNumber);
}

void readOccluder(Fields& fields, Occluder& occluder) {
  fields.version(kOccluderVersion);
  std::string text;
  fields.text("representation", text, false);
  const auto representation = representationNamed(text);
  if (!representation) fields.fail("representation", fmt::format("'{}' is not known", text));
  occluder.representation = representation.value_or(occluder.representation);
  if (occluder.representation == Representation::primitive)
    readPrimitive(fields.child("primitive"), occluder.primitive.emplace());
  else
    readFileOf(fields, occluder.uri, occluder.contentHash);
  constexpr std::uint64_t largest = std::numeric_limits<std::uint64_t>::max();
  fields.integer("bytes", occluder.bytes, std::uint64_t{0}, largest);
  if (fields.has("bits")) fields.integer("bits", occluder.bits, 1, 32);
  fields.box("bounds", occluder.bounds);
  fields.number("influenceRadius", occluder.influenceRadius, 0.0, kLargestNumber);
  fields.number("lipschitz", occluder.lipschitz, kSmallestNumber, kLargestNumber);
  fields.text("signMethod", occluder.signMethod, true);
  if (fields.has("inside")) readInside(fields, occluder);
  readMeasuredError(fields.child("error"), occluder.error);
  fields.text("source", occluder.source, true);
  fields.text("settingsHash", occluder.settingsHash, true);
}

void readOccluders(Fields& fields, bool& sceneOccludes) {
  std::string occluders;
  fields.text("occluders", occluders, false);
  sceneOccludes = occluders == kSceneOccludes;
  if (!sceneOccludes && occluders != kSelfOccludes) fields.fail("occluders", fmt::format("'{}' is neither self nor scene", occluders));
}

void readAperture(Fields& fields, ApertureLink& link) {
  fields.version(kApertureLinkVersion);
  readFileOf(fields, link.uri, link.contentHash);
  fields.integer("bytes", link.bytes, std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max());
  if (fields.has("texCoord")) fields.integer("texCoord", link.texCoord, 0, kLargestTexCoord);
  if (fields.has("occluders")) readOccluders(fields, link.sceneOccludes);
  if (!fields.has("error")) return;
  Fields error = fields.child("error");
  error.number("radius", link.radiusError, 0.0, kLargestNumber);
  error.number("ambient", link.ambientError, 0.0, kLargestNumber);
  error.number("direction", link.directionError, 0.0, kLargestNumber);
}

void readApertureBake(Fields& fields, ApertureBake& bake) {
  constexpr std::uint64_t largest = std::numeric_limits<std::uint64_t>::max();
  fields.version(kApertureBakeVersion);
  fields.integer("rays", bake.rays, std::uint32_t{1}, kMostApertureRays);
  readOccluders(fields, bake.sceneOccludes);
  fields.flag("fitted", bake.fitted);
  fields.integer("samples", bake.samples, std::uint64_t{0}, largest);
  fields.integer("seed", bake.seed, std::uint64_t{0}, largest);
  Fields error = fields.child("error");
  error.number("radius", bake.radiusError, 0.0, kLargestNumber);
  error.number("ambient", bake.ambientError, 0.0, kLargestNumber);
  error.number("direction", bake.directionError, 0.0, kLargestNumber);
}

void readSun(Fields fields, Sun& sun) {
  fields.direction("direction", sun.direction);
  fields.vector("colour", sun.colour, 0.0, kLargestFloat);
  fields.number("angularRadius", sun.angularRadius, kTinyFloat, 1.5708);
}

void readAreaLight(Fields fields, AreaLight& light) {
  fields.vector("position", light.position, -kLargestFloat, kLargestFloat);
  fields.number("radius", light.radius, kTinyFloat, kLargestFloat);
  fields.vector("colour", light.colour, 0.0, kLargestFloat);
  if (fields.has("node")) fields.integer("node", light.node, 0, std::numeric_limits<int>::max());
}

void readCones(Fields fields, SkyCones& cones) {
  fields.integer("directions", cones.directions, 1, 64);
  fields.number("spread", cones.spread, 1e-3, kMostOfEstimator);
  fields.number("bias", cones.bias, 0.0, 1.0);
  fields.number("power", cones.power, 1e-3, kMostOfEstimator);
}

void readSteps(Fields& fields, Estimator& estimator) {
  const std::size_t count = fields.arraySize("steps");
  if (count == 0 || count > kMostSkySteps) return fields.fail("steps", fmt::format("are not 1 to {}", kMostSkySteps));
  for (std::size_t i = 0; i < count; ++i) {
    Fields field = fields.element("steps", i);
    SkyStep& step = estimator.steps.emplace_back();
    const auto taps = static_cast<std::size_t>(estimator.taps);
    field.numbers("weights", step.weights, taps, 0.0, kMostOfEstimator);
    field.numbers("gaps", step.gaps, taps - 1, 0.0, kMostOfEstimator);
    field.number("start", step.start, -kMostOfEstimator, kMostOfEstimator);
    field.number("slant", step.slant, -kMostOfEstimator, kMostOfEstimator);
    field.number("height", step.height, 0.0, kMostOfEstimator);
  }
}

void readEstimator(Fields fields, Estimator& estimator) {
  fields.text("name", estimator.name, false);
  fields.integer("taps", estimator.taps, 1, 8);
  fields.number("k", estimator.k, 0.0, kLargestFloat);
  fields.number("skyWeight", estimator.skyWeight, 0.0, 1.0);
  if (fields.has("weights"))
    return fields.fail("weights", "are of taps along one line, as no estimator takes them any more: take them and the steps out");
  if (fields.has("steps")) readSteps(fields, estimator);
  if (fields.has("cones")) readCones(fields.child("cones"), estimator.cones.emplace());
  if (fields.has("fitError")) fields.number("fitError", estimator.fitError, 0.0, kLargestNumber);
  if (fields.has("heldOutError")) fields.number("heldOutError", estimator.heldOutError, 0.0, kLargestNumber);
}

void readLighting(Fields& fields, Lighting& lighting) {
  fields.version(kLightingVersion);
  Fields sky = fields.child("sky");
  sky.vector("colour", lighting.skyColour, 0.0, kLargestFloat);
  sky.direction("up", lighting.up);
  std::string image;
  if (sky.has("image")) sky.text("image", image, false);
  lighting.skyImage = pathFromUri(image);
  if (fields.has("sun")) readSun(fields.child("sun"), lighting.sun.emplace());
  const std::size_t lights = fields.has("areaLights") ? fields.arraySize("areaLights") : 0;
  for (std::size_t i = 0; i < lights; ++i) readAreaLight(fields.element("areaLights", i), lighting.areaLights.emplace_back());
  Fields volume = fields.child("globalVolume");
  if (volume.has("bounds")) volume.box("bounds", lighting.globalVolume.bounds.emplace());
  volume.integer("resolution", lighting.globalVolume.resolution, 32, 256);
  if (lighting.globalVolume.resolution % 8 != 0) volume.fail("resolution", "is not a multiple of 8");
  readEstimator(fields.child("estimator"), lighting.estimator);
  fields.number("exposure", lighting.exposure, kTinyFloat, kLargestFloat);
}

Json primitiveJson(const Primitive& primitive) {
  const glm::dquat& q = primitive.rotation;
  return {{"shape", name(primitive.shape)},
          {"centre", arrayOf(primitive.centre)},
          {"rotation", Json::array({q.x, q.y, q.z, q.w})},
          {"halfExtents", arrayOf(primitive.halfExtents)}};
}

Json measuredErrorJson(const MeasuredError& error) {
  Json json = {{"max", error.max}, {"rms", error.rms}, {"signErrors", error.signErrors}, {"samples", error.samples}, {"seed", error.seed}};
  if (error.p99 >= 0.0) json["p99"] = error.p99;
  if (error.surfaceRms >= 0.0) json["surfaceRms"] = error.surfaceRms;
  if (error.skyRmse >= 0.0) json["skyRmse"] = error.skyRmse;
  if (!error.method.empty()) json["method"] = error.method;
  return json;
}

}  // namespace

double shortest(float value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
  double wide = 0.0;
  std::from_chars(text, end, wide);
  return static_cast<float>(wide) == value ? wide : static_cast<double>(value);
}

std::string occluderJson(const Occluder& occluder) {
  OVERCAST_REQUIRE(occluder.primitive.has_value() == (occluder.representation == Representation::primitive),
                   "a {} {} numbers of a primitive", name(occluder.representation), occluder.primitive ? "with" : "without");
  Json json = {{"version", kOccluderVersion}, {"representation", name(occluder.representation)}};
  if (occluder.primitive) {
    json["primitive"] = primitiveJson(*occluder.primitive);
  } else {
    json["uri"] = uriFromPath(occluder.uri);
    json["contentHash"] = occluder.contentHash;
  }
  json["bytes"] = occluder.bytes;
  if (occluder.bits > 0) json["bits"] = occluder.bits;
  json["bounds"] = boxJson(occluder.bounds);
  json["influenceRadius"] = occluder.influenceRadius;
  json["lipschitz"] = occluder.lipschitz;
  json["signMethod"] = occluder.signMethod;
  if (occluder.inside != Inside::unstated) json["inside"] = name(occluder.inside);
  if (occluder.sheetThickness > 0.0) json["sheetThickness"] = occluder.sheetThickness;
  json["error"] = measuredErrorJson(occluder.error);
  json["source"] = occluder.source;
  json["settingsHash"] = occluder.settingsHash;
  return dumpJson(json);
}

std::string lightingJson(const Lighting& lighting) {
  Json json = {{"version", kLightingVersion}, {"sky", {{"colour", arrayOf(lighting.skyColour)}, {"up", arrayOf(lighting.up)}}}};
  if (!lighting.skyImage.empty()) json["sky"]["image"] = uriFromPath(lighting.skyImage);
  if (lighting.sun) {
    json["sun"] = {{"direction", arrayOf(lighting.sun->direction)},
                   {"colour", arrayOf(lighting.sun->colour)},
                   {"angularRadius", shortest(lighting.sun->angularRadius)}};
  }
  for (const AreaLight& light : lighting.areaLights) {
    json["areaLights"].push_back(
        {{"position", arrayOf(light.position)}, {"radius", shortest(light.radius)}, {"colour", arrayOf(light.colour)}});
    if (light.node >= 0) json["areaLights"].back()["node"] = light.node;
  }
  json["globalVolume"] = Json::object();
  if (lighting.globalVolume.bounds) json["globalVolume"]["bounds"] = boxJson(*lighting.globalVolume.bounds);
  json["globalVolume"]["resolution"] = lighting.globalVolume.resolution;
  const Estimator& estimator = lighting.estimator;
  json["estimator"] = {
      {"name", estimator.name}, {"taps", estimator.taps}, {"k", shortest(estimator.k)}, {"skyWeight", shortest(estimator.skyWeight)}};
  for (const SkyStep& step : estimator.steps) {
    Json weights = Json::array(), gaps = Json::array();
    for (const float weight : step.weights) weights.push_back(shortest(weight));
    for (const float gap : step.gaps) gaps.push_back(shortest(gap));
    json["estimator"]["steps"].push_back({{"weights", std::move(weights)},
                                          {"gaps", std::move(gaps)},
                                          {"start", shortest(step.start)},
                                          {"slant", shortest(step.slant)},
                                          {"height", shortest(step.height)}});
  }
  if (const std::optional<SkyCones>& cones = estimator.cones)
    json["estimator"]["cones"] = {{"directions", cones->directions},
                                  {"spread", shortest(cones->spread)},
                                  {"bias", shortest(cones->bias)},
                                  {"power", shortest(cones->power)}};
  if (estimator.fitError >= 0.0) json["estimator"]["fitError"] = estimator.fitError;
  if (estimator.heldOutError >= 0.0) json["estimator"]["heldOutError"] = estimator.heldOutError;
  json["exposure"] = shortest(lighting.exposure);
  return dumpJson(json);
}

std::string apertureJson(const ApertureLink& link) {
  Json json = {{"version", kApertureLinkVersion}, {"uri", uriFromPath(link.uri)},
               {"contentHash", link.contentHash}, {"bytes", link.bytes},
               {"texCoord", link.texCoord},       {"occluders", link.sceneOccludes ? kSceneOccludes : kSelfOccludes}};
  if (link.radiusError >= 0.0)
    json["error"] = {{"radius", link.radiusError}, {"ambient", link.ambientError}, {"direction", link.directionError}};
  return dumpJson(json);
}

std::string apertureBakeJson(const ApertureBake& bake) {
  return dumpJson({{"version", kApertureBakeVersion},
                   {"rays", bake.rays},
                   {"occluders", bake.sceneOccludes ? kSceneOccludes : kSelfOccludes},
                   {"fitted", bake.fitted},
                   {"samples", bake.samples},
                   {"seed", bake.seed},
                   {"error", {{"radius", bake.radiusError}, {"ambient", bake.ambientError}, {"direction", bake.directionError}}}});
}

Result<Occluder> parseOccluder(std::string_view json, const std::string& place) {
  return parseObject<Occluder>(json, place, readOccluder);
}

Result<Lighting> parseLighting(std::string_view json, const std::string& place) {
  return parseObject<Lighting>(json, place, readLighting);
}

Result<ApertureLink> parseAperture(std::string_view json, const std::string& place) {
  return parseObject<ApertureLink>(json, place, readAperture);
}

Result<ApertureBake> parseApertureBake(std::string_view json, const std::string& place) {
  return parseObject<ApertureBake>(json, place, readApertureBake);
}

}  // namespace overcast
