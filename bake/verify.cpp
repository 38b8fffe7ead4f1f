#include "bake/verify.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "bake/edges.h"
#include "bake/measure.h"
#include "bake/scene_bake.h"
#include "bake/sign.h"
#include "bake/verify_apertures.h"
#include "formats/asset.h"
#include "formats/extension_json.h"
#include "formats/normals.h"
#include "formats/scene.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

/// One stated figure beside the one measured now.
void compare(const char* what, double stated, double measured, double unit, std::vector<std::string>& findings) {
  if (std::abs(measured - stated) <= kVerifyTolerance * std::abs(measured) + kVerifySlack * unit) return;
  findings.push_back(fmt::format("states {} {:.6g}, measured {:.6g}", what, stated, measured));
}

/// How the inside of such a field is found.
std::string methodFor(Inside inside, const SheetParts& parts) {
  if (inside == Inside::none) return kTwoSided;
  return netBoundary(parts.solids.triangles).empty() ? kSignedCrossings : kWindingNumber;
}

/// What the source says against the asset.
std::vector<std::string> compareWith(const Mesh& source, const Occluder& occluder, const Asset& asset) {
  std::vector<std::string> findings;
  const MeasuredError& stated = occluder.error;
  const Probes probes = drawProbes(source, {stated.samples, stated.seed});
  if (const auto* volume = std::get_if<Volume>(&asset)) {
    const SheetParts parts = sheetParts(*volume, probes);
    const Inside inside = insideOf(probes.found, parts);
    const std::string method = methodFor(inside, parts);
    if (volume->inside != Inside::unstated && volume->inside != inside)
      findings.push_back(fmt::format("states that its inside is '{}', that of the source is '{}'", name(volume->inside), name(inside)));
    if (volume->signMethod != occluder.signMethod || volume->signMethod != method)
      findings.push_back(
          fmt::format("states sign method '{}', its file '{}', the source needs '{}'", occluder.signMethod, volume->signMethod, method));
  }
  const MeasuredError now = measure(asset, probes);
  compare("max", stated.max, now.max, probes.diagonal, findings);
  compare("rms", stated.rms, now.rms, probes.diagonal, findings);
  compare("p99", stated.p99, now.p99, probes.diagonal, findings);
  compare("surfaceRms", stated.surfaceRms, now.surfaceRms, probes.diagonal, findings);
  compare("skyRmse", stated.skyRmse, now.skyRmse, 1.0, findings);
  // A point whose distance is zero but for rounding may change sides.
  const double off = std::abs(static_cast<double>(now.signErrors) - static_cast<double>(stated.signErrors));
  if (off > 1.0 + kVerifyTolerance * static_cast<double>(now.signErrors))
    findings.push_back(fmt::format("states {} sign errors, measured {}", stated.signErrors, now.signErrors));
  return findings;
}

/// What can be said without a source; `asset` is filled when it can be read.
std::vector<std::string> checkStatement(const Occluder& occluder, const fs::path& folder, std::optional<Asset>& asset) {
  auto read = readAsset(folder, occluder);
  if (!read) return {message(read.error())};
  asset = std::move(read).value();
  std::vector<std::string> findings;
  const Box box = bounds(*asset);
  const double slack = kVerifySlack * diagonal(box);
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(box.min[axis] - occluder.bounds.min[axis]) > slack || std::abs(box.max[axis] - occluder.bounds.max[axis]) > slack) {
      findings.push_back("states bounds that are not those of its asset");
      break;
    }
  const double steepest = lipschitzBound(*asset);
  if (steepest > occluder.lipschitz * (1.0 + 1e-9))
    findings.push_back(fmt::format("states lipschitz {:.6g}, its asset has {:.6g}", occluder.lipschitz, steepest));
  if (occluder.error.samples == 0)
    findings.push_back("states no measured error; bake it with --error-samples above 0");
  else if (occluder.error.method != kMeasureMethod)
    findings.push_back(
        fmt::format("states an error of method '{}', this program measures '{}'; bake it again", occluder.error.method, kMeasureMethod));
  return findings;
}

