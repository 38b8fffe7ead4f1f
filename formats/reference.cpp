#include "formats/reference.h"

#include <algorithm>
#include <array>
#include <limits>
#include <system_error>

#include <fmt/format.h>

#include "formats/extension_json.h"
#include "formats/files.h"
#include "formats/json_fields.h"
#include "formats/packing.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "overcast-reference";
constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 24;
constexpr std::array kKinds{"view", "points"};

/// What a quantity is called, and its channels.
struct QuantityChannels {
  const char* name;
  std::vector<std::string> channels;
};

const std::vector<QuantityChannels>& allQuantities() {
  static const std::vector<QuantityChannels> kAll{{"sky", {"sky"}},
                                                  {"dome", {"dome"}},
                                                  {"ao", {"ao"}},
                                                  {"colour", {"R", "G", "B"}},
                                                  {"light", {"light.R", "light.G", "light.B"}},
                                                  {"bounce", {"bounce.R", "bounce.G", "bounce.B"}}};
  return kAll;
}

Json quantityJson(const ReferenceQuantity& quantity) {
  return {{"name", quantity.name},
          {"samples", quantity.samples},
          {"mean", quantity.mean},
          {"meanError", quantity.meanError},
          {"largestError", quantity.largestError}};
}

Json viewJson(const ReferenceInfo& info) {
  const glm::dmat4& m = info.view.worldFromView;
  return {{"name", info.camera},
          {"right", arrayOf(glm::dvec3(m[0]))},
          {"up", arrayOf(glm::dvec3(m[1]))},
          {"back", arrayOf(glm::dvec3(m[2]))},
          {"eye", arrayOf(glm::dvec3(m[3]))},
          {"verticalFieldOfView", info.view.verticalFieldOfView}};
}

void readView(Fields fields, ReferenceInfo& info) {
  fields.text("name", info.camera, false);
  constexpr std::array kColumns{"right", "up", "back", "eye"};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    glm::dvec3 column(0.0);
    fields.vector(kColumns[i], column, -kLargestNumber, kLargestNumber);
    info.view.worldFromView[static_cast<int>(i)] = glm::dvec4(column, i == 3 ? 1.0 : 0.0);
  }
  fields.number("verticalFieldOfView", info.view.verticalFieldOfView, kSmallestNumber, 3.2);
}

void readQuantity(Fields fields, ReferenceQuantity& quantity) {
  fields.text("name", quantity.name, false);
  const auto& all = allQuantities();
  if (std::none_of(all.begin(), all.end(), [&](const QuantityChannels& known) { return known.name == quantity.name; }))
    fields.fail("name", fmt::format("'{}' is not known", quantity.name));
  fields.integer("samples", quantity.samples, std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max());
  fields.number("mean", quantity.mean, -kLargestNumber, kLargestNumber);
  fields.number("meanError", quantity.meanError, 0.0, kLargestNumber);
  fields.number("largestError", quantity.largestError, 0.0, kLargestNumber);
}

void readScenePart(Fields& fields, ReferenceInfo& info) {
  fields.text("scene", info.scene, false);
  fields.text("sceneHash", info.sceneHash, false);
  fields.text("inputs", info.inputs, false);
  fields.integer("frame", info.frame, 0, std::numeric_limits<int>::max());
  fields.number("time", info.time, 0.0, kLargestNumber);
}

void readInfo(Fields& fields, ReferenceInfo& info) {
  std::string text;
  fields.text("format", text, false);
  if (text != kFormat) fields.fail("format", fmt::format("is '{}', not '{}'", text, kFormat));
  fields.version(kReferenceVersion);
  fields.text("kind", text, false);
  if (text != kKinds[0] && text != kKinds[1]) fields.fail("kind", fmt::format("'{}' is neither view nor points", text));
  info.kind = text == kKinds[1] ? ReferenceKind::points : ReferenceKind::view;
  readScenePart(fields, info);
  fields.text("picture", info.picture, false);
  if (fs::path(info.picture).filename() != fs::path(info.picture)) fields.fail("picture", "is not the name of a file in the same folder");
  fields.text("pictureHash", info.pictureHash, false);
  fields.integer("width", info.width, 1, kMaxImageSide);
  fields.integer("height", info.height, 1, kMaxImageSide);
  if (info.kind == ReferenceKind::view) readView(fields.child("camera"), info);
  if (info.kind == ReferenceKind::points) {
    const auto room = static_cast<std::uint64_t>(info.width) * static_cast<std::uint64_t>(info.height);
    fields.integer("points", info.points, std::uint64_t{0}, room);
    fields.vector("origin", info.origin, -kLargestNumber, kLargestNumber);
  }
  fields.number("distanceBound", info.distanceBound, 0.0, kLargestNumber);
  fields.number("targetError", info.targetError, 0.0, kLargestNumber);
  fields.integer("seed", info.seed, std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max());
  fields.number("seconds", info.seconds, 0.0, kLargestNumber);
  const std::size_t count = fields.arraySize("quantities");
  for (std::size_t i = 0; i < count; ++i) readQuantity(fields.element("quantities", i), info.quantities.emplace_back());
}

/// The first channel that a reference of this kind must have and `image` has not; empty when it has all.
std::string missingChannel(const ReferenceInfo& info, const Image& image) {
  std::vector<std::string> needed{"depth", "normal.X", "normal.Y", "normal.Z", "object"};
  if (info.kind == ReferenceKind::points) needed.insert(needed.end(), {"position.X", "position.Y", "position.Z"});
  for (const QuantityChannels& quantity : allQuantities()) {
    if (quantityNamed(info, quantity.name) == nullptr) continue;
    needed.insert(needed.end(), quantity.channels.begin(), quantity.channels.end());
    needed.push_back(std::string(quantity.name) + ".error");
  }
  const auto lacking =
      std::find_if(needed.begin(), needed.end(), [&](const std::string& channel) { return channelIndex(image, channel) < 0; });
  return lacking == needed.end() ? "" : *lacking;
}

