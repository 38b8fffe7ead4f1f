// Scene bake: inputs become one scene, every mesh gets its occluder, everything is written to one folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bake/aperture.h"
#include "bake/choose.h"
#include "bake/examine.h"
#include "bake/volume.h"
#include "formats/mesh.h"
#include "formats/scene.h"

namespace overcast {

/// One input file as read.
struct BakeInput {
  std::filesystem::path path;
  Scene scene;
  std::optional<MeshReadReport> report;  ///< of mesh files
};

/// Reads a mesh file (a scene of one node, formats/scene.h) or a glTF scene. An Error that names the file when it is neither, cannot be
/// read, or holds no triangle. Meshes without a triangle or without extent are taken off their nodes with a note in scene.notes.
Result<BakeInput> readBakeInput(const std::filesystem::path& path);

/// How every mesh is baked: as a volume with these settings, or, where there are settings for it, as what the choice finds best.
struct BakeSettings {
  VolumeSettings volume;
  std::optional<ChoiceSettings> choice;
};

/// One mesh of the scene and what became of it. Meshes with the same geometry share one bake.
struct MeshBake {
  int mesh = -1;       ///< index into SceneBake::scene.meshes
  int input = -1;      ///< index into SceneBake::inputs
  std::string source;  ///< "bunny.off", or "truck.glb: wheel"
  int sameAs = -1;     ///< index of the MeshBake whose asset this one shares, or -1
  std::string hash;    ///< of geometry, settings and baker
  std::uint64_t faces = 0;
  double seconds = 0.0;
  std::optional<Asset> asset;  ///< as stored; empty when shared or failed
  MeasuredError measured;      ///< of the asset (bake/measure.h); samples is 0 when not measured
  MeshDiagnosis found;
  double ambiguousSign = 0.0;               ///< BakedVolume or Probes
  std::uint64_t sheetTriangles = 0;         ///< BakedVolume
  SurfaceReport surface;                    ///< thin: a voxel of a volume, a hundredth of the diagonal of anything else
  std::optional<MeasuredError> inBox;       ///< BakedVolume::error, without choice
  std::optional<ChoiceRecord> choice;       ///< with choice
  std::optional<ApertureReport> apertures;  ///< where vertices were given apertures (bake/scene_apertures.h)
  std::optional<Error> error;
  Occluder occluder;  ///< filled by writeBake
};

/// All inputs side by side, and their bakes.
struct SceneBake {
  Scene scene;
  std::vector<std::filesystem::path> inputs;
  std::vector<MeshBake> meshes;
};

/// Puts the inputs side by side into one scene, as they lie: their roots become its roots. The first lighting found is kept.
SceneBake joinInputs(std::vector<BakeInput> inputs, const BakeSettings& settings);

/// Called from any thread when a mesh is done.
using MeshDone = std::function<void(const MeshBake&)>;

/// Bakes every distinct mesh, several at once on the calling TBB arena. Failures land in MeshBake::error.
void bakeMeshes(SceneBake& bake, const BakeSettings& settings, const Progress& progress = {}, const MeshDone& done = {});

/// Takes the inputs whose meshes failed out of the scene (their nodes lose mesh and occluder).
void dropFailedInputs(SceneBake& bake);

/// What the scene of these inputs is called: a single glTF scene keeps its stem ("default"), everything else makes a "scene".
std::string outputName(const std::vector<std::filesystem::path>& inputs);

/// Writes folder/<name>.gltf, <name>-<hash>.bin and the files of the occluders (volumes/<mesh>-<hash>.vdb; other representations in folders
/// of theirs) and returns their paths, the scene last. All but the scene are named by what they hold and the scene replaces an older one
/// only when all of it is on disk: whoever kills the process finds the old scene or the new one, whole.
Result<std::vector<std::filesystem::path>> writeBake(SceneBake& bake, const std::filesystem::path& folder, const std::string& name,
                                                     const BakeSettings& settings);

}  // namespace overcast
