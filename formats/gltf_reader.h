// From a parsed glTF to a Scene. Internal to formats: readScene runs this inside the sandbox, the fuzzer runs it bare.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "formats/result.h"
#include "formats/scene.h"

namespace tinygltf {
class Model;
}

namespace overcast {

/// What was left out, counted by kind so that a file with a thousand bad things gives one line and not a thousand.
using Tally = std::map<std::string, std::uint64_t>;

/// Reads the file as readScene promises, in this process. Errors name the file.
Result<Scene> readGltfScene(const std::filesystem::path& path);

/// Triangles of one glTF mesh with the texture coordinates TEXCOORD_<texCoord>; its primitives become parts. No triangles at all is no
/// error. Leaves out Mesh::apertureMap.
Result<Mesh> readGltfMesh(const tinygltf::Model& model, int mesh, int texCoord, Tally& tally);

/// Animations of the nodes that `newIndex` keeps (old node index to new, -1: dropped). Channels of unknown or broken kinds are left out.
Result<std::vector<Animation>> readGltfAnimations(const tinygltf::Model& model, const std::vector<int>& newIndex,
                                                  const std::vector<Node>& nodes, Tally& tally);

}  // namespace overcast
