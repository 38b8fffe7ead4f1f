// Mesh files: what the tables read.
#pragma once

#include <algorithm>
#include <filesystem>
#include <vector>

#include "formats/mesh.h"

namespace overcast::bench {

/// The files of a folder that readMesh knows, by name.
inline std::vector<std::filesystem::path> meshFiles(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file() && isMeshFile(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace overcast::bench
