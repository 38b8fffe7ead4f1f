// Bake job: one output scene from its inputs, by way of the cache: what was baked before from the same bytes with the same settings is not
// even parsed again.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bake/bake_report.h"
#include "bake/scene_apertures.h"
#include "bake/scene_bake.h"

namespace overcast {

/// What one scene is baked from and where it goes.
struct BakeJob {
  std::vector<std::filesystem::path> inputs;  ///< meshes and scenes
  std::vector<BakeSettings> settings;         ///< of each input
  std::filesystem::path folder;
  std::string name;  ///< of the scene, without .gltf
  std::optional<SceneApertureSettings> apertures;
  TerrainOptions terrain = {};
};

enum class JobOutcome {
  baked,        ///< at least one mesh had to be baked, or the inputs at least read
  restored,     ///< the whole result came out of the cache
  upToDate,     ///< the whole result lay in the folder already
  partial,      ///< keepGoing: some inputs failed and the others were baked
  failed,       ///< an input cannot be read or baked; nothing was written
  cannotWrite,  ///< the output cannot be written
  interrupted   ///< asked to stop; nothing was written
};

struct JobReport {
  JobOutcome outcome = JobOutcome::failed;
  std::vector<InputReport> inputs;                ///< in the order of the job
  SceneBake bake;                                 ///< its scene has no meshes any more, its meshes no files
  std::vector<std::filesystem::path> files;       ///< what was written or is up to date, the scene last; in a dry run the scene alone
  std::vector<std::filesystem::path> inputFiles;  ///< every file that decides what comes out, buffers of scenes included
  std::optional<Error> error;                     ///< with cannotWrite
};

struct JobOptions {
  BakeContext context;
  bool keepGoing = false;
  bool dryRun = false;         ///< reads inputs and looks into the cache, bakes and writes nothing; MeshBake::cached says what is there
  std::function<bool()> stop;  ///< may be left out: true asks to stop between steps
  std::function<void(const InputReport&)> read;  ///< may be left out: called in order when an input was read, or its notes were restored
  MeshDone lit;                                  ///< may be left out: called when a mesh got its apertures
};

/// Same files for any thread count, with and without a cache.
JobReport runJob(const BakeJob& job, const JobOptions& options);

}  // namespace overcast
