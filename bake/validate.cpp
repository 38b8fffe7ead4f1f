#include "bake/validate.h"

#include <cmath>
#include <map>

#include <glm/geometric.hpp>

#include "formats/files.h"
#include "formats/scene.h"
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
  if (!contains(occluder.bounds, mesh)) findings.push_back("the mesh reaches beyond the occluder's bounds");
  return findings;
}

std::vector<std::string> checkFile(const Occluder& occluder, const fs::path& folder) {
  const auto path = resolveInside(folder, occluder.uri);
  if (!path) return {message(path.error())};
  const auto bytes = readFile(path.value());
  if (!bytes) return {message(bytes.error())};
  std::vector<std::string> findings;
  const std::string file = path.value().string();
  if (bytes.value().size() != occluder.bytes)
    findings.push_back(fmt::format("{}: has {} bytes, the scene says {}", file, bytes.value().size(), occluder.bytes));
  if (contentHash(bytes.value()) != occluder.contentHash) findings.push_back(file + ": content does not match the scene's hash");
  const auto volume = readVolume(path.value());
  if (!volume) {
    findings.push_back(message(volume.error()));
    return findings;
  }
  if (!agree(bounds(volume.value()), occluder.bounds)) findings.push_back(file + ": bounds differ from the scene's");
  if (volume.value().signMethod != occluder.signMethod)
    findings.push_back(
        fmt::format("{}: sign method '{}' differs from the scene's '{}'", file, volume.value().signMethod, occluder.signMethod));
  const double steepest = lipschitzBound(volume.value());
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
  std::map<std::string, std::vector<std::string>> checked;  // by uri and hash: nodes may share a file
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
    const auto [entry, fresh] = checked.emplace(node.occluder->uri + '\n' + node.occluder->contentHash, std::vector<std::string>{});
    if (fresh) entry->second = checkFile(*node.occluder, path.parent_path());
    for (const std::string& finding : entry->second) findings.push_back(place + ": " + finding);
  }
  if (meshNodes == 0) findings.push_back(path.string() + ": holds no mesh");
  return findings;
}

}  // namespace overcast
