// RuntimeScene: a baked scene opened for playing: meshes on the device, local occluders, and what moves.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/asset.h"
#include "formats/scene.h"
#include "formats/sky.h"
#include "runtime/passes/geometry/geometry_pass.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// What hid the sky when the apertures of a mesh were baked.
enum class BakedAgainst {
  nothing,  ///< it has none
  itself,   ///< the mesh alone
  atRest,   ///< and all nodes that no animation moves, for those of its nodes that none moves
};

/// One mesh in the shared buffers. Vertices are stored relative to `centre`, so that single floats keep their detail.
struct SceneMesh {
  glm::dvec3 centre{0.0};           ///< local space
  std::vector<GeometryDraw> parts;  ///< indices, vertex offset and base colour; the instances are the frame's business
  std::uint32_t vertexCount = 0;
  BakedAgainst bakedAgainst = BakedAgainst::nothing;
  double apertureError = 0.0;      ///< of ambient visibility between vertices, as the bake measured it; 0 where it did not
  bool transfer = false;           ///< its vertices have transfer
  std::int32_t transferShift = 0;  ///< from the index of a vertex to that of its transfer
  /// Without triangles: these follow those of the only part. Chosen from for each frame (runtime/terrain_levels.h).
  std::optional<MeshLevels> levels;
};

/// One node with a mesh and an occluder.
struct SceneObject {
  std::uint32_t node = 0;
  std::uint32_t mesh = 0;
  std::uint32_t asset = 0;  ///< index into RuntimeScene::assets; nodes that name the same file or the same primitive share it
};

struct RuntimeScene {
  Scene scene;  ///< as read; its meshes' triangles and positions are freed once they are on the device
  Lighting lighting;
  Box bounds;  ///< world space, over the whole animation
  std::vector<SceneMesh> meshes;
  std::vector<Asset> assets;
  std::vector<SceneObject> objects;  ///< ordered by mesh, then by node
  GpuBuffer vertices;                ///< shared::kVertexFloats floats each
  GpuBuffer indices;                 ///< uint32
  /// The 8-byte packing of formats/shared/aperture.h for each vertex, or the texture coordinates of a mesh with a map; null where no
  /// mesh has apertures or a map. Meshes without see the whole hemisphere.
  GpuBuffer apertures;
  GpuBuffer transfers;                  ///< 9 floats for each vertex of meshes that have them; null where none has
  std::optional<SkyHarmonics> sky;      ///< of the lighting's sky image; none: Lighting::skyColour from everywhere
  std::vector<ApertureMapImages> maps;  ///< that GeometryDraw::map names; meshes that name the same file share it
};

inline bool hasApertures(const RuntimeScene& scene) {
  return scene.apertures.buffer != VK_NULL_HANDLE;
}
inline bool hasTransfer(const RuntimeScene& scene) {
  return scene.transfers.buffer != VK_NULL_HANDLE;
}

/// Reads a baked scene, its assets (content hashes checked) and puts its meshes on the device. Errors name the file: not a scene, a mesh
/// node without an occluder (the scene was not baked: says to run overcast-bake), an asset that is missing, changed or broken, a sky image
/// that is none, more geometry than the device can hold.
Result<RuntimeScene> loadScene(const Device& device, const std::filesystem::path& path);
void destroyScene(const Device& device, RuntimeScene& scene);

}  // namespace overcast
