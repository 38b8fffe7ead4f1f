#include "runtime/scene.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "formats/extension_json.h"
#include "runtime/passes/aperture/aperture.h"
#include "runtime/passes/shade/shade_pass.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

std::string nodePlace(const Scene& scene, std::size_t node) {
  const std::string& name = scene.nodes[node].name;
  return name.empty() ? fmt::format("nodes/{}", node) : fmt::format("node '{}'", name);
}

/// Equal exactly for occluders that share an asset.
std::string identity(const Occluder& occluder) {
  return occluder.primitive ? occluderJson(occluder) : occluder.uri;
}

/// The objects of the scene and the nodes whose assets they need, each once. Meshes without triangles are no objects.
Result<std::vector<std::uint32_t>> collectObjects(const fs::path& path, RuntimeScene& scene) {
  std::map<std::string, std::uint32_t> known;
  std::vector<std::uint32_t> assetNodes;
  for (std::size_t i = 0; i < scene.scene.nodes.size(); ++i) {
    const Node& node = scene.scene.nodes[i];
    if (node.mesh < 0 || scene.scene.meshes[static_cast<std::size_t>(node.mesh)].triangles.empty()) continue;
    if (!node.occluder)
      return Error{path.string(), nodePlace(scene.scene, i), "has a mesh but no occluder: bake the scene first with overcast-bake"};
    const auto [entry, fresh] = known.emplace(identity(*node.occluder), static_cast<std::uint32_t>(assetNodes.size()));
    if (fresh) assetNodes.push_back(static_cast<std::uint32_t>(i));
    scene.objects.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(node.mesh), entry->second});
  }
  std::stable_sort(scene.objects.begin(), scene.objects.end(), [](const auto& a, const auto& b) { return a.mesh < b.mesh; });
  return assetNodes;
}

/// The vertices and indices of all meshes that objects use.
struct Geometry {
  bool withApertures = false;
  std::vector<float> vertices;
  std::vector<std::uint64_t> apertures;
  std::vector<float> transfers;
  std::vector<std::uint32_t> indices;
};

/// Ambient visibility at a vertex of a mesh with apertures or transfer. The 4-byte packing has none: transfer knows it, else the cap's own
/// stands in.
float ambientAt(const VertexVisibility& visibility, std::size_t vertex, const glm::vec3& normal) {
  if (!visibility.ambient.empty()) return visibility.ambient[vertex];
  if (!visibility.transfer.empty()) return visibility.transfer[vertex][0] / shared::kSkyConstant;
  const Aperture& aperture = visibility.apertures[vertex];
  const glm::vec3 side = normal == glm::vec3(0.0f) ? aperture.direction : normal;
  return shared::capCosine(side, aperture.direction, aperture.radius) / shared::kCapPi;
}

/// Apertures of all vertices of a mesh, or their texture coordinates where it has a map; those without see the whole hemisphere.
void appendApertures(const Mesh& mesh, Geometry& geometry) {
  if (mesh.apertureMap) {
    for (const glm::vec2& c : mesh.textureCoordinates)
      geometry.apertures.push_back(std::bit_cast<std::uint32_t>(c.x) | std::uint64_t{std::bit_cast<std::uint32_t>(c.y)} << 32);
    return;
  }
  const VertexVisibility* visibility = mesh.visibility ? &*mesh.visibility : nullptr;
  const bool baked = visibility && !visibility->apertures.empty();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3 normal = mesh.normals.empty() ? glm::vec3(0.0f) : mesh.normals[i];
    const glm::vec3 axis = normal == glm::vec3(0.0f) ? glm::vec3(0, 1, 0) : normal;
    const Aperture aperture = baked ? visibility->apertures[i] : Aperture{axis, shared::kApertureWidest};
    const bool known = visibility && (baked || !visibility->transfer.empty());
    geometry.apertures.push_back(packAperture64(aperture, known ? ambientAt(*visibility, i, normal) : 1.0f));
  }
}

void appendTransfer(const Mesh& mesh, std::int32_t vertexOffset, Geometry& geometry, SceneMesh& out) {
  out.transfer = mesh.visibility && !mesh.visibility->transfer.empty();
  if (!out.transfer) return;
  out.transferShift = static_cast<std::int32_t>(geometry.transfers.size() / 9) - vertexOffset;
  for (const std::array<float, 9>& transfer : mesh.visibility->transfer)
    geometry.transfers.insert(geometry.transfers.end(), transfer.begin(), transfer.end());
}

/// What the cap's own ambient visibility errs where the packing has none (ambientAt), root mean square, about.
constexpr double kCapError = 0.05;

