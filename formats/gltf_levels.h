// Levels of detail of a mesh in glTF: the mesh extension OVERCAST_levels (schema/OVERCAST_levels.schema.json), whose accessors hold what
// formats/terrain_levels.h describes. Internal to formats.
#pragma once

#include <string>

#include "formats/mesh.h"
#include "formats/result.h"

namespace tinygltf {
class Model;
}

namespace overcast {

inline constexpr int kLevelsVersion = 1;

/// Fills mesh.levels from the text of the extension. An Error whose place begins with `place` when a field or an accessor is wrong or does
/// not fit the mesh.
Result<Done> readGltfLevels(const tinygltf::Model& model, const std::string& text, const std::string& place, Mesh& mesh);

}  // namespace overcast
