// Bake record: what the cache keeps of a baked mesh and of a whole scene, and how both come back. A result that comes back is the one that
// was stored to the last bit, its measured errors and notes included.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bake/cache.h"
#include "bake/mesh_bake.h"

namespace overcast {

/// One file that a bake wrote.
struct OutputFile {
  std::string path;  ///< below the output folder, with forward slashes
  std::string hash;  ///< contentHash
  std::uint64_t bytes = 0;
};

/// A scene without what only other files need: no geometry, no contents of files.
struct SceneRecord {
  std::vector<std::vector<std::string>> notes;  ///< of each input
  std::vector<MeshBake> meshes;
  std::vector<OutputFile> files;  ///< in the order they were written: the scene last
};

/// Fills `job` from the cache as bakeMesh would; false when it is not there. `job.hash` says which one.
bool restoreMesh(Cache& cache, MeshBake& job);
void keepMesh(Cache& cache, const MeshBake& job);

/// What is kept of the scene under this key, when it is.
std::optional<SceneRecord> findScene(Cache& cache, const std::string& key);
/// Keeps the record and the contents of its files, which lie in `folder`. A file that is no longer what the record says is not kept, and
/// then neither is the record.
void keepScene(Cache& cache, const std::string& key, const SceneRecord& record, const std::filesystem::path& folder);

/// What became of outputs that a record names.
enum class Restored {
  missing,   ///< not all of them could be had: the scene has to be baked
  intact,    ///< all lay in the folder as they should
  rewritten  ///< some were written from the cache
};

/// Makes the files of the record lie in `folder`, the scene last, and gives the scene file the time of now, so that make sees that it was
/// looked at. An Error when the folder cannot be written. `dryRun` only looks.
Result<Restored> restoreScene(Cache& cache, const SceneRecord& record, const std::filesystem::path& folder, bool dryRun);

/// Size and hash of files that lie in `folder`. An Error when one cannot be read.
Result<std::vector<OutputFile>> describeFiles(const std::vector<std::filesystem::path>& files, const std::filesystem::path& folder);

}  // namespace overcast
