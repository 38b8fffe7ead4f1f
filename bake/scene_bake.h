// Scene bake: inputs become one scene, every mesh gets its occluder, everything is written to one folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bake/cache.h"
#include "bake/memory.h"
#include "bake/mesh_bake.h"
#include "bake/progress.h"
#include "formats/mesh.h"
#include "formats/scene.h"
#include "formats/terrain.h"

namespace overcast {

/// One input file as read.
struct BakeInput {
  std::filesystem::path path;
  Scene scene;
  std::optional<MeshReadReport> report;  ///< of mesh files
  BakeSettings settings;                 ///< for its meshes; readBakeInput leaves the defaults
  std::filesystem::path skyImage;        ///< the file of its lighting's sky; empty: none
};

/// Reads a mesh file (a scene of one node, formats/scene.h), a height file (bake/terrain_mesh.h) or a glTF scene. An Error that names the
/// file when it is none of them, cannot be read, holds no triangle, or has a sky image that is none. Meshes without a triangle or without
/// extent are taken off their nodes with a note in scene.notes.
Result<BakeInput> readBakeInput(const std::filesystem::path& path, const TerrainOptions& terrain = {});

/// All inputs side by side, and their bakes.
struct SceneBake {
  Scene scene;
  std::vector<std::filesystem::path> inputs;
  std::vector<BakeSettings> settings;  ///< of each input
  std::vector<MeshBake> meshes;
  std::filesystem::path skyImage;  ///< of the lighting that is kept; empty: none
};

/// Puts the inputs side by side into one scene, as they lie: their roots become its roots. The first lighting found is kept.
SceneBake joinInputs(std::vector<BakeInput> inputs);

/// Called from any thread when a mesh is done.
using MeshDone = std::function<void(const MeshBake&)>;

/// What bakes share with each other and tell others. Everything may be left out.
struct BakeContext {
  Cache* cache = nullptr;
  KeyLocks* locks = nullptr;     ///< with a cache: no two threads bake the same mesh
  MemoryGate* memory = nullptr;  ///< keeps meshes waiting that would not fit into memory
  Progress progress;
  MeshDone done;
};

/// Bakes every distinct mesh, or takes it from the cache, several at once on the calling TBB arena. Failures land in MeshBake::error.
void bakeMeshes(SceneBake& bake, const BakeContext& context = {});

/// Takes the inputs whose meshes failed out of the scene (their nodes lose mesh and occluder).
void dropFailedInputs(SceneBake& bake);

/// What the scene of these inputs is called: a single glTF scene keeps its stem ("default"), everything else makes a "scene".
std::string outputName(const std::vector<std::filesystem::path>& inputs);

/// Writes folder/<name>.gltf, <name>-<hash>.bin and the files of the occluders (volumes/<mesh>-<hash>.vdb; other representations in folders
/// of theirs, aperture maps in apertures/), a copy of the sky image (skies/<image>-<hash>.exr), and returns their paths, the scene last.
/// All but the scene are named by what they hold and the scene replaces an older one only when all of it is on disk: whoever kills the
/// process finds the old scene or the new one, whole.
Result<std::vector<std::filesystem::path>> writeBake(SceneBake& bake, const std::filesystem::path& folder, const std::string& name);

}  // namespace overcast
