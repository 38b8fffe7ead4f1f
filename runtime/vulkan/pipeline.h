// Pipelines from shader files, and the descriptor sets they read. Ordinary descriptor sets, no push descriptors: GPU-assisted validation
// stays right (PITFALLS).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "formats/result.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/resources.h"
#include "runtime/vulkan/shader.h"

namespace overcast {

inline constexpr std::uint32_t kMaxPushBytes = 128;  ///< what every Vulkan device has

/// One binding of set 0. Types: STORAGE_BUFFER, UNIFORM_BUFFER, STORAGE_IMAGE, COMBINED_IMAGE_SAMPLER.
struct Binding {
  std::uint32_t binding = 0;
  VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
};

struct Pipeline {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;
  VkPipelineBindPoint bindPoint = VK_PIPELINE_BIND_POINT_COMPUTE;
  VkShaderStageFlags stages = 0;  ///< that see the bindings and the push constants
  std::uint32_t pushBytes = 0;
  std::vector<Binding> bindings;
};

struct ComputeSettings {
  Shader shader;
  std::vector<Binding> bindings;
  std::uint32_t pushBytes = 0;  ///< a multiple of 4, at most kMaxPushBytes
};

/// Triangle lists without vertex input state (vertices are read from storage buffers), dynamic viewport and scissor, dynamic rendering.
struct GraphicsSettings {
  Shader vertex;
  Shader fragment;
  std::vector<Binding> bindings;
  std::uint32_t pushBytes = 0;
  std::vector<VkFormat> colours;                  ///< attachment formats, no blending
  VkFormat depth = VK_FORMAT_UNDEFINED;           ///< UNDEFINED: no depth attachment
  VkCompareOp depthTest = VK_COMPARE_OP_GREATER;  ///< reversed depth: 1 near, 0 far
  VkCullModeFlags cull = VK_CULL_MODE_NONE;
};

/// Errors: the shader does not compile, or the device refuses the pipeline.
Result<Pipeline> makeComputePipeline(const Device& device, const ComputeSettings& settings);
Result<Pipeline> makeGraphicsPipeline(const Device& device, const GraphicsSettings& settings);
void destroyPipeline(const Device& device, Pipeline& pipeline);

/// A set for a pipeline's bindings, with its own small pool. Every binding must be written before use, none while the device reads it.
struct DescriptorSet {
  VkDescriptorSet set = VK_NULL_HANDLE;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  std::vector<Binding> bindings;
};

Result<DescriptorSet> makeDescriptorSet(const Device& device, const Pipeline& pipeline);
void destroyDescriptorSet(const Device& device, DescriptorSet& set);

/// The whole buffer as STORAGE_BUFFER or UNIFORM_BUFFER, as the binding says.
void writeBuffer(const Device& device, const DescriptorSet& set, std::uint32_t binding, const GpuBuffer& buffer);
/// A view of one mip in layout GENERAL.
void writeStorageImage(const Device& device, const DescriptorSet& set, std::uint32_t binding, VkImageView view);
/// A view with a sampler; the image is in `layout` when it is read.
void writeSampledImage(const Device& device, const DescriptorSet& set, std::uint32_t binding, VkImageView view, VkSampler sampler,
                       VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);

void bind(VkCommandBuffer commands, const Pipeline& pipeline, const DescriptorSet& set);
void bind(VkCommandBuffer commands, const Pipeline& pipeline);  ///< of a pipeline without bindings
void pushBytes(VkCommandBuffer commands, const Pipeline& pipeline, const void* data, std::uint32_t bytes);

/// Push constants; T is the struct of the shared header.
template <class T>
void push(VkCommandBuffer commands, const Pipeline& pipeline, const T& constants) {
  static_assert(sizeof(T) <= kMaxPushBytes && sizeof(T) % 4 == 0);
  pushBytes(commands, pipeline, &constants, sizeof(T));
}

/// Work groups that cover `count` items in groups of `size`.
constexpr std::uint32_t groups(std::uint32_t count, std::uint32_t size) {
  return (count + size - 1) / size;
}

}  // namespace overcast
