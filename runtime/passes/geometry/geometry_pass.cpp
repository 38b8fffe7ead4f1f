#include "runtime/passes/geometry/geometry_pass.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include <glm/mat3x3.hpp>

namespace overcast {
namespace {

using shared::GeometryInstance;
using shared::GeometryPush;
using shared::TransferInstance;

static_assert(sizeof(GeometryInstance) == 96 && offsetof(GeometryInstance, normalX) == 48);
static_assert(sizeof(GeometryPush) == 80 && offsetof(GeometryPush, baseColour) == 64);
static_assert(sizeof(shared::RestInstance) == 8);
static_assert(sizeof(TransferInstance) == 160 && offsetof(TransferInstance, first) == 144);

constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
constexpr VkFormat kNormalFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
constexpr VkFormat kColourFormat = VK_FORMAT_R8G8B8A8_SRGB;
constexpr VkFormat kApertureFormat = VK_FORMAT_R32G32_UINT;
constexpr VkFormat kSkyLightFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
constexpr VkFormat kRestFormat = VK_FORMAT_R16G16_SFLOAT;

constexpr std::uint32_t kMapBinding = 3;
constexpr std::uint32_t kTransferBinding = 5;
constexpr std::uint32_t kRestBinding = 7;

Result<GpuImage> makeTarget(const Device& device, VkExtent2D size, VkFormat format, VkImageUsageFlags usage) {
  ImageSettings settings;
  settings.extent = {size.width, size.height, 1};
  settings.format = format;
  settings.usage = usage | VK_IMAGE_USAGE_SAMPLED_BIT;
  return makeImage(device, settings);
}

/// The inverse transpose up to a positive factor, from cofactors: also right where the matrix has no inverse.
glm::dmat3 normalFromLocal(const glm::dmat3& m) {
  glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  double largest = 0.0;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) largest = std::max(largest, std::abs(cofactors[column][row]));
  const double sign = glm::dot(m[0], cofactors[0]) < 0.0 ? -1.0 : 1.0;
  return largest > 0.0 ? cofactors * (sign / largest) : glm::dmat3(0.0);
}

VkRenderingAttachmentInfo attachment(const GpuImage& image, VkImageLayout layout) {
  VkRenderingAttachmentInfo info{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
  info.imageView = image.view;
  info.imageLayout = layout;
  info.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
  info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
  return info;
}

void beginRendering(VkCommandBuffer commands, const GeometryImages& images) {
  std::vector<VkRenderingAttachmentInfo> colours{attachment(images.normal, kColourWrite.layout),
                                                 attachment(images.colour, kColourWrite.layout)};
  for (const GpuImage* extra : {&images.aperture, &images.skyLight, &images.rest})
    if (extra->image) colours.push_back(attachment(*extra, kColourWrite.layout));
  const VkRenderingAttachmentInfo depth = attachment(images.depth, kDepthWrite.layout);
  const VkExtent2D size{images.depth.extent.width, images.depth.extent.height};
  VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
  info.renderArea = {{0, 0}, size};
  info.layerCount = 1;
  info.colorAttachmentCount = static_cast<std::uint32_t>(colours.size());
  info.pColorAttachments = colours.data();
  info.pDepthAttachment = &depth;
  vkCmdBeginRendering(commands, &info);
  const VkViewport viewport{0.0f, 0.0f, static_cast<float>(size.width), static_cast<float>(size.height), 0.0f, 1.0f};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &info.renderArea);
}

GraphicsSettings settingsOf(const GeometryExtras& extras, bool maps = false) {
  GraphicsSettings settings;
  settings.vertex = {"runtime/passes/geometry/geometry.vert.glsl", {}};
  settings.fragment = {"runtime/passes/geometry/geometry.frag.glsl", {}};
  settings.bindings = {{0, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}, {1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
  settings.pushBytes = sizeof(GeometryPush);
  settings.colours = {kNormalFormat, kColourFormat};
  settings.depth = kDepthFormat;
  if (!extras.apertures) return settings;
  for (Shader* shader : {&settings.vertex, &settings.fragment}) shader->defines.push_back({"OVERCAST_APERTURES", "1"});
  settings.bindings.push_back({2, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  settings.colours.push_back(kApertureFormat);
  for (Shader* shader : {&settings.vertex, &settings.fragment})
    if (maps) shader->defines.push_back({"OVERCAST_APERTURE_MAPS", "1"});
  for (const std::uint32_t binding : {kMapBinding, kMapBinding + 1})
    if (maps) settings.bindings.push_back({binding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  const auto add = [&](const char* define, std::uint32_t binding, VkFormat format) {
    for (Shader* shader : {&settings.vertex, &settings.fragment})
      shader->defines.push_back({define, std::to_string(settings.colours.size())});
    settings.bindings.push_back({binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
    settings.bindings.push_back({binding + 1, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
    settings.colours.push_back(format);
  };
  if (extras.transfer) add("OVERCAST_TRANSFER", kTransferBinding, kSkyLightFormat);
  if (extras.rest) add("OVERCAST_REST", kRestBinding, kRestFormat);
  return settings;
}

/// What read or wrote the images in the frame before must be over before they are written again.
constexpr Access kEarlierFrame{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
    VK_ACCESS_2_NONE, VK_IMAGE_LAYOUT_UNDEFINED};

}  // namespace

Result<GeometryImages> makeGeometryImages(const Device& device, VkExtent2D size, const GeometryExtras& extras) {
  GeometryImages images;
  std::vector<std::pair<GpuImage*, VkFormat>> targets{
      {&images.depth, kDepthFormat}, {&images.normal, kNormalFormat}, {&images.colour, kColourFormat}};
  if (extras.apertures) targets.emplace_back(&images.aperture, kApertureFormat);
  if (extras.transfer) targets.emplace_back(&images.skyLight, kSkyLightFormat);
  if (extras.rest) targets.emplace_back(&images.rest, kRestFormat);
  for (const auto& [image, format] : targets) {
    const VkImageUsageFlags usage =
        format == kDepthFormat ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    Result<GpuImage> made = makeTarget(device, size, format, usage);
    if (!made) {
      destroyGeometryImages(device, images);
      return made.error();
    }
    *image = std::move(made).value();
  }
  return images;
}

void destroyGeometryImages(const Device& device, GeometryImages& images) {
  destroyImage(device, images.depth);
  destroyImage(device, images.normal);
  destroyImage(device, images.colour);
  destroyImage(device, images.aperture);
  destroyImage(device, images.skyLight);
  destroyImage(device, images.rest);
}

namespace {

/// What every set of the pass reads beside the buffers that the pass owns.
struct SetBuffers {
  const GpuBuffer& vertices;
  const GpuBuffer& apertures;
  const GpuBuffer& transfer;
  const RestBuffers& rest;
};

void writeBuffers(const Device& device, const GeometryPass& pass, const SetBuffers& buffers, const DescriptorSet& set) {
  writeBuffer(device, set, 0, buffers.vertices);
  writeBuffer(device, set, 1, pass.instances);
  if (buffers.apertures.buffer) writeBuffer(device, set, 2, buffers.apertures);
  if (buffers.transfer.buffer) {
    writeBuffer(device, set, kTransferBinding, buffers.transfer);
    writeBuffer(device, set, kTransferBinding + 1, pass.transfers);
  }
  if (!buffers.rest.values.buffer) return;
  writeBuffer(device, set, kRestBinding, buffers.rest.values);
  writeBuffer(device, set, kRestBinding + 1, buffers.rest.instances);
}

/// The pipeline and the sets of draws with a map.
Result<Done> addMaps(const Device& device, const GraphicsSettings& settings, const SetBuffers& buffers,
                     std::span<const ApertureMapImages> maps, GeometryPass& pass) {
  auto pipeline = makeGraphicsPipeline(device, settings);
  if (!pipeline) return pipeline.error();
  pass.mapped = std::move(pipeline).value();
  const auto sampler = makeSampler(device, VK_FILTER_LINEAR);
  if (!sampler) return sampler.error();
  pass.sampler = sampler.value();
  for (const ApertureMapImages& map : maps) {
    auto set = makeDescriptorSet(device, pass.mapped);
    if (!set) return set.error();
    pass.maps.push_back(std::move(set).value());
    writeBuffers(device, pass, buffers, pass.maps.back());
    writeSampledImage(device, pass.maps.back(), kMapBinding, map.cap.view, pass.sampler);
    writeSampledImage(device, pass.maps.back(), kMapBinding + 1, map.ambient.view, pass.sampler);
  }
  return Done{};
}

}  // namespace

Result<GeometryPass> makeGeometryPass(const Device& device, const GpuBuffer& vertices, const GpuBuffer& indices, std::uint32_t capacity,
                                      const GpuBuffer& apertures, const GpuBuffer& transfer, std::span<const ApertureMapImages> maps,
                                      const RestBuffers& rest) {
  const GeometryExtras extras{apertures.buffer != VK_NULL_HANDLE, transfer.buffer != VK_NULL_HANDLE, rest.values.buffer != VK_NULL_HANDLE};
  const GraphicsSettings settings = settingsOf(extras);
  GeometryPass pass;
  pass.indices = indices.buffer;
  pass.capacity = std::max(capacity, 1u);
  const auto fail = [&](const Error& error) {
    destroyGeometryPass(device, pass);
    return error;
  };
  Result<Pipeline> pipeline = makeGraphicsPipeline(device, settings);
  if (!pipeline) return pipeline.error();
  pass.pipeline = std::move(pipeline).value();
  Result<DescriptorSet> set = makeDescriptorSet(device, pass.pipeline);
  if (!set) return fail(set.error());
  pass.set = std::move(set).value();
  Result<GpuBuffer> instances =
      makeBuffer(device, pass.capacity * sizeof(GeometryInstance), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::upload);
  if (!instances) return fail(instances.error());
  pass.instances = instances.value();
  if (transfer.buffer) {
    Result<GpuBuffer> transfers =
        makeBuffer(device, pass.capacity * sizeof(TransferInstance), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::upload);
    if (!transfers) return fail(transfers.error());
    pass.transfers = transfers.value();
  }
  const SetBuffers buffers{vertices, apertures, transfer, rest};
  writeBuffers(device, pass, buffers, pass.set);
  if (maps.empty()) return pass;
  if (const auto added = addMaps(device, settingsOf(extras, true), buffers, maps, pass); !added) return fail(added.error());
  return pass;
}

void destroyGeometryPass(const Device& device, GeometryPass& pass) {
  destroyBuffer(device, pass.instances);
  destroyBuffer(device, pass.transfers);
  destroyDescriptorSet(device, pass.set);
  for (DescriptorSet& set : pass.maps) destroyDescriptorSet(device, set);
  vkDestroySampler(device.device, pass.sampler, nullptr);
  destroyPipeline(device, pass.pipeline);
  destroyPipeline(device, pass.mapped);
}

shared::GeometryInstance geometryInstance(const glm::dmat4& worldFromLocal, const glm::dvec3& eye) {
  const glm::dvec3 translation = glm::dvec3(worldFromLocal[3]) - eye;
  const glm::dmat3 linear(worldFromLocal);
  const glm::dmat3 normals = normalFromLocal(linear);
  const auto row = [](const glm::dmat3& m, int i, double w) { return glm::vec4(glm::dvec4(m[0][i], m[1][i], m[2][i], w)); };
  GeometryInstance instance;
  instance.rowX = row(linear, 0, translation.x);
  instance.rowY = row(linear, 1, translation.y);
  instance.rowZ = row(linear, 2, translation.z);
  instance.normalX = row(normals, 0, 0.0);
  instance.normalY = row(normals, 1, 0.0);
  instance.normalZ = row(normals, 2, 0.0);
  return instance;
}

void recordGeometry(VkCommandBuffer commands, GeometryPass& pass, const GeometryImages& images,
                    std::span<const shared::GeometryInstance> instances, std::span<const GeometryDraw> draws,
                    const glm::mat4& clipFromRelative, std::span<const TransferInstance> transfers) {
  OVERCAST_REQUIRE(instances.size() <= pass.capacity, "{} instances, room for {}", instances.size(), pass.capacity);
  if (!instances.empty()) std::memcpy(pass.instances.mapped, instances.data(), instances.size_bytes());
  if (pass.transfers.buffer && !instances.empty()) {
    OVERCAST_REQUIRE(transfers.size() == instances.size(), "{} transfers for {} instances", transfers.size(), instances.size());
    std::memcpy(pass.transfers.mapped, transfers.data(), transfers.size_bytes());
  }
  transition(commands, images.normal, kEarlierFrame, kColourWrite);
  transition(commands, images.colour, kEarlierFrame, kColourWrite);
  for (const GpuImage* extra : {&images.aperture, &images.skyLight, &images.rest})
    if (extra->image) transition(commands, *extra, kEarlierFrame, kColourWrite);
  transition(commands, images.depth, kEarlierFrame, kDepthWrite);
  beginRendering(commands, images);
  vkCmdBindIndexBuffer(commands, pass.indices, 0, VK_INDEX_TYPE_UINT32);
  int bound = -2;
  for (const GeometryDraw& draw : draws) {
    const int map = pass.maps.empty() ? -1 : draw.map;
    const Pipeline& pipeline = map < 0 ? pass.pipeline : pass.mapped;
    if (map != bound) bind(commands, pipeline, map < 0 ? pass.set : pass.maps[static_cast<std::size_t>(map)]);
    bound = map;
    push(commands, pipeline, GeometryPush{clipFromRelative, draw.baseColour});
    vkCmdDrawIndexed(commands, draw.indexCount, draw.instanceCount, draw.firstIndex, draw.vertexOffset, draw.firstInstance);
  }
  vkCmdEndRendering(commands);
  transition(commands, images.normal, kColourWrite, kShaderSample);
  transition(commands, images.colour, kColourWrite, kShaderSample);
  for (const GpuImage* extra : {&images.aperture, &images.skyLight, &images.rest})
    if (extra->image) transition(commands, *extra, kColourWrite, kShaderSample);
  transition(commands, images.depth, kDepthWrite, kShaderSample);
}

}  // namespace overcast
