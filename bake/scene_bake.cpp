#include "bake/scene_bake.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <system_error>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "bake/bake_record.h"
#include "bake/terrain_mesh.h"
#include "formats/files.h"
#include "formats/sky.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

/// A name that is a plain file name everywhere.
std::string fileNameOf(const std::string& name) {
  std::string safe;
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    safe += plain ? c : '_';
    if (safe.size() == 40) break;
  }
  return safe.empty() ? "mesh" : safe;
}

/// Takes meshes that cannot occlude anything off their nodes; says how many meshes are left.
std::size_t dropEmptyMeshes(Scene& scene) {
  std::vector<char> empty;
  std::size_t left = 0;
  for (const Mesh& mesh : scene.meshes) {
    empty.push_back(mesh.triangles.empty() || extent(bounds(mesh)) == glm::dvec3(0.0));
    left += !empty.back();
  }
  for (Node& node : scene.nodes) {
    if (node.mesh < 0 || !empty[static_cast<std::size_t>(node.mesh)]) continue;
    scene.notes.push_back(fmt::format("node '{}': its mesh has no triangle with an extent and is left out", node.name));
    node.mesh = -1;
  }
  return left;
}

template <class T>
void appendTo(std::vector<T>& all, std::vector<T>& more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

/// Adds `other` to `scene` with every index moved behind what is there.
void appendScene(Scene& scene, Scene other) {
  const auto shift = [](int& index, std::size_t by) {
    if (index >= 0) index += static_cast<int>(by);
  };
  for (Mesh& mesh : other.meshes)
    for (MeshPart& part : mesh.parts) shift(part.material, scene.materials.size());
  for (Node& node : other.nodes) {
    shift(node.parent, scene.nodes.size());
    for (int& child : node.children) shift(child, scene.nodes.size());
    shift(node.mesh, scene.meshes.size());
    shift(node.camera, scene.cameras.size());
    node.occluder.reset();
  }
  for (Animation& animation : other.animations)
    for (AnimationChannel& channel : animation.channels) shift(channel.node, scene.nodes.size());
  if (other.lighting)
    for (AreaLight& light : other.lighting->areaLights) shift(light.node, scene.nodes.size());
  appendTo(scene.meshes, other.meshes);
  appendTo(scene.materials, other.materials);
  appendTo(scene.cameras, other.cameras);
  appendTo(scene.nodes, other.nodes);
  appendTo(scene.animations, other.animations);
  appendTo(scene.notes, other.notes);
  if (!scene.lighting) scene.lighting = other.lighting;
}

/// Where the asset of a mesh is: its own bake, or the one it shares.
const MeshBake& owner(const SceneBake& bake, const MeshBake& mesh) {
  return mesh.sameAs < 0 ? mesh : bake.meshes[static_cast<std::size_t>(mesh.sameAs)];
}

/// Where the files of a representation go.
const char* folderOf(Representation representation) {
  switch (representation) {
    case Representation::radius:
      return "radii";
    case Representation::heightfield:
      return "heightfields";
    default:
      return "volumes";
  }
}

/// Writes the file of a baked mesh and fills in what its occluder says of it.
Result<Done> writeAssetOf(MeshBake& mesh, const std::string& name, const fs::path& folder) {
  const EncodedAsset& asset = *mesh.asset;
  mesh.occluder.source = mesh.source;
  if (asset.extension.empty()) return Done{};
  mesh.occluder.uri =
      fmt::format("{}/{}-{}{}", folderOf(mesh.occluder.representation), fileNameOf(name), mesh.hash.substr(0, 8), asset.extension);
  return writeFileAtomically(folder / mesh.occluder.uri, asset.bytes);
}

/// Copies the sky image into the folder and names it in the lighting.
Result<fs::path> copySky(SceneBake& bake, const fs::path& folder) {
  const auto bytes = readFile(bake.skyImage);
  if (!bytes) return bytes.error();
  const std::string hash = contentHash(bytes.value()).substr(0, 8);
  bake.scene.lighting->skyImage = fmt::format("skies/{}-{}.exr", fileNameOf(bake.skyImage.stem().string()), hash);
  const fs::path file = folder / bake.scene.lighting->skyImage;
  if (const auto written = writeFileAtomically(file, bytes.value()); !written) return written.error();
  return file;
}

/// Writes the aperture map of a mesh and names it there.
Result<fs::path> writeMapOf(MeshBake& job, Mesh& mesh, const fs::path& folder) {
  mesh.apertureMap->uri = fmt::format("apertures/{}-{}.exr", fileNameOf(mesh.name), mesh.apertureMap->contentHash.substr(0, 8));
  const auto written = writeFileAtomically(folder / mesh.apertureMap->uri, job.mapBytes);
  if (!written) return written.error();
  return folder / mesh.apertureMap->uri;
}

/// Takes the mesh from the cache, or bakes it and keeps it there.
Result<Done> obtainMesh(MeshBake& job, const Mesh& mesh, const BakeSettings& settings, const BakeContext& context,
                        const Progress& progress) {
  std::optional<KeyLocks::Lock> lock;
  if (context.cache && context.locks) lock.emplace(*context.locks, job.hash);
  if (context.cache && restoreMesh(*context.cache, job)) return Done{};
  if (!progress(0.0)) return Error{"", "", "interrupted"};
  std::optional<MemoryGate::Share> share;
  if (context.memory) share.emplace(*context.memory, bakeMemory(mesh, settings));
  auto baked = bakeMesh(job, mesh, settings, progress);
  if (baked && context.cache) keepMesh(*context.cache, job);
  return baked;
}

}  // namespace

