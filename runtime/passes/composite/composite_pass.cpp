#include "runtime/passes/composite/composite_pass.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <string>

#include <fmt/format.h>

namespace overcast {

static_assert(sizeof(shared::CompositePush) == 52 && offsetof(shared::CompositePush, everything) == 48);

namespace {

constexpr std::array<std::uint32_t, 4> kNoGroups{0, 1, 1, 0};  ///< the head of the active list: an indirect dispatch and padding

/// Earlier frames' use of what this pass writes: shaders that sample the volume, and this pass itself.
constexpr Access kEarlierUse{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
    VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_IMAGE_LAYOUT_UNDEFINED};
constexpr Access kNextWrites{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT | VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                             VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                             VK_IMAGE_LAYOUT_UNDEFINED};
constexpr Access kListsReady{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
                             VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED};
constexpr Access kVolumeReady{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                              VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_LAYOUT_GENERAL};

glm::ivec3 bricks(const GlobalGrid& grid) {
  return grid.size / shared::kBrickSide;
}

std::uint32_t brickCount(const GlobalGrid& grid) {
  const glm::ivec3 b = bricks(grid);
  return static_cast<std::uint32_t>(b.x * b.y * b.z);
}

Result<Done> makeBuffers(const Device& device, CompositePass& pass) {
  const VkDeviceSize count = brickCount(pass.grid);
  const VkDeviceSize listBytes = count * static_cast<VkDeviceSize>(shared::kBrickCapacity) * 2 * sizeof(std::uint32_t);
  struct Wanted {
    GpuBuffer& buffer;
    VkDeviceSize bytes;
    VkBufferUsageFlags usage;
  };
  const VkDeviceSize objectBytes = std::max(1u, pass.objectCapacity) * sizeof(shared::CompositeObject);
  const std::array<Wanted, 5> all{{{pass.objects, objectBytes, 0},
                                   {pass.counts, count * sizeof(std::uint32_t), 0},
                                   {pass.lists, listBytes, 0},
                                   {pass.masks, count * 8 * 4 * sizeof(std::uint32_t), 0},
                                   {pass.active, sizeof kNoGroups + count * sizeof(std::uint32_t), VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT}}};
  for (const Wanted& wanted : all) {
    Result<GpuBuffer> made = makeBuffer(device, wanted.bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | wanted.usage, MemoryUse::device);
    if (!made) return made.error();
    wanted.buffer = made.value();
  }
  return Done{};
}

Result<Done> makeVolume(const Device& device, CompositePass& pass) {
  const glm::uvec3 size(pass.grid.size);
  const std::uint32_t limit = device.properties.limits.maxImageDimension3D;
  if (std::max({size.x, size.y, size.z}) > limit)
    return Error{"", "global volume", fmt::format("{} x {} x {} voxels, but this device allows {} a side", size.x, size.y, size.z, limit)};
  ImageSettings settings;
  settings.extent = {size.x, size.y, size.z};
  settings.volume = true;
  settings.format = VK_FORMAT_R16_SFLOAT;
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT;
  Result<GpuImage> image = makeImage(device, settings);
  if (!image) return image.error();
  pass.volume = std::move(image).value();
  return runCommands(device, [&](VkCommandBuffer commands) {
    transition(commands, pass.volume, kNothingYet, kComputeWrite);
    vkCmdFillBuffer(commands, pass.counts.buffer, 0, VK_WHOLE_SIZE, 0);
    vkCmdFillBuffer(commands, pass.masks.buffer, 0, VK_WHOLE_SIZE, 0);
  });
}

Result<Done> makePipelines(const Device& device, const AssetStore& store, CompositePass& pass) {
  const std::vector<Binding> bindings{{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},         {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                      {2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},         {3, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                      {4, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}, {5, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE},
                                      {6, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},         {7, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                                      {8, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}};
  Shader composite{"runtime/passes/composite/composite.comp.glsl", {}};
  if (pass.method == CompositeMethod::bruteForce) composite.defines.push_back({"OVERCAST_BRUTE_FORCE", "1"});
  Shader cull{"runtime/passes/composite/cull.comp.glsl", {}};
  for (Shader* shader : {&cull, &composite}) shader->defines.push_back({"OVERCAST_KINDS", std::to_string(store.kinds)});
  for (const auto& [pipeline, shader] : {std::pair{&pass.cull, cull}, std::pair{&pass.composite, composite}}) {
    Result<Pipeline> made = makeComputePipeline(device, {shader, bindings, sizeof(shared::CompositePush)});
    if (!made) return made.error();
    *pipeline = std::move(made).value();
  }
  // Both pipelines have the same bindings, so that one set serves both.
  Result<DescriptorSet> set = makeDescriptorSet(device, pass.cull);
  if (!set) return set.error();
  pass.set = std::move(set).value();
  writeBuffer(device, pass.set, 0, pass.objects);
  writeBuffer(device, pass.set, 1, pass.counts);
  writeBuffer(device, pass.set, 2, pass.lists);
  writeBuffer(device, pass.set, 3, pass.active);
  writeSampledImage(device, pass.set, 4, store.atlas.image.view, store.atlas.sampler);
  writeStorageImage(device, pass.set, 5, pass.volume.mipViews[0]);
  writeBuffer(device, pass.set, 6, pass.masks);
  writeBuffer(device, pass.set, 7, store.fields);
  writeSampledImage(device, pass.set, 8, store.atlas.snorm8.view, store.atlas.sampler);
  return Done{};
}

/// The objects as the shaders get them, those of the last frame that are gone included, and whether any differs from the last frame.
bool markMoved(const std::vector<shared::CompositeObject>& previous, std::span<const shared::CompositeObject> objects,
               std::vector<shared::CompositeObject>& marked) {
  marked.assign(std::max(previous.size(), objects.size()), {});
  bool any = false;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const shared::CompositeObject before = i < previous.size() ? previous[i] : shared::CompositeObject{};
    if (i < objects.size()) marked[i] = objects[i];
    marked[i].moved = 0;
    const bool moved = (before.present || marked[i].present) && std::memcmp(&before, &marked[i], sizeof before) != 0;
    marked[i].moved = moved ? 1 : 0;
    any = any || moved;
  }
  return any;
}

/// Through the command buffer itself: no frame in flight can see the next frame's objects.
void uploadObjects(VkCommandBuffer commands, const CompositePass& pass, const std::vector<shared::CompositeObject>& objects) {
  constexpr VkDeviceSize kLargestUpdate = 65536;
  const auto* bytes = reinterpret_cast<const std::byte*>(objects.data());
  const VkDeviceSize total = objects.size() * sizeof(shared::CompositeObject);
  for (VkDeviceSize at = 0; at < total; at += kLargestUpdate)
    vkCmdUpdateBuffer(commands, pass.objects.buffer, at, std::min(kLargestUpdate, total - at), bytes + at);
}

}  // namespace

Result<CompositePass> makeCompositePass(const Device& device, const GlobalGrid& grid, const AssetStore& store, std::uint32_t objectCapacity,
                                        CompositeMethod method) {
  CompositePass pass;
  pass.grid = grid;
  pass.method = method;
  pass.objectCapacity = objectCapacity;
  const auto texelOf = [](const VkExtent3D& extent) { return 1.0f / glm::vec3(extent.width, extent.height, extent.depth); };
  pass.atlasTexel = texelOf(store.atlas.image.extent);
  pass.texel8 = texelOf(store.atlas.snorm8.extent);
  Result<Done> made = makeBuffers(device, pass);
  if (made) made = makeVolume(device, pass);
  if (made) made = makePipelines(device, store, pass);
  if (made) return pass;
  destroyCompositePass(device, pass);
  return made.error();
}

void destroyCompositePass(const Device& device, CompositePass& pass) {
  destroyDescriptorSet(device, pass.set);
  destroyPipeline(device, pass.cull);
  destroyPipeline(device, pass.composite);
  destroyImage(device, pass.volume);
  for (GpuBuffer* buffer : {&pass.objects, &pass.counts, &pass.lists, &pass.masks, &pass.active}) destroyBuffer(device, *buffer);
  pass = {};
}

bool recordComposite(VkCommandBuffer commands, CompositePass& pass, std::span<const shared::CompositeObject> objects) {
  OVERCAST_REQUIRE(objects.size() <= pass.objectCapacity, "{} objects, capacity {}", objects.size(), pass.objectCapacity);
  std::vector<shared::CompositeObject> marked;
  if (!markMoved(pass.previous, objects, marked) && !pass.fresh) return false;

  barrier(commands, kEarlierUse, kNextWrites);
  uploadObjects(commands, pass, marked);
  vkCmdUpdateBuffer(commands, pass.active.buffer, 0, sizeof kNoGroups, kNoGroups.data());
  barrier(commands, kTransferWrite, kComputeReadWrite);

  const std::uint32_t brickTotal = brickCount(pass.grid);
  const shared::CompositePush constants{glm::ivec4(bricks(pass.grid), static_cast<int>(marked.size())), glm::vec4(pass.atlasTexel, 0.0f),
                                        glm::vec4(pass.texel8, 0.0f), pass.fresh ? 1u : 0u};
  if (pass.method == CompositeMethod::culled) {
    bind(commands, pass.cull, pass.set);
    push(commands, pass.cull, constants);
    vkCmdDispatch(commands, groups(brickTotal, 64), 1, 1);
    barrier(commands, kComputeWrite, kListsReady);
  }
  bind(commands, pass.composite, pass.set);
  push(commands, pass.composite, constants);
  if (pass.method == CompositeMethod::culled)
    vkCmdDispatchIndirect(commands, pass.active.buffer, 0);
  else
    vkCmdDispatch(commands, brickTotal, 1, 1);
  barrier(commands, kComputeWrite, kVolumeReady);

  for (shared::CompositeObject& object : marked) object.moved = 0;
  marked.resize(objects.size());
  pass.previous = std::move(marked);
  pass.fresh = false;
  return true;
}

}  // namespace overcast
