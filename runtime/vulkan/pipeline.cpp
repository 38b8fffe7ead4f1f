#include "runtime/vulkan/pipeline.h"

#include <algorithm>
#include <array>

namespace overcast {
namespace {

Result<VkShaderModule> makeModule(const Device& device, const Shader& shader) {
  const Result<Spirv> spirv = compileShader(shader);
  if (!spirv) return spirv.error();
  VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  info.codeSize = spirv.value().words.size() * sizeof(std::uint32_t);
  info.pCode = spirv.value().words.data();
  VkShaderModule module = VK_NULL_HANDLE;
  const VkResult made = vkCreateShaderModule(device.device, &info, nullptr, &module);
  if (made != VK_SUCCESS) return vulkanError(made, fmt::format("cannot load shader {}", shader.path));
  return module;
}

VkPipelineShaderStageCreateInfo stageInfo(VkShaderStageFlagBits stage, VkShaderModule module) {
  VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage = stage;
  info.module = module;
  info.pName = "main";
  return info;
}

Result<Done> makeLayout(const Device& device, Pipeline& pipeline) {
  OVERCAST_REQUIRE(pipeline.pushBytes <= kMaxPushBytes && pipeline.pushBytes % 4 == 0, "{} bytes of push constants", pipeline.pushBytes);
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (const Binding& binding : pipeline.bindings) bindings.push_back({binding.binding, binding.type, 1, pipeline.stages, nullptr});
  VkDescriptorSetLayoutCreateInfo setInfo{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  setInfo.bindingCount = static_cast<std::uint32_t>(bindings.size());
  setInfo.pBindings = bindings.data();
  VkResult made = vkCreateDescriptorSetLayout(device.device, &setInfo, nullptr, &pipeline.setLayout);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a descriptor set layout");
  const VkPushConstantRange range{pipeline.stages, 0, pipeline.pushBytes};
  VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  info.setLayoutCount = 1;
  info.pSetLayouts = &pipeline.setLayout;
  info.pushConstantRangeCount = pipeline.pushBytes > 0 ? 1 : 0;
  info.pPushConstantRanges = &range;
  made = vkCreatePipelineLayout(device.device, &info, nullptr, &pipeline.layout);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a pipeline layout");
  return Done{};
}

Result<Done> fillCompute(const Device& device, const Shader& shader, Pipeline& pipeline) {
  const Result<Done> layout = makeLayout(device, pipeline);
  if (!layout) return layout;
  const Result<VkShaderModule> module = makeModule(device, shader);
  if (!module) return module.error();
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = stageInfo(VK_SHADER_STAGE_COMPUTE_BIT, module.value());
  info.layout = pipeline.layout;
  const VkResult made = vkCreateComputePipelines(device.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline.pipeline);
  vkDestroyShaderModule(device.device, module.value(), nullptr);
  if (made != VK_SUCCESS) return vulkanError(made, fmt::format("cannot make a pipeline of {}", shader.path));
  return Done{};
}

VkResult makeGraphics(const Device& device, const GraphicsSettings& settings, VkShaderModule vertex, VkShaderModule fragment,
                      Pipeline& pipeline) {
  const std::array stages{stageInfo(VK_SHADER_STAGE_VERTEX_BIT, vertex), stageInfo(VK_SHADER_STAGE_FRAGMENT_BIT, fragment)};
  const VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
  assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
  viewport.viewportCount = viewport.scissorCount = 1;
  VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
  raster.cullMode = settings.cull;
  raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
  raster.lineWidth = 1.0f;
  VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
  samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
  VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
  depth.depthTestEnable = depth.depthWriteEnable = settings.depth != VK_FORMAT_UNDEFINED;
  depth.depthCompareOp = settings.depthTest;
  VkPipelineColorBlendAttachmentState whole{};
  whole.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
  const std::vector<VkPipelineColorBlendAttachmentState> blends(settings.colours.size(), whole);
  VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
  blend.attachmentCount = static_cast<std::uint32_t>(blends.size());
  blend.pAttachments = blends.data();
  const std::array dynamicStates{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
  dynamic.dynamicStateCount = static_cast<std::uint32_t>(dynamicStates.size());
  dynamic.pDynamicStates = dynamicStates.data();
  VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  rendering.colorAttachmentCount = static_cast<std::uint32_t>(settings.colours.size());
  rendering.pColorAttachmentFormats = settings.colours.data();
  rendering.depthAttachmentFormat = settings.depth;

  VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
  info.pNext = &rendering;
  info.stageCount = static_cast<std::uint32_t>(stages.size());
  info.pStages = stages.data();
  info.pVertexInputState = &input;
  info.pInputAssemblyState = &assembly;
  info.pViewportState = &viewport;
  info.pRasterizationState = &raster;
  info.pMultisampleState = &samples;
  info.pDepthStencilState = &depth;
  info.pColorBlendState = &blend;
  info.pDynamicState = &dynamic;
  info.layout = pipeline.layout;
  return vkCreateGraphicsPipelines(device.device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline.pipeline);
}

Result<Done> fillGraphics(const Device& device, const GraphicsSettings& settings, Pipeline& pipeline) {
  const Result<Done> layout = makeLayout(device, pipeline);
  if (!layout) return layout;
  const Result<VkShaderModule> vertex = makeModule(device, settings.vertex);
  if (!vertex) return vertex.error();
  const Result<VkShaderModule> fragment = makeModule(device, settings.fragment);
  VkResult made = VK_SUCCESS;
  if (fragment) {
    made = makeGraphics(device, settings, vertex.value(), fragment.value(), pipeline);
    vkDestroyShaderModule(device.device, fragment.value(), nullptr);
  }
  vkDestroyShaderModule(device.device, vertex.value(), nullptr);
  if (!fragment) return fragment.error();
  if (made != VK_SUCCESS) return vulkanError(made, fmt::format("cannot make a pipeline of {}", settings.fragment.path));
  return Done{};
}

Result<Pipeline> orDestroy(const Device& device, const Result<Done>& filled, Pipeline& pipeline) {
  if (filled) return pipeline;
  destroyPipeline(device, pipeline);
  return filled.error();
}

VkDescriptorType typeOf(const DescriptorSet& set, std::uint32_t binding) {
  const auto found = std::find_if(set.bindings.begin(), set.bindings.end(), [&](const Binding& b) { return b.binding == binding; });
  OVERCAST_REQUIRE(found != set.bindings.end(), "binding {} of a set of {}", binding, set.bindings.size());
  return found->type;
}

void write(const Device& device, const DescriptorSet& set, std::uint32_t binding, const VkDescriptorBufferInfo* buffer,
           const VkDescriptorImageInfo* image) {
  VkWriteDescriptorSet info{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  info.dstSet = set.set;
  info.dstBinding = binding;
  info.descriptorCount = 1;
  info.descriptorType = typeOf(set, binding);
  info.pBufferInfo = buffer;
  info.pImageInfo = image;
  vkUpdateDescriptorSets(device.device, 1, &info, 0, nullptr);
}

}  // namespace

Result<Pipeline> makeComputePipeline(const Device& device, const ComputeSettings& settings) {
  Pipeline pipeline;
  pipeline.stages = VK_SHADER_STAGE_COMPUTE_BIT;
  pipeline.pushBytes = settings.pushBytes;
  pipeline.bindings = settings.bindings;
  return orDestroy(device, fillCompute(device, settings.shader, pipeline), pipeline);
}

Result<Pipeline> makeGraphicsPipeline(const Device& device, const GraphicsSettings& settings) {
  Pipeline pipeline;
  pipeline.bindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS;
  pipeline.stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
  pipeline.pushBytes = settings.pushBytes;
  pipeline.bindings = settings.bindings;
  return orDestroy(device, fillGraphics(device, settings, pipeline), pipeline);
}

void destroyPipeline(const Device& device, Pipeline& pipeline) {
  vkDestroyPipeline(device.device, pipeline.pipeline, nullptr);
  vkDestroyPipelineLayout(device.device, pipeline.layout, nullptr);
  vkDestroyDescriptorSetLayout(device.device, pipeline.setLayout, nullptr);
  pipeline = {};
}

Result<DescriptorSet> makeDescriptorSet(const Device& device, const Pipeline& pipeline) {
  OVERCAST_REQUIRE(!pipeline.bindings.empty(), "a descriptor set for a pipeline without bindings");
  std::vector<VkDescriptorPoolSize> sizes;
  for (const Binding& binding : pipeline.bindings) sizes.push_back({binding.type, 1});
  VkDescriptorPoolCreateInfo poolInfo{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
  poolInfo.maxSets = 1;
  poolInfo.poolSizeCount = static_cast<std::uint32_t>(sizes.size());
  poolInfo.pPoolSizes = sizes.data();
  DescriptorSet set;
  set.bindings = pipeline.bindings;
  VkResult made = vkCreateDescriptorPool(device.device, &poolInfo, nullptr, &set.pool);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a descriptor pool");
  VkDescriptorSetAllocateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
  info.descriptorPool = set.pool;
  info.descriptorSetCount = 1;
  info.pSetLayouts = &pipeline.setLayout;
  made = vkAllocateDescriptorSets(device.device, &info, &set.set);
  if (made == VK_SUCCESS) return set;
  destroyDescriptorSet(device, set);
  return vulkanError(made, "cannot make a descriptor set");
}

void destroyDescriptorSet(const Device& device, DescriptorSet& set) {
  vkDestroyDescriptorPool(device.device, set.pool, nullptr);
  set = {};
}

void writeBuffer(const Device& device, const DescriptorSet& set, std::uint32_t binding, const GpuBuffer& buffer) {
  const VkDescriptorBufferInfo info{buffer.buffer, 0, VK_WHOLE_SIZE};
  write(device, set, binding, &info, nullptr);
}

void writeStorageImage(const Device& device, const DescriptorSet& set, std::uint32_t binding, VkImageView view) {
  const VkDescriptorImageInfo info{VK_NULL_HANDLE, view, VK_IMAGE_LAYOUT_GENERAL};
  write(device, set, binding, nullptr, &info);
}

void writeSampledImage(const Device& device, const DescriptorSet& set, std::uint32_t binding, VkImageView view, VkSampler sampler,
                       VkImageLayout layout) {
  const VkDescriptorImageInfo info{sampler, view, layout};
  write(device, set, binding, nullptr, &info);
}

void bind(VkCommandBuffer commands, const Pipeline& pipeline, const DescriptorSet& set) {
  bind(commands, pipeline);
  vkCmdBindDescriptorSets(commands, pipeline.bindPoint, pipeline.layout, 0, 1, &set.set, 0, nullptr);
}

void bind(VkCommandBuffer commands, const Pipeline& pipeline) {
  vkCmdBindPipeline(commands, pipeline.bindPoint, pipeline.pipeline);
}

void pushBytes(VkCommandBuffer commands, const Pipeline& pipeline, const void* data, std::uint32_t bytes) {
  OVERCAST_REQUIRE(bytes == pipeline.pushBytes, "{} bytes pushed into {}", bytes, pipeline.pushBytes);
  vkCmdPushConstants(commands, pipeline.layout, pipeline.stages, 0, bytes, data);
}

}  // namespace overcast
