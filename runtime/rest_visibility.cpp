#include "runtime/rest_visibility.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "runtime/passes/shade/sky_points_pass.h"
#include "runtime/rest_fit.h"
#include "runtime/rest_window.h"

namespace overcast {
namespace {

/// Edges of triangles longer than this, in voxels, have points between their vertices looked at.
constexpr float kLongestEdge = 2.0f;
/// What apertures may err between vertices, root mean square, to count as known everywhere.
constexpr double kFine = 0.02;
/// By what share of the larger the squared sizes of objects may differ that take each other's values.
constexpr double kAlike = 0.2;
/// Signed distance in voxels, a voxel above a surface, below which it lies within another object.
constexpr float kBuried = -0.25f;

/// A volume, and what looks at points of it.
struct Viewed {
  RestVolume volume;
  SkyPointsPass points;
};

/// All that the job reads.
struct Job {
  const Device& device;
  const RuntimeScene& scene;
  const AssetStore& store;
  const GlobalGrid& grid;
  const SkyEstimator& estimator;
  std::vector<Viewed> volumes;    ///< one for each size of a grid that was asked for
  std::vector<glm::dmat4> nodes;  ///< worldFromLocal at rest
  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
};

/// A placed mesh in voxels of the volume.
struct PlacedMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;
  std::vector<glm::uvec3> triangles;
};

glm::vec3 unitOr(const glm::vec3& v, const glm::vec3& other) {
  const float length = glm::length(v);
  return length > 0.0f && length < 1e30f ? v / length : other;
}

PlacedMesh placed(const Job& job, const GlobalGrid& grid, const SceneObject& object) {
  const SceneMesh& mesh = job.scene.meshes[object.mesh];
  const glm::dmat4 voxelFromLocal = voxelFromWorld(grid) * job.nodes[object.node];
  const shared::GeometryInstance axes = geometryInstance(job.nodes[object.node], glm::dvec3(0.0));
  PlacedMesh result;
  const float* vertex = job.vertices.data() + static_cast<std::size_t>(mesh.parts.front().vertexOffset) * shared::kVertexFloats;
  for (std::uint32_t v = 0; v < mesh.vertexCount; ++v, vertex += shared::kVertexFloats) {
    const glm::vec3 normal(vertex[3], vertex[4], vertex[5]);
    result.positions.emplace_back(voxelFromLocal * glm::dvec4(mesh.centre + glm::dvec3(vertex[0], vertex[1], vertex[2]), 1.0));
    const glm::vec3 turned(glm::dot(glm::vec3(axes.normalX), normal), glm::dot(glm::vec3(axes.normalY), normal),
                           glm::dot(glm::vec3(axes.normalZ), normal));
    result.normals.push_back(unitOr(turned, job.scene.lighting.up));
  }
  for (const GeometryDraw& part : mesh.parts)
    for (std::uint32_t i = part.firstIndex; i + 2 < part.firstIndex + part.indexCount; i += 3)
      result.triangles.emplace_back(job.indices[i], job.indices[i + 1], job.indices[i + 2]);
  return result;
}

/// What the estimator says at the vertices of an object in the volume as it is.
Result<std::vector<float>> valuesOf(const Job& job, const Viewed& viewed, const SceneObject& object) {
  const PlacedMesh mesh = placed(job, viewed.volume.composite.grid, object);
  std::vector<shared::SkyPoint> points;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    points.push_back({glm::vec4(mesh.positions[v], 1.0f), glm::vec4(mesh.normals[v], 0.0f)});
  std::vector<SurfaceSpot> spots = spotsOver(mesh.positions, mesh.triangles, kLongestEdge);
  for (const SurfaceSpot& spot : spots) {
    glm::vec3 place(0.0f), normal(0.0f);
    for (int c = 0; c < 3; ++c) {
      place += spot.weight[c] * mesh.positions[spot.corner[c]];
      normal += spot.weight[c] * mesh.normals[spot.corner[c]];
    }
    points.push_back({glm::vec4(place, 1.0f), glm::vec4(unitOr(normal, mesh.normals[spot.corner.x]), 0.0f)});
  }
  const auto seen = seenAt(job.device, viewed.points, points, job.scene.lighting.up);
  if (!seen) return seen.error();
  std::vector<float> atVertices, atSpots;
  for (std::size_t i = 0; i < points.size(); ++i) (i < mesh.positions.size() ? atVertices : atSpots).push_back(seen.value()[i].visibility);
  for (std::size_t s = 0; s < spots.size(); ++s)
    if (seen.value()[mesh.positions.size() + s].above < kBuried) spots[s].area = 0.0f;
  return fittedTo(std::move(atVertices), spots, atSpots);
}

void destroyViewed(const Device& device, Viewed& viewed) {
  destroySkyPointsPass(device, viewed.points);
  destroyPyramidPass(device, viewed.volume.pyramid);
  destroyCompositePass(device, viewed.volume.composite);
}

Result<Done> makeViewed(const Job& job, const GlobalGrid& grid, Viewed& viewed) {
  Result<CompositePass> composite = makeCompositePass(job.device, grid, job.store, static_cast<std::uint32_t>(job.scene.objects.size()));
  if (!composite) return composite.error();
  viewed.volume.composite = std::move(composite).value();
  Result<PyramidPass> pyramid = makePyramidPass(job.device, viewed.volume.composite.volume, job.estimator.levels);
  if (!pyramid) return pyramid.error();
  viewed.volume.pyramid = std::move(pyramid).value();
  Result<SkyPointsPass> points = makeSkyPointsPass(job.device, viewed.volume.pyramid, job.estimator);
  if (!points) return points.error();
  viewed.points = std::move(points).value();
  return Done{};
}

/// The volume of `grid`'s size, moved to where `grid` is, made where there is none yet. Good until the next call. Null: `done` says why.
Viewed* volumeFor(Job& job, const GlobalGrid& grid, Result<Done>& done) {
  auto found = std::find_if(job.volumes.begin(), job.volumes.end(),
                            [&](const Viewed& viewed) { return viewed.volume.composite.grid.size == grid.size; });
  if (found == job.volumes.end()) {
    done = makeViewed(job, grid, job.volumes.emplace_back());
    found = job.volumes.end() - 1;
  }
  found->volume.composite.grid = grid;
  return done ? &*found : nullptr;
}

Result<Done> composite(const Job& job, RestVolume& volume, std::span<const shared::CompositeObject> occluders) {
  return runCommands(job.device, [&](VkCommandBuffer commands) {
    if (recordComposite(commands, volume.composite, occluders)) recordPyramid(commands, volume.pyramid);
  });
}

shared::CompositeObject occluderOf(const Job& job, const SceneObject& object, const GlobalGrid& grid) {
  return compositeObject(job.store.entries[object.asset], job.nodes[object.node], grid);
}

bool isFine(const SceneMesh& mesh) {
  return mesh.apertureError <= kFine;
}

/// Where the visibility of an object at rest comes from.
enum class RestKind {
  none,       ///< it has no apertures
  unchanged,  ///< nothing can change
  volume,     ///< looked up in the volume at rest
  vertices,   ///< at its vertices, among all that rests
  alone,      ///< at its vertices, alone
};

struct Kinds {
  std::vector<RestKind> of;  ///< objects
  std::vector<char> moving;  ///< nodes
};

Kinds kindsOf(const RuntimeScene& scene) {
  Kinds kinds{{}, movingNodes(scene.scene)};
  const bool still =
      std::none_of(scene.objects.begin(), scene.objects.end(), [&](const auto& object) { return kinds.moving[object.node]; });
  for (const SceneObject& object : scene.objects) {
    const SceneMesh& mesh = scene.meshes[object.mesh];
    if (mesh.bakedAgainst == BakedAgainst::nothing)
      kinds.of.push_back(RestKind::none);
    else if (mesh.bakedAgainst == BakedAgainst::itself || kinds.moving[object.node])
      kinds.of.push_back(RestKind::alone);
    else if (!isFine(mesh))
      kinds.of.push_back(RestKind::vertices);
    else
      kinds.of.push_back(still ? RestKind::unchanged : RestKind::volume);
  }
  return kinds;
}

bool has(const Kinds& kinds, RestKind kind) {
  return std::find(kinds.of.begin(), kinds.of.end(), kind) != kinds.of.end();
}

/// Whether objects of one mesh, each alone, are about as large: they then look alike to what sees the same wherever they stand and however
/// they are turned.
bool standAlike(const glm::dmat3& a, const glm::dmat3& b) {
  const glm::dmat3 sizes = glm::transpose(a) * a, others = glm::transpose(b) * b;
  double most = 0.0, apart = 0.0;
  for (int c = 0; c < 3; ++c) {
    most = std::max(most, sizes[c][c]);
    for (int r = 0; r < 3; ++r) apart = std::max(apart, std::abs(sizes[c][r] - others[c][r]));
  }
  return apart <= kAlike * most;
}

/// Whether what the estimator says depends on where an object stands: taps up to the border of the volume are further apart where that is
/// farther away.
bool reachesBorder(const SkyEstimator& estimator) {
  return !estimator.steps.empty();
}

/// By object: the first alone of the same mesh that stands alike, or itself.
std::vector<std::size_t> firstAlike(const Job& job, const Kinds& kinds) {
  const std::vector<SceneObject>& objects = job.scene.objects;
  std::vector<std::size_t> first(objects.size()), found;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    first[i] = i;
    if (kinds.of[i] != RestKind::alone || reachesBorder(job.estimator)) continue;
    const auto alike = std::find_if(found.begin(), found.end(), [&](std::size_t j) {
      return objects[j].mesh == objects[i].mesh && objects[j].asset == objects[i].asset &&
             standAlike(glm::dmat3(job.nodes[objects[j].node]), glm::dmat3(job.nodes[objects[i].node]));
    });
    if (alike == found.end())
      found.push_back(i);
    else
      first[i] = *alike;
  }
  return first;
}