Result<BakeInput> readBakeInput(const fs::path& path, const TerrainOptions& terrain) {
  std::error_code code;
  if (fs::is_directory(path, code)) return Error{path.string(), "", "is a folder; name the files in it"};
  BakeInput input;
  input.path = path;
  if (isMeshFile(path)) {
    auto mesh = readMesh(path);
    if (!mesh) return mesh.error();
    input.report = mesh.value().report;
    Mesh& read = mesh.value().mesh;
    if (read.name.empty()) read.name = path.stem().string();
    input.scene = sceneFromMesh(std::move(read));
  } else if (isSceneFile(path)) {
    auto scene = readScene(path);
    if (!scene) return scene.error();
    input.scene = std::move(scene).value();
    if (input.scene.lighting && !input.scene.lighting->skyImage.empty()) {
      const Result<fs::path> image = skyFile(path.parent_path(), input.scene.lighting->skyImage);
      if (!image) return image.error();
      if (const Result<SkyHarmonics> sky = readSky(image.value()); !sky) return sky.error();
      input.skyImage = image.value();
    }
  } else if (isTerrainFile(path)) {
    auto heights = readTerrain(path, terrain);
    if (!heights) return heights.error();
    auto scene = sceneFromTerrain(std::move(heights).value(), path.stem().string());
    if (!scene) return Error{path.string(), "", scene.error().reason};
    input.scene = std::move(scene).value();
  } else {
    return Error{path.string(), "", "is no mesh (.obj .ply .stl .off), scene (.gltf .glb) or height file (.png .exr .asc .dem)"};
  }
  if (dropEmptyMeshes(input.scene) == 0) return Error{path.string(), "", "holds no mesh with an extent"};
  return input;
}

SceneBake joinInputs(std::vector<BakeInput> inputs) {
  SceneBake bake;
  std::map<std::string, int> known;
  for (BakeInput& input : inputs) {
    const auto first = static_cast<int>(bake.scene.meshes.size());
    const std::string file = input.path.filename().string();
    std::vector<char> used(input.scene.meshes.size(), 0);
    for (const Node& node : input.scene.nodes)
      if (node.mesh >= 0) used[static_cast<std::size_t>(node.mesh)] = 1;
    for (std::size_t m = 0; m < input.scene.meshes.size(); ++m) {
      if (!used[m]) continue;
      const Mesh& mesh = input.scene.meshes[m];
      MeshBake job;
      job.mesh = first + static_cast<int>(m);
      job.input = static_cast<int>(bake.inputs.size());
      job.source = isMeshFile(input.path) || isTerrainFile(input.path) || mesh.name.empty() ? file : file + ": " + mesh.name;
      job.hash = meshHash(mesh, input.settings);
      job.faces = mesh.triangles.size();
      job.heights = isTerrainFile(input.path);
      const auto [place, fresh] = known.emplace(job.hash, static_cast<int>(bake.meshes.size()));
      if (!fresh) job.sameAs = place->second;
      bake.meshes.push_back(std::move(job));
    }
    bake.inputs.push_back(input.path);
    bake.settings.push_back(input.settings);
    if (inputs.size() == 1) bake.scene.name = input.scene.name;
    if (!bake.scene.lighting) bake.skyImage = input.skyImage;
    appendScene(bake.scene, std::move(input.scene));
  }
  if (!bake.scene.lighting) bake.scene.lighting = Lighting{};
  return bake;
}

