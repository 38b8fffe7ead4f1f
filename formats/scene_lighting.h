// Scene lighting: changing what a scene on disk says about its lighting, and nothing else in it.
#pragma once

#include <filesystem>

#include "formats/lighting.h"
#include "formats/result.h"

namespace overcast {

/// Puts `lighting` in the place of the OVERCAST_lighting of the default scene of `path` (.gltf), atomically; every other value stays as it
/// is. An Error when the file is no glTF JSON, is a .glb, has no such extension, or cannot be written (its `file` is then `path` too).
Result<Done> replaceLighting(const std::filesystem::path& path, const Lighting& lighting);

}  // namespace overcast