/// Values of an object alone. What only rays look at needs no more of the volume than its surroundings.
Result<std::vector<float>> valuesAlone(Job& job, const SceneObject& object) {
  const shared::CompositeObject inWhole = occluderOf(job, object, job.grid);
  const GlobalGrid grid = job.estimator.traced > 0 && inWhole.present != 0 ? windowAbout(job.grid, inWhole) : job.grid;
  Result<Done> done = Done{};
  Viewed* viewed = volumeFor(job, grid, done);
  if (done) {
    const std::array alone{occluderOf(job, object, grid)};
    done = composite(job, viewed->volume, alone);
  }
  if (!done) return done.error();
  return valuesOf(job, *viewed, object);
}

/// Composites all that rests into the whole volume.
Result<Done> compositeAll(Job& job, const Kinds& kinds) {
  std::vector<shared::CompositeObject> occluders;
  for (const SceneObject& object : job.scene.objects)
    occluders.push_back(kinds.moving[object.node] ? shared::CompositeObject{} : occluderOf(job, object, job.grid));
  Result<Done> done = Done{};
  Viewed* whole = volumeFor(job, job.grid, done);
  return done ? composite(job, whole->volume, occluders) : done;
}

/// Values of all vertices of the objects that have their own; afterwards the whole volume holds all that rests, where anyone asks for that.
Result<std::vector<std::vector<float>>> restValues(Job& job, const Kinds& kinds, const std::vector<std::size_t>& first) {
  const std::vector<SceneObject>& objects = job.scene.objects;
  std::vector<std::vector<float>> values(objects.size());
  Result<Done> done = Done{};
  const auto keep = [&](std::size_t i, Result<std::vector<float>> seen) {
    if (!seen)
      done = seen.error();
    else
      values[i] = std::move(seen).value();
  };
  for (std::size_t i = 0; i < objects.size() && done; ++i)
    if (kinds.of[i] == RestKind::alone && first[i] == i) keep(i, valuesAlone(job, objects[i]));
  if (done && (has(kinds, RestKind::vertices) || has(kinds, RestKind::volume))) done = compositeAll(job, kinds);
  for (std::size_t i = 0; i < objects.size() && done; ++i)
    if (kinds.of[i] == RestKind::vertices) keep(i, valuesOf(job, *volumeFor(job, job.grid, done), objects[i]));
  if (!done) return done.error();
  return values;
}