/// The findings of one occluder against the meshes that its source may be; those of the nearest one.
std::vector<std::string> verifyOccluder(const Occluder& occluder, const fs::path& folder, const std::vector<const Mesh*>& candidates) {
  std::optional<Asset> asset;
  std::vector<std::string> findings = checkStatement(occluder, folder, asset);
  if (!asset || occluder.error.samples == 0 || occluder.error.method != kMeasureMethod) return findings;
  if (candidates.empty()) {
    findings.push_back(fmt::format("its source '{}' is not among the sources given", occluder.source));
    return findings;
  }
  std::optional<std::vector<std::string>> best;
  for (const Mesh* candidate : candidates) {
    std::vector<std::string> against = compareWith(*candidate, occluder, *asset);
    if (!best || against.size() < best->size()) best = std::move(against);
    if (best->empty()) break;
  }
  findings.insert(findings.end(), best->begin(), best->end());
  return findings;
}

/// Whether `mesh` is `source` as a bake writes it, but for what it added: then the source knows the positions better.
bool isWritten(const Mesh& mesh, const Mesh& source) {
  const auto same = [](const glm::dvec3& written, const glm::dvec3& p) { return glm::vec3(written) == glm::vec3(p); };
  return mesh.triangles == source.triangles &&
         std::equal(mesh.positions.begin(), mesh.positions.end(), source.positions.begin(), source.positions.end(), same);
}

using Sources = std::map<std::string, std::vector<const Mesh*>>;

/// Gives the meshes of a baked scene the positions of their sources, where these are the same in single floats.
void placeAsBaked(Scene& scene, const Sources& sources) {
  for (const Node& node : scene.nodes) {
    if (node.mesh < 0 || !node.occluder || !sources.contains(node.occluder->source)) continue;
    Mesh& mesh = scene.meshes[static_cast<std::size_t>(node.mesh)];
    for (const Mesh* candidate : sources.at(node.occluder->source)) {
      const Mesh source = candidate->normals.empty() ? withNormals(Mesh(*candidate)) : *candidate;
      if (isWritten(mesh, source)) mesh.positions = source.positions;
    }
  }
}

}  // namespace

Result<std::vector<std::string>> verify(const fs::path& path, const std::vector<fs::path>& sources, const TerrainOptions& terrain) {
  auto scene = readScene(path);
  if (!scene) return scene.error();
  std::vector<BakeInput> inputs;
  for (const fs::path& source : sources) {
    auto input = readBakeInput(source, terrain);
    if (!input) return input.error();
    inputs.push_back(std::move(input).value());
  }
  const SceneBake known = joinInputs(std::move(inputs));
  Sources bySource;
  for (const MeshBake& mesh : known.meshes) bySource[mesh.source].push_back(&known.scene.meshes[static_cast<std::size_t>(mesh.mesh)]);

  std::vector<std::string> findings;
  std::map<std::string, std::vector<std::string>> checked;  // by what is stated: nodes may share an asset and all that is said of it
  std::size_t occluders = 0;
  for (std::size_t i = 0; i < scene.value().nodes.size(); ++i) {
    const Node& node = scene.value().nodes[i];
    if (!node.occluder) continue;
    ++occluders;
    const auto [entry, fresh] = checked.emplace(occluderJson(*node.occluder), std::vector<std::string>{});
    if (fresh) entry->second = verifyOccluder(*node.occluder, path.parent_path(), bySource[node.occluder->source]);
    for (const std::string& finding : entry->second)
      findings.push_back(fmt::format("{}: node {} '{}': {}", path.string(), i, node.name, finding));
  }
  placeAsBaked(scene.value(), bySource);
  for (const std::string& finding : verifyApertures(scene.value())) findings.push_back(path.string() + ": " + finding);
  if (occluders == 0) findings.push_back(path.string() + ": holds no occluder");
  return findings;
}

}  // namespace overcast
