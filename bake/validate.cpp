#include "bake/validate.h"

#include <cmath>
#include <map>

#include <glm/geometric.hpp>

#include "formats/aperture_map.h"
#include "formats/asset.h"
#include "formats/extension_json.h"
#include "formats/files.h"
#include "formats/scene.h"
#include "formats/sky.h"
#include "formats/uri.h"
#include "formats/volume.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

/// Differences within what a double loses on the way through JSON and VDB metadata.
bool agree(const Box& a, const Box& b) {
  const double tolerance = 1e-9 * (diagonal(a) + glm::length(a.min) + glm::length(a.max));
  return glm::distance(a.min, b.min) <= tolerance && glm::distance(a.max, b.max) <= tolerance;
}

bool contains(const Box& outer, const Box& inner) {
  const double slack = 1e-6 * (diagonal(outer) + glm::length(outer.min) + glm::length(outer.max));  // positions are single floats on disk
  for (int axis = 0; axis < 3; ++axis)
    if (inner.min[axis] < outer.min[axis] - slack || inner.max[axis] > outer.max[axis] + slack) return false;
  return true;
}

/// What can be said of the numbers alone.
std::vector<std::string> checkNumbers(const Occluder& occluder, const Box& mesh) {
  std::vector<std::string> findings;
  const MeasuredError& error = occluder.error;
  if (!std::isfinite(error.max) || !std::isfinite(error.rms) || error.rms < 0.0 || error.max < error.rms * (1.0 - 1e-12))
    findings.push_back(fmt::format("measured error of max {} and rms {} makes no sense", error.max, error.rms));
  if (error.signErrors > error.samples) findings.push_back(fmt::format("{} sign errors at {} points", error.signErrors, error.samples));
  if (!std::isfinite(occluder.influenceRadius) || occluder.influenceRadius < 0.0)
    findings.push_back(fmt::format("influence radius is {}", occluder.influenceRadius));
  // A primitive is defined everywhere and may well be the smaller of the two.
  if (!occluder.primitive && !contains(occluder.bounds, mesh)) findings.push_back("the mesh reaches beyond the occluder's bounds");
  return findings;
}

/// Size and hash of the asset's file; primitives have none.
std::vector<std::string> checkFile(const Occluder& occluder, const fs::path& path) {
  const auto bytes = readFile(path);
  if (!bytes) return {message(bytes.error())};
  std::vector<std::string> findings;
  if (bytes.value().size() != occluder.bytes)
    findings.push_back(fmt::format("{}: has {} bytes, the scene says {}", path.string(), bytes.value().size(), occluder.bytes));
  if (contentHash(bytes.value()) != occluder.contentHash) findings.push_back(path.string() + ": content does not match the scene's hash");
  return findings;
}

std::vector<std::string> checkAsset(Occluder occluder, const fs::path& folder) {
  std::vector<std::string> findings;
  std::string file = "primitive";
  if (!occluder.primitive) {
    const auto path = resolveInside(folder, uriFromPath(occluder.uri));
    if (!path) return {message(path.error())};
    file = path.value().string();
    findings = checkFile(occluder, path.value());
    // What the file holds is looked at whatever its hash, which has had its finding.
    if (const auto bytes = readFile(path.value())) occluder.contentHash = contentHash(bytes.value());
  }
  const auto asset = readAsset(folder, occluder);
  if (!asset) {
    if (findings.empty()) findings.push_back(message(asset.error()));
    return findings;
  }
  if (!agree(bounds(asset.value()), occluder.bounds)) findings.push_back(file + ": bounds differ from the scene's");
  const auto* volume = std::get_if<Volume>(&asset.value());
  if (volume && volume->signMethod != occluder.signMethod)
    findings.push_back(fmt::format("{}: sign method '{}' differs from the scene's '{}'", file, volume->signMethod, occluder.signMethod));
  if (volume && (volume->inside != occluder.inside || volume->sheetThickness != occluder.sheetThickness))
    findings.push_back(fmt::format("{}: inside '{}' with sheets of {} differs from the scene's '{}' of {}", file, name(volume->inside),
                                   volume->sheetThickness, name(occluder.inside), occluder.sheetThickness));
  if (volume && occluder.bits > 0 && (volume->step > 0.0f) != (occluder.bits == 8))
    findings.push_back(
        fmt::format("{}: holds values of {} bits, the scene says {}", file, volume->step > 0.0f ? "8" : "more than 8", occluder.bits));
  const double steepest = lipschitzBound(asset.value());
  if (steepest > occluder.lipschitz * (1.0 + 1e-9))
    findings.push_back(fmt::format("{}: is steeper ({:.4f}) than the scene says ({:.4f})", file, steepest, occluder.lipschitz));
  return findings;
}

}  // namespace

Result<std::vector<std::string>> validate(const fs::path& path) {
  if (path.extension() == ".vdb") {
    const auto volume = readVolume(path);
    if (!volume) return volume.error();
    return std::vector<std::string>{};
  }
  if (!isSceneFile(path)) return Error{path.string(), "", "is neither a baked scene (.gltf .glb) nor a volume (.vdb)"};
  const auto scene = readScene(path);
  if (!scene) return scene.error();
  std::vector<std::string> findings;
  std::map<std::string, std::vector<std::string>> checked;  // nodes may share an occluder
  std::size_t meshNodes = 0;
  for (std::size_t i = 0; i < scene.value().nodes.size(); ++i) {
    const Node& node = scene.value().nodes[i];
    if (node.mesh < 0) continue;
    ++meshNodes;
    const std::string place = fmt::format("{}: node {} '{}'", path.string(), i, node.name);
    if (!node.occluder) {
      findings.push_back(place + ": has a mesh but no occluder");
      continue;
    }
    for (const std::string& finding : checkNumbers(*node.occluder, bounds(scene.value().meshes[static_cast<std::size_t>(node.mesh)])))
      findings.push_back(place + ": " + finding);
    const auto [entry, fresh] = checked.emplace(occluderJson(*node.occluder), std::vector<std::string>{});
    if (fresh) entry->second = checkAsset(*node.occluder, path.parent_path());
    for (const std::string& finding : entry->second) findings.push_back(place + ": " + finding);
  }
  if (const std::optional<Lighting>& lighting = scene.value().lighting; lighting && !lighting->skyImage.empty()) {
    const auto image = skyFile(path.parent_path(), lighting->skyImage);
    const Result<SkyHarmonics> sky = image ? readSky(image.value()) : Result<SkyHarmonics>(image.error());
    if (!sky) findings.push_back(message(sky.error()));
  }
  for (const Mesh& mesh : scene.value().meshes) {
    if (!mesh.apertureMap) continue;
    const auto map = readApertureMap(path.parent_path(), *mesh.apertureMap);
    if (!map) findings.push_back(fmt::format("{}: mesh '{}': {}", path.string(), mesh.name, message(map.error())));
  }
  for (const std::string& note : scene.value().notes) findings.push_back(path.string() + ": " + note);
  if (meshNodes == 0) findings.push_back(path.string() + ": holds no mesh");
  return findings;
}

}  // namespace overcast