/// Of two estimates with independent errors the best mean weighs them by what the other errs, squared.
float trustIn(const SceneMesh& mesh, RestKind kind, double error) {
  if (kind == RestKind::none) return 0.0f;
  if (kind == RestKind::unchanged) return 2.0f * shared::kTrustBeyond;
  if (kind == RestKind::volume) return shared::kTrustBeyond;
  const double squared = error * error;
  const auto share = static_cast<float>(squared / (squared + mesh.apertureError * mesh.apertureError));
  return kind == RestKind::vertices ? shared::knowingTrust(share) : share;
}

Result<Done> upload(const Job& job, const Kinds& kinds, const std::vector<std::vector<float>>& values,
                    const std::vector<std::size_t>& first, RestBuffers& rest) {
  std::vector<float> all{1.0f};
  std::vector<shared::RestInstance> instances;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const SceneMesh& mesh = job.scene.meshes[job.scene.objects[i].mesh];
    std::int32_t shift =
        values[i].empty() ? shared::kNoRestValues : static_cast<std::int32_t>(all.size()) - mesh.parts.front().vertexOffset;
    if (first[i] != i) shift = instances[first[i]].shift;
    instances.push_back({shift, trustIn(mesh, kinds.of[i], job.estimator.error)});
    all.insert(all.end(), values[i].begin(), values[i].end());
  }
  if (const std::uint64_t most = job.device.properties.limits.maxStorageBufferRange; all.size() * sizeof(float) > most)
    return Error{"", "",
                 fmt::format("{} vertices of {} objects are more than the device can hold in one buffer", all.size(), values.size())};
  const auto storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  const Result<GpuBuffer> made = makeBufferWith(job.device, std::as_bytes(std::span(all)), storage);
  if (!made) return made.error();
  rest.values = made.value();
  const Result<GpuBuffer> places = makeBufferWith(job.device, std::as_bytes(std::span(instances)), storage);
  if (!places) return places.error();
  rest.instances = places.value();
  return Done{};
}

