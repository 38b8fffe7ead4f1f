// The bytes of a glTF 2.0 file as a tinygltf model: the container, the JSON and the buffers, nothing of their meaning yet.
// Internal to formats. Runs inside the sandbox.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/result.h"

namespace tinygltf {
class Model;
}

namespace overcast {

struct GltfModelDeleter {
  void operator()(tinygltf::Model* model) const;
};

/// A parsed model and what the user should know about it.
struct GltfDocument {
  std::unique_ptr<tinygltf::Model, GltfModelDeleter> model;  ///< never null; images and textures are left out unread
  std::vector<std::string> notes;
};

/// Reads .gltf or .glb (told apart by the first four bytes) and all buffers, each cut to its byteLength. Buffers may lie in the .glb, in
/// data URIs, or in files inside the asset's folder. An Error for anything but version 2.x, for required extensions that may change
/// geometry and are not supported, for compressed geometry without plain data, and for missing, short or outside buffers.
Result<GltfDocument> readGltfDocument(const std::filesystem::path& path);

/// Paths of the files that make the asset: `path`, its external buffers, the images of its skies. An Error for what is no JSON object and
/// for files outside the asset's folder.
Result<std::vector<std::string>> listGltfFiles(const std::filesystem::path& path);

}  // namespace overcast
