#include "bake/scene_apertures.h"

#include <algorithm>
#include <map>
#include <memory>

#include <glm/matrix.hpp>

#include "formats/files.h"
#include "formats/normals.h"

namespace overcast {
namespace {

std::size_t at(int index) {
  return static_cast<std::size_t>(index);
}

/// Gives every resting node a mesh that no other node shows.
void separateMeshes(SceneBake& bake, const std::vector<char>& moving) {
  std::map<int, int> entry;  // of SceneBake::meshes, by mesh
  for (std::size_t i = 0; i < bake.meshes.size(); ++i) entry[bake.meshes[i].mesh] = static_cast<int>(i);
  std::vector<char> taken(bake.scene.meshes.size(), 0);
  for (std::size_t n = 0; n < moving.size(); ++n)
    if (moving[n] && bake.scene.nodes[n].mesh >= 0) taken[at(bake.scene.nodes[n].mesh)] = 1;
  for (std::size_t n = 0; n < moving.size(); ++n) {
    const int mesh = bake.scene.nodes[n].mesh;
    if (moving[n] || mesh < 0 || !entry.contains(mesh)) continue;
    if (!std::exchange(taken[at(mesh)], 1)) continue;
    const int original = entry[mesh];
    MeshBake copy = bake.meshes[at(original)];
    copy.mesh = bake.scene.nodes[n].mesh = static_cast<int>(bake.scene.meshes.size());
    if (copy.sameAs < 0) copy.sameAs = original;
    copy.asset.reset();
    bake.scene.meshes.push_back(Mesh(bake.scene.meshes[at(mesh)]));
    bake.meshes.push_back(std::move(copy));
  }
}

Error failureOf(const SceneBake& bake, const MeshBake& job, const std::string& reason) {
  return Error{bake.inputs[at(job.input)].string(), bake.scene.meshes[at(job.mesh)].name, reason};
}

/// A stage without trees.
Stage emptyStage(const Scene& scene) {
  Stage stage;
  stage.trees.resize(scene.meshes.size());
  stage.world = worldFromLocal(scene, 0.0);
  return stage;
}

std::vector<char> shownMeshes(const Scene& scene) {
  std::vector<char> shown(scene.meshes.size(), 0);
  for (const Node& node : scene.nodes)
    if (node.mesh >= 0) shown[at(node.mesh)] = 1;
  return shown;
}

Result<Done> addTree(Stage& stage, const Scene& scene, int mesh, const RayScene*& family) {
  auto tree = makeRayScene(scene.meshes[at(mesh)], family);
  if (!tree) return tree.error();
  stage.trees[at(mesh)] = std::move(tree).value();
  family = stage.trees[at(mesh)].get();
  return Done{};
}

/// Lets the nodes that no animation moves see each other.
void addResting(Stage& stage, const Scene& scene, const std::vector<char>& moving) {
  for (std::size_t n = 0; n < moving.size(); ++n) {
    const int mesh = scene.nodes[n].mesh;
    if (!moving[n] && mesh >= 0 && stage.trees[at(mesh)]) stage.resting.push_back(static_cast<int>(n));
  }
}

/// Normals and trees of all meshes that are shown.
Stage prepare(SceneBake& bake, const std::vector<char>& moving, const SceneApertureSettings& settings) {
  Stage stage = emptyStage(bake.scene);
  const std::vector<char> shown = shownMeshes(bake.scene);
  const RayScene* family = nullptr;
  for (MeshBake& job : bake.meshes) {
    if (job.error || !shown[at(job.mesh)]) continue;
    Mesh& mesh = bake.scene.meshes[at(job.mesh)];
    if (mesh.normals.empty()) mesh = withNormals(std::move(mesh));
    mendNormals(mesh);
    const auto laidOut = settings.map ? layOut(mesh, *settings.map) : Result<Done>(Done{});
    const auto added = laidOut ? addTree(stage, bake.scene, job.mesh, family) : laidOut;
    if (!added) job.error = failureOf(bake, job, added.error().reason);
  }
  if (settings.occluders == Occluding::scene) addResting(stage, bake.scene, moving);
  return stage;
}

ApertureBake bakeOf(const SceneApertureSettings& settings, const ApertureReport& report) {
  const ApertureSettings& aperture = settings.aperture;
  return {static_cast<std::uint32_t>(aperture.visibility.rays),
          settings.occluders == Occluding::scene,
          report.fitted,
          aperture.errorSamples,
          aperture.seed,
          report.error.radius,
          report.error.ambient,
          report.error.direction};
}

void giveVertices(MeshBake& job, Mesh& mesh, const SceneApertureSettings& settings, BakedApertures baked) {
  mesh.apertureBake = bakeOf(settings, baked.report);
  mesh.visibility = std::move(baked.visibility);
  mesh.apertureMap.reset();
  job.apertures = baked.report;
}

void giveMap(MeshBake& job, Mesh& mesh, Occluding occluders, BakedApertureMap baked) {
  job.mapBytes = encodeApertureMap(baked.map);
  baked.report.bytes = job.mapBytes.size();
  job.apertureMap = baked.report;
  mesh.visibility.reset();
  mesh.apertureBake.reset();
  ApertureLink& link = mesh.apertureMap.emplace();
  link.contentHash = contentHash(job.mapBytes);
  link.bytes = job.mapBytes.size();
  link.sceneOccludes = occluders == Occluding::scene;
  if (baked.report.samples == 0) return;
  link.radiusError = baked.report.error.radius;
  link.ambientError = baked.report.error.ambient;
  link.directionError = baked.report.error.direction;
}

}  // namespace

Result<Stage> setStage(const Scene& scene, Occluding occluders) {
  Stage stage = emptyStage(scene);
  const std::vector<char> shown = shownMeshes(scene);
  const RayScene* family = nullptr;
  for (std::size_t mesh = 0; mesh < scene.meshes.size(); ++mesh) {
    if (!shown[mesh]) continue;
    const auto added = addTree(stage, scene, static_cast<int>(mesh), family);
    if (!added) return Error{"", scene.meshes[mesh].name, added.error().reason};
  }
  if (occluders == Occluding::scene) addResting(stage, scene, movingNodes(scene));
  return stage;
}

Result<SurroundingsPointer> surroundingsOf(const Stage& stage, const Scene& scene, int mesh) {
  const auto node = std::find_if(stage.resting.begin(), stage.resting.end(), [&](int n) { return scene.nodes[at(n)].mesh == mesh; });
  if (node == stage.resting.end() || glm::determinant(glm::dmat3(stage.world[at(*node)])) == 0.0) return SurroundingsPointer();
  const glm::dmat4 localFromWorld = glm::inverse(stage.world[at(*node)]);
  std::vector<Neighbour> neighbours;
  for (const int other : stage.resting)
    if (other != *node) neighbours.push_back({stage.trees[at(scene.nodes[at(other)].mesh)].get(), localFromWorld * stage.world[at(other)]});
  return surround(*stage.trees[at(mesh)], neighbours);
}

std::string settingsText(const SceneApertureSettings& settings) {
  if (const auto& map = settings.map)
    return fmt::format("aperture maps: rays {} texels {} atlas {} samples {} seed {} occluders {}", map->visibility.rays, map->texels,
                       map->atlas, map->errorSamples, map->seed, static_cast<int>(settings.occluders));
  const ApertureSettings& aperture = settings.aperture;
  return fmt::format("apertures: rays {} transfer {} bits {} samples {} seed {} occluders {} vertices {}", aperture.visibility.rays,
                     aperture.visibility.transfer, static_cast<int>(aperture.bits), aperture.errorSamples, aperture.seed,
                     static_cast<int>(settings.occluders), settings.mostVertices);
}

void bakeSceneApertures(SceneBake& bake, const SceneApertureSettings& settings, const Progress& progress, const MeshDone& done) {
  const std::vector<char> moving = movingNodes(bake.scene);
  if (settings.occluders == Occluding::scene) separateMeshes(bake, moving);
  VisibilitySettings aperture = settings.aperture.visibility;
  aperture.transfer = false;
  const Stage stage = prepare(bake, moving, settings);
  const auto count = static_cast<double>(bake.meshes.size());
  for (std::size_t i = 0; i < bake.meshes.size(); ++i) {
    MeshBake& job = bake.meshes[i];
    if (job.error || !stage.trees[at(job.mesh)]) continue;
    const auto others = surroundingsOf(stage, bake.scene, job.mesh);
    if (!others) job.error = failureOf(bake, job, others.error().reason);
    if (!others) continue;
    Mesh& mesh = bake.scene.meshes[at(job.mesh)];
    const Occluders occluders{stage.trees[at(job.mesh)].get(), others.value().get()};
    bool stopped = false;
    const Progress share = [&](double part) {
      if (progress && !progress((static_cast<double>(i) + part) / count)) stopped = true;
      return !stopped;
    };
    if (settings.mostVertices > 0) mesh = refined(std::move(mesh), occluders, {settings.mostVertices, aperture}, share);
    if (settings.map)
      giveMap(job, mesh, settings.occluders, bakeApertureMap(mesh, occluders, *settings.map, share));
    else
      giveVertices(job, mesh, settings, bakeApertures(mesh, occluders, settings.aperture, share));
    if (stopped) return;
    if (done) done(job);
  }
}

}  // namespace overcast