Result<Done> fill(Job& job, const Kinds& kinds, RestBuffers& rest) {
  Result<std::vector<float>> vertices = readValues<float>(job.device, job.scene.vertices);
  if (!vertices) return vertices.error();
  job.vertices = std::move(vertices).value();
  Result<std::vector<std::uint32_t>> indices = readValues<std::uint32_t>(job.device, job.scene.indices);
  if (!indices) return indices.error();
  job.indices = std::move(indices).value();
  const std::vector<std::size_t> first = firstAlike(job, kinds);
  const auto values = restValues(job, kinds, first);
  if (!values) return values.error();
  return upload(job, kinds, values.value(), first, rest);
}

}  // namespace

bool canChange(const RuntimeScene& scene) {
  if (scene.objects.size() < 2) return false;
  const std::vector<RestKind> kinds = kindsOf(scene).of;
  return std::any_of(kinds.begin(), kinds.end(), [](RestKind kind) { return kind != RestKind::unchanged; });
}

Result<RestVisibility> makeRestVisibility(const Device& device, const RuntimeScene& scene, const AssetStore& store, const GlobalGrid& grid,
                                          const SkyEstimator& estimator) {
  const Kinds kinds = kindsOf(scene);
  RestVisibility rest;
  Job job{device, scene, store, grid, estimator, {}, worldFromLocal(scene.scene, 0.0), {}, {}};
  const Result<Done> filled = fill(job, kinds, rest.buffers);
  for (Viewed& viewed : job.volumes) {
    if (filled && has(kinds, RestKind::volume) && viewed.volume.composite.grid.size == grid.size)
      rest.volume = std::exchange(viewed.volume, {});
    destroyViewed(device, viewed);
  }
  if (filled) return rest;
  destroyRestVisibility(device, rest);
  return filled.error();
}

void destroyRestVisibility(const Device& device, RestVisibility& rest) {
  destroyBuffer(device, rest.buffers.values);
  destroyBuffer(device, rest.buffers.instances);
  if (!rest.volume) return;
  destroyPyramidPass(device, rest.volume->pyramid);
  destroyCompositePass(device, rest.volume->composite);
  rest.volume.reset();
}

}  // namespace overcast
