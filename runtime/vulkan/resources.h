// GPU memory: buffers, images, staging, samplers and barriers. Plain handles; whoever makes one destroys it. One allocation per resource:
// put many small things into one buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include <vulkan/vulkan.h>

#include "formats/result.h"
#include "runtime/vulkan/device.h"

namespace overcast {

/// Where a buffer lives.
enum class MemoryUse {
  device,    ///< fast for the device, not mapped
  upload,    ///< mapped, coherent: the host writes, the device reads
  readback,  ///< mapped, coherent: the device writes, the host reads (cached where there is such memory)
};

struct GpuBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize bytes = 0;
  void* mapped = nullptr;  ///< for upload and readback, as long as the buffer lives
};

/// A buffer of at least 1 byte. Transfer source and destination usage are added to `usage`. Contents undefined.
Result<GpuBuffer> makeBuffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryUse use);
/// A device buffer filled with `bytes` through staging; waits for the copy.
Result<GpuBuffer> makeBufferWith(const Device& device, std::span<const std::byte> bytes, VkBufferUsageFlags usage);
/// Copies a device buffer back; waits. `count` bytes from `offset`.
Result<std::vector<std::byte>> readBuffer(const Device& device, const GpuBuffer& buffer, VkDeviceSize offset, VkDeviceSize count);
/// All of a device buffer as values; waits.
template <class T>
Result<std::vector<T>> readValues(const Device& device, const GpuBuffer& buffer) {
  const Result<std::vector<std::byte>> bytes = readBuffer(device, buffer, 0, buffer.bytes / sizeof(T) * sizeof(T));
  if (!bytes) return bytes.error();
  std::vector<T> values(bytes.value().size() / sizeof(T));
  std::memcpy(values.data(), bytes.value().data(), values.size() * sizeof(T));
  return values;
}
void destroyBuffer(const Device& device, GpuBuffer& buffer);

struct ImageSettings {
  VkExtent3D extent{1, 1, 1};  ///< depth above 1, or `volume`: a 3D image; else 2D
  bool volume = false;
  VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;
  VkImageUsageFlags usage = 0;  ///< transfer source and destination are added
  std::uint32_t mips = 1;
};

/// An image of one layer with a view of all its mips and one view for each mip (for storage writes).
struct GpuImage {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;
  std::vector<VkImageView> mipViews;
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkExtent3D extent{};
  std::uint32_t mips = 1;
  VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
};

/// In layout UNDEFINED. An Error when the device cannot hold it (size, format, memory).
Result<GpuImage> makeImage(const Device& device, const ImageSettings& settings);
void destroyImage(const Device& device, GpuImage& image);
/// Extent of one mip level, each side at least 1.
VkExtent3D mipExtent(const GpuImage& image, std::uint32_t mip);
/// Bytes of one texel of the formats we use (8, 16 and 32-bit floats and unorms, depth 32).
std::uint32_t texelBytes(VkFormat format);

enum class SamplerAddress { clampToEdge, clampToZero };
/// Trilinear or nearest sampler without anisotropy.
Result<VkSampler> makeSampler(const Device& device, VkFilter filter, SamplerAddress address = SamplerAddress::clampToEdge);

/// How a resource is used at one point of a command buffer: stages, accesses, and the layout an image must be in.
struct Access {
  VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
  VkAccessFlags2 accesses = VK_ACCESS_2_NONE;
  VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
};

inline constexpr Access kNothingYet{};  ///< fresh, contents not needed (after the previous use is known to be over)
inline constexpr Access kComputeWrite{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                      VK_IMAGE_LAYOUT_GENERAL};
inline constexpr Access kComputeReadWrite{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                          VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                                          VK_IMAGE_LAYOUT_GENERAL};
/// Storage read of an image in layout GENERAL, or of a buffer.
inline constexpr Access kComputeRead{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                     VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_UNIFORM_READ_BIT, VK_IMAGE_LAYOUT_GENERAL};
inline constexpr Access kComputeSample{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                       VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
inline constexpr Access kFragmentSample{VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                        VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
inline constexpr Access kShaderSample{VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                                      VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
inline constexpr Access kColourWrite{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                                     VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT,
                                     VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
inline constexpr Access kDepthWrite{VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
                                    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT,
                                    VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL};
inline constexpr Access kVertexRead{
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT,
    VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_UNIFORM_READ_BIT | VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_2_INDEX_READ_BIT,
    VK_IMAGE_LAYOUT_UNDEFINED};
inline constexpr Access kIndirectRead{VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT,
                                      VK_IMAGE_LAYOUT_UNDEFINED};
inline constexpr Access kTransferWrite{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                       VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
inline constexpr Access kTransferRead{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                                      VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
inline constexpr Access kHostRead{VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED};

/// Memory barrier for buffers (layouts ignored).
void barrier(VkCommandBuffer commands, const Access& from, const Access& to);
/// Barrier and layout change of `mipCount` mips from `firstMip`. From layout UNDEFINED the contents are lost.
void transition(VkCommandBuffer commands, const GpuImage& image, const Access& from, const Access& to, std::uint32_t firstMip = 0,
                std::uint32_t mipCount = VK_REMAINING_MIP_LEVELS);

/// Fills mip `mip` with tightly packed texels and leaves the whole image in `after`; waits. Mips not written before are undefined.
Result<Done> uploadImage(const Device& device, const GpuImage& image, std::span<const std::byte> texels, const Access& after,
                         std::uint32_t mip = 0);
/// Fills all mips, level by level, likewise.
Result<Done> uploadLevels(const Device& device, const GpuImage& image, std::span<const std::vector<std::byte>> levels, const Access& after);
/// Tightly packed texels of one mip; the image is in `now` before and after; waits.
Result<std::vector<std::byte>> readImage(const Device& device, const GpuImage& image, const Access& now, std::uint32_t mip = 0);

}  // namespace overcast