void bakeMeshes(SceneBake& bake, const BakeContext& context) {
  std::vector<std::size_t> jobs;
  for (std::size_t i = 0; i < bake.meshes.size(); ++i)
    if (bake.meshes[i].sameAs < 0) jobs.push_back(i);
  std::vector<std::atomic<double>> shares(jobs.size());
  const auto report = [&](std::size_t job, double share) {
    shares[job] = share;
    double sum = 0.0;
    for (const std::atomic<double>& one : shares) sum += one;
    return !context.progress || context.progress(sum / static_cast<double>(jobs.size()));
  };
  tbb::parallel_for(std::size_t{0}, jobs.size(), [&](std::size_t job) {
    MeshBake& mesh = bake.meshes[jobs[job]];
    const auto start = std::chrono::steady_clock::now();
    // Isolated: a mesh that waits for its own tiles must not start on another mesh, or its seconds would count that one's too, and it could
    // wait for memory or a key that is held further down its own stack.
    const Result<Done> baked = tbb::this_task_arena::isolate([&] {
      return obtainMesh(mesh, bake.scene.meshes[static_cast<std::size_t>(mesh.mesh)], bake.settings[static_cast<std::size_t>(mesh.input)],
                        context, [&](double share) { return report(job, share); });
    });
    mesh.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!baked) {
      const fs::path& file = bake.inputs[static_cast<std::size_t>(mesh.input)];
      const bool named = mesh.source != file.filename().string();
      mesh.error = Error{file.string(), named ? bake.scene.meshes[static_cast<std::size_t>(mesh.mesh)].name : "", baked.error().reason};
    }
    report(job, 1.0);
    if (context.done) context.done(mesh);
  });
}

void dropFailedInputs(SceneBake& bake) {
  std::vector<char> failed(bake.inputs.size(), 0);
  for (const MeshBake& mesh : bake.meshes)
    if (owner(bake, mesh).error) failed[static_cast<std::size_t>(mesh.input)] = 1;
  for (const MeshBake& mesh : bake.meshes) {
    if (!failed[static_cast<std::size_t>(mesh.input)]) continue;
    for (Node& node : bake.scene.nodes)
      if (node.mesh == mesh.mesh) node.mesh = -1;
  }
}

std::string outputName(const std::vector<fs::path>& inputs) {
  return inputs.size() == 1 && isSceneFile(inputs[0]) ? inputs[0].stem().string() : "scene";
}

Result<std::vector<fs::path>> writeBake(SceneBake& bake, const fs::path& folder, const std::string& name) {
  std::error_code code;
  if (fs::exists(folder, code) && !fs::is_directory(folder, code)) return Error{folder.string(), "", "is not a folder"};
  std::vector<fs::path> files;
  for (MeshBake& mesh : bake.meshes) {
    const bool wanted =
        std::any_of(bake.scene.nodes.begin(), bake.scene.nodes.end(), [&](const Node& node) { return node.mesh == mesh.mesh; });
    if (!wanted) continue;
    MeshBake& baked = bake.meshes[static_cast<std::size_t>(&owner(bake, mesh) - bake.meshes.data())];
    if (baked.occluder.source.empty()) {  // not written yet
      auto written = writeAssetOf(baked, bake.scene.meshes[static_cast<std::size_t>(baked.mesh)].name, folder);
      if (!written) return written.error();
      if (!baked.occluder.uri.empty()) files.push_back(folder / baked.occluder.uri);
    }
    if (!mesh.mapBytes.empty()) {
      auto written = writeMapOf(mesh, bake.scene.meshes[static_cast<std::size_t>(mesh.mesh)], folder);
      if (!written) return written.error();
      files.push_back(std::move(written).value());
    }
    mesh.occluder = baked.occluder;
    for (Node& node : bake.scene.nodes)
      if (node.mesh == mesh.mesh) node.occluder = mesh.occluder;
  }
  if (!bake.skyImage.empty()) {
    const Result<fs::path> copied = copySky(bake, folder);
    if (!copied) return copied.error();
    files.push_back(copied.value());
  }
  const auto written = writeScene(folder / (name + ".gltf"), bake.scene);
  if (!written) return written.error();
  files.insert(files.end(), written.value().begin(), written.value().end());
  return files;
}

}  // namespace overcast
