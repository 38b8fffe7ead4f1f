#include "runtime/passes/surfels/surfel_pass.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <map>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "runtime/passes/surfels/surfel_tree.h"

namespace overcast {

using shared::Surfel;
using shared::SurfelObject;

static_assert(sizeof(Surfel) == 48 && offsetof(Surfel, albedo) == 32);
static_assert(sizeof(SurfelObject) == 112 && offsetof(SurfelObject, areaX) == 48 && offsetof(SurfelObject, nodes) == 96);
static_assert(sizeof(shared::SurfelPush) == 96 && offsetof(shared::SurfelPush, counts) == 80);

namespace {

/// Matrix of cofactors: takes area times normal along.
glm::dmat3 cofactors(const glm::dmat3& m) {
  return glm::dmat3(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
}

double largestScale(const glm::dmat3& m) {
  return std::sqrt(std::max({glm::dot(m[0], m[0]), glm::dot(m[1], m[1]), glm::dot(m[2], m[2])}));
}

/// The meshes' vertices and indices, back from the device.
struct Geometry {
  std::vector<float> vertices;
  std::vector<std::uint32_t> indices;
};

std::vector<Surfel> treeOf(const SceneMesh& mesh, const Geometry& geometry, double longestEdge) {
  std::vector<DiscTriangle> triangles;
  std::uint32_t count = 0;
  for (const GeometryDraw& part : mesh.parts)
    for (std::uint32_t i = 0; i + 2 < part.indexCount; i += 3) {
      const std::uint32_t* corner = geometry.indices.data() + part.firstIndex + i;
      triangles.push_back({{corner[0], corner[1], corner[2]}, glm::vec3(part.baseColour)});
      count = std::max({count, corner[0] + 1, corner[1] + 1, corner[2] + 1});
    }
  std::vector<glm::vec3> positions, normals;
  for (std::uint32_t i = 0; i < count; ++i) {
    const float* v = geometry.vertices.data() +
                     static_cast<std::size_t>(mesh.parts[0].vertexOffset + static_cast<std::int32_t>(i)) * shared::kVertexFloats;
    positions.emplace_back(v[0], v[1], v[2]);
    normals.emplace_back(v[3], v[4], v[5]);
  }
  return surfelTree(discsOf(positions, normals, triangles, longestEdge), kMostSurfels);
}

/// Fills pass.records and the counts; the nodes of all trees.
Result<std::vector<Surfel>> buildTrees(const Device& device, const RuntimeScene& scene, SurfelPass& pass) {
  Geometry geometry;
  Result<std::vector<float>> vertices = readValues<float>(device, scene.vertices);
  if (!vertices) return vertices.error();
  geometry.vertices = std::move(vertices).value();
  Result<std::vector<std::uint32_t>> indices = readValues<std::uint32_t>(device, scene.indices);
  if (!indices) return indices.error();
  geometry.indices = std::move(indices).value();
  const std::vector<glm::dmat4> nodes = worldFromLocal(scene.scene, 0.0);
  std::map<std::uint32_t, double> scales;
  for (const SceneObject& object : scene.objects) {
    double& scale = scales[object.mesh];
    scale = std::max(scale, largestScale(glm::dmat3(nodes[object.node])));
  }
  const glm::dvec3 sides = extent(scene.bounds);
  const double edge = std::max(kSurfelEdgeShare * std::max({sides.x, sides.y, sides.z}), 1e-30);
  std::map<std::uint32_t, glm::ivec2> runs;
  std::vector<Surfel> all;
  for (const auto& [mesh, scale] : scales) {
    const std::vector<Surfel> tree = treeOf(scene.meshes[mesh], geometry, edge / std::max(scale, 1e-30));
    runs[mesh] = {static_cast<int>(all.size()), static_cast<int>(tree.size())};
    all.insert(all.end(), tree.begin(), tree.end());
  }
  for (const SceneObject& object : scene.objects) {
    const glm::ivec2 run = runs[object.mesh];
    SurfelObject record{};
    record.nodes = glm::ivec4(run, static_cast<int>(pass.placedCount), 0);
    pass.records.push_back(record);
    pass.placedCount += static_cast<std::uint32_t>(run.y);
    pass.largestTree = std::max(pass.largestTree, static_cast<std::uint32_t>(run.y));
  }
  return all;
}

Result<Done> makeBuffers(const Device& device, const std::vector<Surfel>& nodes, SurfelPass& pass) {
  // Indices travel as floats: exact to 2^24.
  const std::uint64_t most = std::min<std::uint64_t>(device.properties.limits.maxStorageBufferRange / sizeof(Surfel), 1u << 24);
  if (pass.placedCount > most || pass.records.size() > device.properties.limits.maxComputeWorkGroupCount[1])
    return Error{"", "", fmt::format("{} surfels of {} objects are more than the device can hold", pass.placedCount, pass.records.size())};
  const auto storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  const Result<GpuBuffer> trees = nodes.empty() ? makeBuffer(device, sizeof(Surfel), storage, MemoryUse::device)
                                                : makeBufferWith(device, std::as_bytes(std::span(nodes)), storage);
  if (!trees) return trees.error();
  pass.nodes = trees.value();
  const std::size_t count = std::max(pass.placedCount, 1u);
  const Result<GpuBuffer> objects =
      makeBuffer(device, std::max<std::size_t>(pass.records.size(), 1) * sizeof(SurfelObject), storage, MemoryUse::upload);
  if (!objects) return objects.error();
  pass.objects = objects.value();
  const Result<GpuBuffer> placed = makeBuffer(device, count * sizeof(Surfel), storage, MemoryUse::device);
  if (!placed) return placed.error();
  pass.placed = placed.value();
  const Result<GpuBuffer> lights = makeBuffer(device, count * sizeof(glm::vec4), storage, MemoryUse::device);
  if (!lights) return lights.error();
  pass.lights = lights.value();
  return Done{};
}

struct Stage {
  Shader shader;
  std::vector<std::pair<std::uint32_t, const GpuBuffer*>> buffers;
  std::uint32_t pushBytes = 0;
};

Result<Done> makeStage(const Device& device, const Stage& stage, Pipeline& pipeline, DescriptorSet& set) {
  std::vector<Binding> bindings;
  for (const auto& [binding, buffer] : stage.buffers) bindings.push_back({binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  Result<Pipeline> made = makeComputePipeline(device, {stage.shader, bindings, stage.pushBytes});
  if (!made) return made.error();
  pipeline = std::move(made).value();
  Result<DescriptorSet> descriptors = makeDescriptorSet(device, pipeline);
  if (!descriptors) return descriptors.error();
  set = std::move(descriptors).value();
  for (const auto& [binding, buffer] : stage.buffers) writeBuffer(device, set, binding, *buffer);
  return Done{};
}

Result<Done> fill(const Device& device, const RuntimeScene& scene, SurfelPass& pass) {
  const Result<std::vector<Surfel>> nodes = buildTrees(device, scene, pass);
  if (!nodes) return nodes.error();
  Result<Done> done = makeBuffers(device, nodes.value(), pass);
  const std::string folder = "runtime/passes/surfels/";
  const auto gather = [&](const char* which) {
    return Stage{{folder + "surfel_gather.comp.glsl", {{"OVERCAST_SURFEL_GATHER", which}}},
                 {{4, &pass.placed}, {5, &pass.lights}},
                 sizeof(shared::SurfelPush)};
  };
  const Stage place{{folder + "surfel_place.comp.glsl", {}}, {{0, &pass.nodes}, {1, &pass.objects}, {4, &pass.placed}}, 0};
  if (done) done = makeStage(device, place, pass.place, pass.placeSet);
  if (done) done = makeStage(device, gather("1"), pass.access, pass.accessSet);
  if (done) done = makeStage(device, gather("2"), pass.bounce, pass.bounceSet);
  return done;
}

}  // namespace

Result<SurfelPass> makeSurfelPass(const Device& device, const RuntimeScene& scene, double nearness) {
  SurfelPass pass;
  pass.nearness = nearness;
  const Result<Done> filled = fill(device, scene, pass);
  if (filled) return pass;
  destroySurfelPass(device, pass);
  return filled.error();
}

void destroySurfelPass(const Device& device, SurfelPass& pass) {
  for (DescriptorSet* set : {&pass.placeSet, &pass.accessSet, &pass.bounceSet}) destroyDescriptorSet(device, *set);
  for (Pipeline* pipeline : {&pass.place, &pass.access, &pass.bounce}) destroyPipeline(device, *pipeline);
  for (GpuBuffer* buffer : {&pass.nodes, &pass.objects, &pass.placed, &pass.lights}) destroyBuffer(device, *buffer);
  pass = {};
}

shared::SurfelPush surfelPush(std::uint32_t placed, double nearness, const glm::mat4& relativeFromClip, const glm::vec3& skyColour) {
  return {relativeFromClip, glm::vec4(skyColour, nearness * nearness), glm::ivec4(static_cast<int>(placed), 0, 0, 0)};
}

void recordSurfels(VkCommandBuffer commands, SurfelPass& pass, std::span<const glm::dmat4> worldFromCentre, const glm::dvec3& eye,
                   const glm::vec3& skyColour) {
  OVERCAST_REQUIRE(worldFromCentre.size() == pass.records.size(), "{} placements of {} objects", worldFromCentre.size(),
                   pass.records.size());
  if (pass.placedCount == 0) return;
  for (std::size_t i = 0; i < pass.records.size(); ++i) {
    const glm::dmat3 linear(worldFromCentre[i]);
    const glm::dmat3 area = cofactors(linear) * (glm::dot(linear[0], glm::cross(linear[1], linear[2])) < 0.0 ? -1.0 : 1.0);
    const double scale = largestScale(linear);
    const auto row = [](const glm::dmat3& m, int r, double w) { return glm::vec4(glm::dvec4(m[0][r], m[1][r], m[2][r], w)); };
    const glm::dvec3 at = glm::dvec3(worldFromCentre[i][3]) - eye;
    SurfelObject& record = pass.records[i];
    record = {row(linear, 0, at.x), row(linear, 1, at.y), row(linear, 2, at.z), row(area, 0, scale * scale),
              row(area, 1, 0.0),    row(area, 2, 0.0),    record.nodes};
  }
  std::memcpy(pass.objects.mapped, pass.records.data(), pass.records.size() * sizeof(SurfelObject));
  const shared::SurfelPush constants = surfelPush(pass.placedCount, pass.nearness, glm::mat4(1.0f), skyColour);
  barrier(commands, kComputeRead, kComputeWrite);
  bind(commands, pass.place, pass.placeSet);
  vkCmdDispatch(commands, groups(pass.largestTree, 64), static_cast<std::uint32_t>(pass.records.size()), 1);
  for (const auto& [pipeline, set] : {std::pair{&pass.access, &pass.accessSet}, std::pair{&pass.bounce, &pass.bounceSet}}) {
    barrier(commands, kComputeReadWrite, kComputeReadWrite);
    bind(commands, *pipeline, *set);
    push(commands, *pipeline, constants);
    vkCmdDispatch(commands, groups(pass.placedCount, 64), 1, 1);
  }
  barrier(commands, kComputeWrite, kComputeRead);
}

}  // namespace overcast
