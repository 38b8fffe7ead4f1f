// Validate: everything that can be checked about a baked scene or a volume without the meshes it came from.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/result.h"

namespace overcast {

/// One line per finding, each naming node and file; empty when all is well. Looks at every mesh node's occluder: its file (a primitive has
/// none) is there, inside the folder, has the stored size and hash, opens, agrees in bounds and sign method, is no steeper than the stored
/// Lipschitz bound; errors are finite; the mesh lies inside the bounds. Aperture maps and a sky image are there and are such. A .vdb alone
/// is only opened. An Error when `path` itself cannot be read.
Result<std::vector<std::string>> validate(const std::filesystem::path& path);

}  // namespace overcast