BakedAgainst bakedAgainst(const Mesh& mesh) {
  if (!mesh.apertureMap && !mesh.visibility) return BakedAgainst::nothing;
  const bool scene = (mesh.apertureBake && mesh.apertureBake->sceneOccludes) || (mesh.apertureMap && mesh.apertureMap->sceneOccludes);
  return scene ? BakedAgainst::atRest : BakedAgainst::itself;
}

void appendMesh(const Scene& scene, const Mesh& mesh, int map, Geometry& geometry, SceneMesh& out) {
  out.centre = centre(bounds(mesh));
  out.vertexCount = static_cast<std::uint32_t>(mesh.positions.size());
  out.bakedAgainst = bakedAgainst(mesh);
  if (mesh.apertureBake) out.apertureError = mesh.apertureBake->ambientError;
  const bool guessed = mesh.visibility && mesh.visibility->ambient.empty() && mesh.visibility->transfer.empty();
  if (guessed) out.apertureError = std::hypot(out.apertureError, kCapError);
  if (mesh.apertureMap) out.apertureError = std::max(mesh.apertureMap->ambientError, 0.0);
  const auto vertexOffset = static_cast<std::int32_t>(geometry.vertices.size() / shared::kVertexFloats);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3 position(mesh.positions[i] - out.centre);
    const glm::vec3 normal = mesh.normals.empty() ? glm::vec3(0.0f) : mesh.normals[i];
    geometry.vertices.insert(geometry.vertices.end(), {position.x, position.y, position.z, normal.x, normal.y, normal.z});
  }
  if (geometry.withApertures) appendApertures(mesh, geometry);
  appendTransfer(mesh, vertexOffset, geometry, out);
  for (const MeshPart& part : mesh.parts) {
    GeometryDraw draw;
    draw.firstIndex = static_cast<std::uint32_t>(geometry.indices.size() + std::size_t{3} * part.firstTriangle);
    draw.indexCount = 3 * part.triangleCount;
    draw.vertexOffset = vertexOffset;
    draw.map = map;
    draw.baseColour = part.material < 0 ? Material{}.baseColour : scene.materials[static_cast<std::size_t>(part.material)].baseColour;
    out.parts.push_back(draw);
  }
  if (mesh.levels) out.levels = MeshLevels{mesh.levels->groups, mesh.levels->clusters, {}};
  for (const glm::uvec3& triangle : mesh.triangles) geometry.indices.insert(geometry.indices.end(), {triangle.x, triangle.y, triangle.z});
  if (!mesh.levels) return;
  for (const glm::uvec3& triangle : mesh.levels->triangles)
    geometry.indices.insert(geometry.indices.end(), {triangle.x, triangle.y, triangle.z});
}

template <class T>
Result<Done> upload(const Device& device, const std::vector<T>& values, VkBufferUsageFlags usage, GpuBuffer& into) {
  const Result<GpuBuffer> made = makeBufferWith(device, std::as_bytes(std::span(values)), usage);
  if (!made) return made.error();
  into = made.value();
  return Done{};
}

/// Reads and uploads the aperture maps that meshes name, each once; [i]: the place of mesh i's, or -1.
Result<std::vector<int>> uploadMaps(const Device& device, const fs::path& path, RuntimeScene& scene) {
  std::map<std::string, int> known;
  std::vector<int> maps;
  for (const Mesh& mesh : scene.scene.meshes) {
    maps.push_back(-1);
    if (!mesh.apertureMap) continue;
    const auto [entry, fresh] = known.emplace(mesh.apertureMap->uri, static_cast<int>(scene.maps.size()));
    maps.back() = entry->second;
    if (!fresh) continue;
    const auto map = readApertureMap(path.parent_path(), *mesh.apertureMap);
    if (!map) return map.error();
    auto images = uploadApertureMap(device, map.value());
    if (!images) return Error{path.string(), mesh.apertureMap->uri, images.error().reason};
    scene.maps.push_back(std::move(images).value());
  }
  return maps;
}

