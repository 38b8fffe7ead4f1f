#include "formats/scene_lighting.h"

#include "formats/extension_json.h"
#include "formats/files.h"
#include "formats/json_fields.h"

namespace overcast {
namespace {

constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 30;
constexpr const char* kExtension = "OVERCAST_lighting";

/// The extension's place in the document, or null.
Json* lightingIn(Json& document) {
  if (!document.is_object() || !document.contains("scenes")) return nullptr;
  Json& scenes = document["scenes"];
  const Json index = document.value("scene", Json(0u));
  if (!scenes.is_array() || !index.is_number_unsigned() || index.get<std::size_t>() >= scenes.size()) return nullptr;
  Json& scene = scenes[index.get<std::size_t>()];
  if (!scene.is_object() || !scene.contains("extensions") || !scene["extensions"].is_object()) return nullptr;
  return scene["extensions"].contains(kExtension) ? &scene["extensions"][kExtension] : nullptr;
}

}  // namespace

Result<Done> replaceLighting(const std::filesystem::path& path, const Lighting& lighting) {
  if (path.extension() != ".gltf") return Error{path.string(), "", "settings are written into .gltf scenes only"};
  const auto bytes = readFile(path, kLargestFile);
  if (!bytes) return bytes.error();
  const auto* text = reinterpret_cast<const char*>(bytes.value().data());
  Json document = Json::parse(text, text + bytes.value().size(), nullptr, false);
  Json* place = lightingIn(document);
  if (place == nullptr) return Error{path.string(), "", fmt::format("has no extension {} to change", kExtension)};
  *place = Json::parse(lightingJson(lighting));
  return writeFileAtomically(path, dumpJson(document, 1) + "\n");
}

}  // namespace overcast
