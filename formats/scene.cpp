#include "formats/scene.h"

#include <algorithm>
#include <cmath>

#include "formats/archive.h"
#include "formats/gltf_document.h"
#include "formats/gltf_reader.h"
#include "formats/sandbox.h"
#include "formats/scene_bytes.h"

namespace overcast {
namespace {

/// Beyond this many diagonals from the origin a single float loses detail that a 256^3 volume could still show.
constexpr double kFarInDiagonals = 64.0;

}  // namespace

bool isSceneFile(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension == ".gltf" || extension == ".glb";
}

Result<Scene> readScene(const std::filesystem::path& path) {
  auto bytes = runSandboxed(path, SandboxLimits{}, [&]() -> Result<std::vector<std::byte>> {
    auto scene = readGltfScene(path);
    if (!scene) return scene.error();
    return packScene(scene.value());
  });
  if (!bytes) return bytes.error();
  auto scene = unpackScene(bytes.value());
  if (!scene) return Error{path.string(), "", "reader returned a damaged scene"};
  return std::move(*scene);
}

Result<std::vector<std::filesystem::path>> sceneFiles(const std::filesystem::path& path) {
  auto bytes = runSandboxed(path, SandboxLimits{}, [&]() -> Result<std::vector<std::byte>> {
    const auto files = listGltfFiles(path);
    if (!files) return files.error();
    return archived(files.value());
  });
  if (!bytes) return bytes.error();
  const auto names = unarchived<std::vector<std::string>>(bytes.value());
  if (!names) return Error{path.string(), "", "reader returned a damaged list of files"};
  return std::vector<std::filesystem::path>(names->begin(), names->end());
}

Scene sceneFromMesh(Mesh mesh) {
  Scene scene;
  scene.name = mesh.name;
  Node node;
  node.name = mesh.name;
  node.mesh = 0;
  const Box box = bounds(mesh);
  const glm::dvec3 middle = centre(box);
  if (!isEmpty(box) && glm::length(middle) > kFarInDiagonals * diagonal(box)) {
    for (glm::dvec3& position : mesh.positions) position -= middle;
    node.translation = middle;
  }
  if (mesh.parts.empty() && !mesh.triangles.empty()) mesh.parts.push_back({0, static_cast<std::uint32_t>(mesh.triangles.size()), 0});
  for (MeshPart& part : mesh.parts) part.material = 0;
  scene.materials.push_back({"default", Material{}.baseColour});
  scene.meshes.push_back(std::move(mesh));
  scene.nodes.push_back(std::move(node));
  return scene;
}

}  // namespace overcast