Result<Done> uploadMeshes(const Device& device, const fs::path& path, RuntimeScene& scene) {
  const auto mapsOfMeshes = uploadMaps(device, path, scene);
  if (!mapsOfMeshes) return mapsOfMeshes.error();
  const std::vector<int>& maps = mapsOfMeshes.value();
  Geometry geometry;
  scene.meshes.resize(scene.scene.meshes.size());
  std::uint64_t vertexBytes = 0;
  std::uint64_t triangles = 0;
  std::uint64_t transferBytes = 0;
  std::vector<bool> used(scene.meshes.size(), false);
  for (const SceneObject& object : scene.objects) used[object.mesh] = true;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const std::optional<VertexVisibility>& visibility = scene.scene.meshes[i].visibility;
    const bool transfer = used[i] && visibility && !visibility->transfer.empty();
    vertexBytes += used[i] ? scene.scene.meshes[i].positions.size() * shared::kVertexFloats * sizeof(float) : 0;
    transferBytes += transfer ? scene.scene.meshes[i].positions.size() * sizeof(visibility->transfer[0]) : 0;
    triangles += used[i] ? scene.scene.meshes[i].triangles.size() : 0;
    if (const auto& levels = scene.scene.meshes[i].levels; used[i] && levels) triangles += levels->triangles.size();
    geometry.withApertures |=
        (used[i] && scene.scene.meshes[i].apertureMap) || transfer || (used[i] && visibility && !visibility->apertures.empty());
  }
  const std::uint64_t most = device.properties.limits.maxStorageBufferRange;
  if (std::max(vertexBytes, transferBytes) > most || triangles > UINT32_MAX / 3)
    return Error{path.string(), "",
                 fmt::format("{} bytes of vertices and {} triangles are more than {} can hold in one buffer ({} bytes)",
                             std::max(vertexBytes, transferBytes), triangles, device.info.name, most)};
  for (std::size_t i = 0; i < used.size(); ++i) {
    Mesh& mesh = scene.scene.meshes[i];
    if (used[i]) appendMesh(scene.scene, mesh, maps[i], geometry, scene.meshes[i]);
    mesh = Mesh{mesh.name, {}, {}, {}, {}, {}};
  }
  Result<Done> done = upload(device, geometry.vertices, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, scene.vertices);
  if (done) done = upload(device, geometry.indices, VK_BUFFER_USAGE_INDEX_BUFFER_BIT, scene.indices);
  if (done && geometry.withApertures) done = upload(device, geometry.apertures, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, scene.apertures);
  if (done && !geometry.transfers.empty()) done = upload(device, geometry.transfers, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, scene.transfers);
  return done;
}

Result<Done> fillScene(const Device& device, const fs::path& path, RuntimeScene& scene) {
  if (isMeshFile(path)) return Error{path.string(), "", "is a mesh, not a baked scene: run overcast-bake on it first"};
  Result<Scene> read = readScene(path);
  if (!read) return read.error();
  scene.scene = std::move(read).value();
  scene.lighting = scene.scene.lighting.value_or(Lighting{});
  const Result<SkyEstimator> known = skyEstimator(scene.lighting.estimator, scene.lighting.globalVolume.resolution);
  if (!known) return Error{path.string(), known.error().place, known.error().reason};
  constexpr std::size_t kMostAreaLights = shared::kMaxApertureLights - 1;
  if (const std::size_t lights = scene.lighting.areaLights.size(); lights > kMostAreaLights)
    return Error{path.string(), "areaLights", fmt::format("{} area lights are more than {}", lights, kMostAreaLights)};
  if (!scene.lighting.skyImage.empty()) {
    const Result<fs::path> image = skyFile(path.parent_path(), scene.lighting.skyImage);
    if (!image) return image.error();
    const Result<SkyHarmonics> sky = readSky(image.value());
    if (!sky) return sky.error();
    scene.sky = sky.value();
  }
  scene.bounds = worldBounds(scene.scene);
  const Result<std::vector<std::uint32_t>> assetNodes = collectObjects(path, scene);
  if (!assetNodes) return assetNodes.error();
  if (scene.objects.empty()) return Error{path.string(), "", "there is no mesh to show"};
  for (const std::uint32_t node : assetNodes.value()) {
    Result<Asset> asset = readAsset(path.parent_path(), *scene.scene.nodes[node].occluder);
    if (!asset) return asset.error();
    scene.assets.push_back(std::move(asset).value());
  }
  return uploadMeshes(device, path, scene);
}

}  // namespace

Result<RuntimeScene> loadScene(const Device& device, const std::filesystem::path& path) {
  RuntimeScene scene;
  const Result<Done> filled = fillScene(device, path, scene);
  if (!filled) {
    destroyScene(device, scene);
    return filled.error();
  }
  return scene;
}

void destroyScene(const Device& device, RuntimeScene& scene) {
  destroyBuffer(device, scene.vertices);
  destroyBuffer(device, scene.indices);
  destroyBuffer(device, scene.apertures);
  destroyBuffer(device, scene.transfers);
  for (ApertureMapImages& map : scene.maps) destroyApertureMap(device, map);
  scene = {};
}

}  // namespace overcast