template <class T>
std::span<const T> spanOf(const std::vector<T>& values) {
  return values;
}

std::string meshHash(const Scene& scene, const Mesh& mesh) {
  std::vector<std::byte> bytes;
  packAll(bytes, spanOf(mesh.positions));
  packAll(bytes, spanOf(mesh.normals));
  packAll(bytes, spanOf(mesh.triangles));
  for (const MeshPart& part : mesh.parts) {
    pack(bytes, part.firstTriangle);
    pack(bytes, part.material < 0 ? Material{}.baseColour : scene.materials[static_cast<std::size_t>(part.material)].baseColour);
  }
  return contentHash(bytes);
}

/// What lights the scene, without how it is estimated and shown.
std::string lightText(const Scene& scene) {
  Lighting lighting = scene.lighting.value_or(Lighting{});
  lighting.globalVolume = {};
  lighting.estimator = {};
  lighting.estimator.name = "published";  // the default when the first references were traced: they stay good
  lighting.exposure = Lighting{}.exposure;
  return lightingJson(lighting);
}

}  // namespace

const ReferenceQuantity* quantityNamed(const ReferenceInfo& info, std::string_view name) {
  const auto found =
      std::find_if(info.quantities.begin(), info.quantities.end(), [&](const ReferenceQuantity& q) { return q.name == name; });
  return found == info.quantities.end() ? nullptr : &*found;
}

std::string tracedHash(const Scene& scene, double time) {
  std::vector<std::string> meshes;
  for (const Mesh& mesh : scene.meshes) meshes.push_back(meshHash(scene, mesh));
  const std::vector<glm::dmat4> nodes = worldFromLocal(scene, time);
  std::vector<std::byte> bytes;
  packText(bytes, lightText(scene));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    pack(bytes, nodes[i]);
    const int mesh = scene.nodes[i].mesh;
    packText(bytes, mesh >= 0 ? meshes[static_cast<std::size_t>(mesh)] : "");
  }
  return contentHash(bytes);
}

std::string referenceJson(const ReferenceInfo& info) {
  Json json = {{"format", kFormat},
               {"version", kReferenceVersion},
               {"kind", kKinds[static_cast<std::size_t>(info.kind)]},
               {"scene", info.scene},
               {"sceneHash", info.sceneHash},
               {"inputs", info.inputs},
               {"picture", info.picture},
               {"pictureHash", info.pictureHash},
               {"frame", info.frame},
               {"time", info.time},
               {"width", info.width},
               {"height", info.height}};
  if (info.kind == ReferenceKind::view) {
    json["camera"] = viewJson(info);
  } else {
    json["points"] = info.points;
    json["origin"] = arrayOf(info.origin);
  }
  json["distanceBound"] = info.distanceBound;
  json["targetError"] = info.targetError;
  json["seed"] = info.seed;
  json["seconds"] = info.seconds;
  json["quantities"] = Json::array();
  for (const ReferenceQuantity& quantity : info.quantities) json["quantities"].push_back(quantityJson(quantity));
  return dumpJson(json, 2) + "\n";
}

Result<ReferenceInfo> parseReferenceInfo(std::string_view json, const std::string& place) {
  return parseObject<ReferenceInfo>(json, place, readInfo);
}

Result<ReferenceInfo> readReferenceInfo(const fs::path& json) {
  const auto bytes = readFile(json, kLargestFile);
  if (!bytes) return bytes.error();
  const auto text = std::string_view(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size());
  auto info = parseReferenceInfo(text, "");
  if (!info) return Error{json.string(), info.error().place, info.error().reason};
  return info;
}

Result<Done> writeReference(const fs::path& json, Reference& reference) {
  const std::string missing = missingChannel(reference.info, reference.image);
  OVERCAST_REQUIRE(missing.empty(), "a reference without the channel {}", missing);
  const fs::path picture = fs::path(json).replace_extension(".exr");
  if (const auto written = writeExr(picture, reference.image, ExrBits::single); !written) return written.error();
  const auto hash = fileHash(picture);
  if (!hash) return hash.error();
  reference.info.picture = picture.filename().string();
  reference.info.pictureHash = hash.value();
  return writeFileAtomically(json, std::string_view(referenceJson(reference.info)));
}

Result<Reference> readReference(const fs::path& json) {
  auto info = readReferenceInfo(json);
  if (!info) return info.error();
  const fs::path picture = json.parent_path() / info.value().picture;
  const auto hash = fileHash(picture);
  if (!hash) return hash.error();
  if (hash.value() != info.value().pictureHash)
    return Error{picture.string(), "", fmt::format("is not the picture that {} names: it was changed or not written whole", json.string())};
  auto image = readExr(picture);
  if (!image) return image.error();
  if (image.value().width != info.value().width || image.value().height != info.value().height)
    return Error{picture.string(), "",
                 fmt::format("has {}x{} pixels, {} says {}x{}", image.value().width, image.value().height, json.string(),
                             info.value().width, info.value().height)};
  const std::string missing = missingChannel(info.value(), image.value());
  if (!missing.empty()) return Error{picture.string(), "", fmt::format("has no channel {}", missing)};
  return Reference{std::move(info).value(), std::move(image).value()};
}

Result<std::vector<fs::path>> listReferences(const fs::path& folder) {
  std::error_code failed;
  std::vector<fs::path> found;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed))
    if (entry->path().extension() == ".json" && readReferenceInfo(entry->path())) found.push_back(entry->path());
  if (failed) return Error{folder.string(), "", failed.message()};
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace overcast
