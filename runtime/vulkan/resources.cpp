#include "runtime/vulkan/resources.h"

#include <algorithm>
#include <cstring>
#include <optional>

namespace overcast {
namespace {

constexpr VkMemoryPropertyFlags kMapped = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

std::optional<std::uint32_t> memoryType(const Device& device, std::uint32_t allowed, VkMemoryPropertyFlags flags) {
  for (std::uint32_t i = 0; i < device.memory.memoryTypeCount; ++i)
    if ((allowed & (1u << i)) && (device.memory.memoryTypes[i].propertyFlags & flags) == flags) return i;
  return std::nullopt;
}

/// The first choice of flags that some allowed memory type has. Vulkan promises host-visible coherent memory for buffers.
std::uint32_t memoryTypeFor(const Device& device, std::uint32_t allowed, MemoryUse use) {
  std::vector<VkMemoryPropertyFlags> wishes;
  if (use == MemoryUse::device) wishes = {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0};
  if (use == MemoryUse::upload) wishes = {kMapped};
  if (use == MemoryUse::readback) wishes = {kMapped | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, kMapped};
  for (const VkMemoryPropertyFlags wish : wishes)
    if (const auto type = memoryType(device, allowed, wish)) return *type;
  stop(__FILE__, __LINE__, fmt::format("no memory type among {:#x} for use {}", allowed, static_cast<int>(use)));
}

Result<VkDeviceMemory> allocate(const Device& device, const VkMemoryRequirements& needs, MemoryUse use) {
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = needs.size;
  info.memoryTypeIndex = memoryTypeFor(device, needs.memoryTypeBits, use);
  VkDeviceMemory memory = VK_NULL_HANDLE;
  const VkResult made = vkAllocateMemory(device.device, &info, nullptr, &memory);
  if (made != VK_SUCCESS) return vulkanError(made, fmt::format("cannot allocate {} bytes of device memory", needs.size));
  if (use == MemoryUse::device) device.allocatedBytes += needs.size;
  return memory;
}

Result<Done> fillBuffer(const Device& device, GpuBuffer& buffer, VkBufferUsageFlags usage, MemoryUse use) {
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = buffer.bytes;
  info.usage = usage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  VkResult made = vkCreateBuffer(device.device, &info, nullptr, &buffer.buffer);
  if (made != VK_SUCCESS) return vulkanError(made, fmt::format("cannot make a buffer of {} bytes", buffer.bytes));
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device.device, buffer.buffer, &needs);
  const Result<VkDeviceMemory> memory = allocate(device, needs, use);
  if (!memory) return memory.error();
  buffer.memory = memory.value();
  made = vkBindBufferMemory(device.device, buffer.buffer, buffer.memory, 0);
  if (made == VK_SUCCESS && use != MemoryUse::device) made = vkMapMemory(device.device, buffer.memory, 0, VK_WHOLE_SIZE, 0, &buffer.mapped);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot map a buffer");
  return Done{};
}

Result<VkImageView> makeView(const Device& device, const GpuImage& image, VkImageViewType type, std::uint32_t firstMip,
                             std::uint32_t mips) {
  VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  info.image = image.image;
  info.viewType = type;
  info.format = image.format;
  info.subresourceRange = {image.aspect, firstMip, mips, 0, 1};
  VkImageView view = VK_NULL_HANDLE;
  const VkResult made = vkCreateImageView(device.device, &info, nullptr, &view);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make an image view");
  return view;
}

Result<Done> checkImage(const Device& device, const VkImageCreateInfo& info) {
  VkImageFormatProperties limits;
  const VkResult known =
      vkGetPhysicalDeviceImageFormatProperties(device.physical, info.format, info.imageType, info.tiling, info.usage, info.flags, &limits);
  if (known != VK_SUCCESS) return vulkanError(known, fmt::format("cannot make an image of format {}", static_cast<int>(info.format)));
  const VkExtent3D& most = limits.maxExtent;
  if (info.extent.width > most.width || info.extent.height > most.height || info.extent.depth > most.depth)
    return Error{"", "",
                 fmt::format("an image of {}x{}x{} is larger than the device's {}x{}x{}", info.extent.width, info.extent.height,
                             info.extent.depth, most.width, most.height, most.depth)};
  return Done{};
}

Result<Done> fillImage(const Device& device, GpuImage& image, const ImageSettings& settings) {
  const bool volume = settings.volume || settings.extent.depth > 1;
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = volume ? VK_IMAGE_TYPE_3D : VK_IMAGE_TYPE_2D;
  info.format = settings.format;
  info.extent = settings.extent;
  info.mipLevels = settings.mips;
  info.arrayLayers = 1;
  info.samples = VK_SAMPLE_COUNT_1_BIT;
  info.usage = settings.usage | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  const Result<Done> fits = checkImage(device, info);
  if (!fits) return fits;
  VkResult made = vkCreateImage(device.device, &info, nullptr, &image.image);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make an image");
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(device.device, image.image, &needs);
  const Result<VkDeviceMemory> memory = allocate(device, needs, MemoryUse::device);
  if (!memory) return memory.error();
  image.memory = memory.value();
  made = vkBindImageMemory(device.device, image.image, image.memory, 0);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot bind image memory");

  const VkImageViewType type = volume ? VK_IMAGE_VIEW_TYPE_3D : VK_IMAGE_VIEW_TYPE_2D;
  const Result<VkImageView> whole = makeView(device, image, type, 0, settings.mips);
  if (!whole) return whole.error();
  image.view = whole.value();
  for (std::uint32_t mip = 0; mip < settings.mips; ++mip) {
    const Result<VkImageView> view = makeView(device, image, type, mip, 1);
    if (!view) return view.error();
    image.mipViews.push_back(view.value());
  }
  return Done{};
}

VkBufferImageCopy2 wholeMip(const GpuImage& image, std::uint32_t mip) {
  VkBufferImageCopy2 region{VK_STRUCTURE_TYPE_BUFFER_IMAGE_COPY_2};
  region.imageSubresource = {image.aspect, mip, 0, 1};
  region.imageExtent = mipExtent(image, mip);
  return region;
}

VkDeviceSize mipBytes(const GpuImage& image, std::uint32_t mip) {
  const VkExtent3D extent = mipExtent(image, mip);
  return VkDeviceSize{extent.width} * extent.height * extent.depth * texelBytes(image.format);
}

std::vector<std::byte> copyOut(const GpuBuffer& buffer) {
  const auto* first = static_cast<const std::byte*>(buffer.mapped);
  return {first, first + buffer.bytes};
}

}  // namespace

Result<GpuBuffer> makeBuffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, MemoryUse use) {
  GpuBuffer buffer;
  buffer.bytes = std::max<VkDeviceSize>(bytes, 1);
  const Result<Done> filled = fillBuffer(device, buffer, usage, use);
  if (!filled) {
    destroyBuffer(device, buffer);
    return filled.error();
  }
  return buffer;
}

Result<GpuBuffer> makeBufferWith(const Device& device, std::span<const std::byte> bytes, VkBufferUsageFlags usage) {
  Result<GpuBuffer> staging = makeBuffer(device, bytes.size(), 0, MemoryUse::upload);
  if (!staging) return staging;
  if (!bytes.empty()) std::memcpy(staging.value().mapped, bytes.data(), bytes.size());
  Result<GpuBuffer> buffer = makeBuffer(device, bytes.size(), usage, MemoryUse::device);
  if (buffer) {
    const Result<Done> copied = runCommands(device, [&](VkCommandBuffer commands) {
      const VkBufferCopy region{0, 0, staging.value().bytes};
      vkCmdCopyBuffer(commands, staging.value().buffer, buffer.value().buffer, 1, &region);
    });
    if (!copied) {
      destroyBuffer(device, buffer.value());
      buffer = copied.error();
    }
  }
  destroyBuffer(device, staging.value());
  return buffer;
}

Result<std::vector<std::byte>> readBuffer(const Device& device, const GpuBuffer& buffer, VkDeviceSize offset, VkDeviceSize count) {
  OVERCAST_REQUIRE(count > 0 && offset + count <= buffer.bytes, "{} bytes at {} of {}", count, offset, buffer.bytes);
  Result<GpuBuffer> staging = makeBuffer(device, count, 0, MemoryUse::readback);
  if (!staging) return staging.error();
  const Result<Done> copied = runCommands(device, [&](VkCommandBuffer commands) {
    const VkBufferCopy region{offset, 0, count};
    vkCmdCopyBuffer(commands, buffer.buffer, staging.value().buffer, 1, &region);
    barrier(commands, kTransferWrite, kHostRead);
  });
  Result<std::vector<std::byte>> bytes = copied ? Result<std::vector<std::byte>>(copyOut(staging.value())) : copied.error();
  destroyBuffer(device, staging.value());
  return bytes;
}

void destroyBuffer(const Device& device, GpuBuffer& buffer) {
  vkDestroyBuffer(device.device, buffer.buffer, nullptr);
  vkFreeMemory(device.device, buffer.memory, nullptr);
  buffer = {};
}

Result<GpuImage> makeImage(const Device& device, const ImageSettings& settings) {
  GpuImage image;
  image.format = settings.format;
  image.extent = settings.extent;
  image.mips = settings.mips;
  if (settings.format == VK_FORMAT_D32_SFLOAT) image.aspect = VK_IMAGE_ASPECT_DEPTH_BIT;
  const Result<Done> filled = fillImage(device, image, settings);
  if (!filled) {
    destroyImage(device, image);
    return filled.error();
  }
  return image;
}

void destroyImage(const Device& device, GpuImage& image) {
  for (VkImageView view : image.mipViews) vkDestroyImageView(device.device, view, nullptr);
  vkDestroyImageView(device.device, image.view, nullptr);
  vkDestroyImage(device.device, image.image, nullptr);
  vkFreeMemory(device.device, image.memory, nullptr);
  image = {};
}

VkExtent3D mipExtent(const GpuImage& image, std::uint32_t mip) {
  return {std::max(image.extent.width >> mip, 1u), std::max(image.extent.height >> mip, 1u), std::max(image.extent.depth >> mip, 1u)};
}

std::uint32_t texelBytes(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R8_UNORM:
    case VK_FORMAT_R8_SNORM:
      return 1;
    case VK_FORMAT_R16_SFLOAT:
      return 2;
    case VK_FORMAT_R8G8B8A8_UNORM:
    case VK_FORMAT_R8G8B8A8_SRGB:
    case VK_FORMAT_B8G8R8A8_UNORM:
    case VK_FORMAT_R16G16_SFLOAT:
    case VK_FORMAT_R32_SFLOAT:
    case VK_FORMAT_R32_UINT:
    case VK_FORMAT_D32_SFLOAT:
      return 4;
    case VK_FORMAT_R16G16B16A16_SFLOAT:
    case VK_FORMAT_R32G32_SFLOAT:
      return 8;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
      return 16;
    default:
      stop(__FILE__, __LINE__, fmt::format("unknown texel size of format {}", static_cast<int>(format)));
  }
}

Result<VkSampler> makeSampler(const Device& device, VkFilter filter, SamplerAddress address) {
  const VkSamplerAddressMode mode =
      address == SamplerAddress::clampToEdge ? VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER;
  VkSamplerCreateInfo info{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
  info.magFilter = filter;
  info.minFilter = filter;
  info.mipmapMode = filter == VK_FILTER_LINEAR ? VK_SAMPLER_MIPMAP_MODE_LINEAR : VK_SAMPLER_MIPMAP_MODE_NEAREST;
  info.addressModeU = info.addressModeV = info.addressModeW = mode;
  info.borderColor = VK_BORDER_COLOR_FLOAT_TRANSPARENT_BLACK;
  info.maxLod = VK_LOD_CLAMP_NONE;
  VkSampler sampler = VK_NULL_HANDLE;
  const VkResult made = vkCreateSampler(device.device, &info, nullptr, &sampler);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a sampler");
  return sampler;
}

void barrier(VkCommandBuffer commands, const Access& from, const Access& to) {
  VkMemoryBarrier2 memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
  memory.srcStageMask = from.stages;
  memory.srcAccessMask = from.accesses;
  memory.dstStageMask = to.stages;
  memory.dstAccessMask = to.accesses;
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.memoryBarrierCount = 1;
  info.pMemoryBarriers = &memory;
  vkCmdPipelineBarrier2(commands, &info);
}

void transition(VkCommandBuffer commands, const GpuImage& image, const Access& from, const Access& to, std::uint32_t firstMip,
                std::uint32_t mipCount) {
  VkImageMemoryBarrier2 change{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
  change.srcStageMask = from.stages;
  change.srcAccessMask = from.accesses;
  change.dstStageMask = to.stages;
  change.dstAccessMask = to.accesses;
  change.oldLayout = from.layout;
  change.newLayout = to.layout;
  change.srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  change.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  change.image = image.image;
  change.subresourceRange = {image.aspect, firstMip, mipCount, 0, 1};
  VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
  info.imageMemoryBarrierCount = 1;
  info.pImageMemoryBarriers = &change;
  vkCmdPipelineBarrier2(commands, &info);
}

Result<Done> uploadImage(const Device& device, const GpuImage& image, std::span<const std::byte> texels, const Access& after,
                         std::uint32_t mip) {
  OVERCAST_REQUIRE(texels.size() == mipBytes(image, mip), "{} bytes for a mip of {}", texels.size(), mipBytes(image, mip));
  Result<GpuBuffer> staging = makeBuffer(device, texels.size(), 0, MemoryUse::upload);
  if (!staging) return staging.error();
  std::memcpy(staging.value().mapped, texels.data(), texels.size());
  const Result<Done> copied = runCommands(device, [&](VkCommandBuffer commands) {
    transition(commands, image, kNothingYet, kTransferWrite);
    const VkBufferImageCopy2 region = wholeMip(image, mip);
    VkCopyBufferToImageInfo2 copy{VK_STRUCTURE_TYPE_COPY_BUFFER_TO_IMAGE_INFO_2};
    copy.srcBuffer = staging.value().buffer;
    copy.dstImage = image.image;
    copy.dstImageLayout = kTransferWrite.layout;
    copy.regionCount = 1;
    copy.pRegions = &region;
    vkCmdCopyBufferToImage2(commands, &copy);
    transition(commands, image, kTransferWrite, after);
  });
  destroyBuffer(device, staging.value());
  return copied;
}

Result<Done> uploadLevels(const Device& device, const GpuImage& image, std::span<const std::vector<std::byte>> levels,
                          const Access& after) {
  OVERCAST_REQUIRE(levels.size() == image.mips, "{} levels for {} mips", levels.size(), image.mips);
  std::vector<std::byte> all;
  std::vector<VkBufferImageCopy2> regions;
  for (std::uint32_t mip = 0; mip < image.mips; ++mip) {
    OVERCAST_REQUIRE(levels[mip].size() == mipBytes(image, mip), "{} bytes for a mip of {}", levels[mip].size(), mipBytes(image, mip));
    all.resize((all.size() + 15) / 16 * 16);  // offsets are multiples of a texel
    regions.push_back(wholeMip(image, mip));
    regions.back().bufferOffset = all.size();
    all.insert(all.end(), levels[mip].begin(), levels[mip].end());
  }
  Result<GpuBuffer> staging = makeBuffer(device, all.size(), 0, MemoryUse::upload);
  if (!staging) return staging.error();
  std::memcpy(staging.value().mapped, all.data(), all.size());
  const Result<Done> copied = runCommands(device, [&](VkCommandBuffer commands) {
    transition(commands, image, kNothingYet, kTransferWrite);
    VkCopyBufferToImageInfo2 copy{VK_STRUCTURE_TYPE_COPY_BUFFER_TO_IMAGE_INFO_2};
    copy.srcBuffer = staging.value().buffer;
    copy.dstImage = image.image;
    copy.dstImageLayout = kTransferWrite.layout;
    copy.regionCount = image.mips;
    copy.pRegions = regions.data();
    vkCmdCopyBufferToImage2(commands, &copy);
    transition(commands, image, kTransferWrite, after);
  });
  destroyBuffer(device, staging.value());
  return copied;
}

Result<std::vector<std::byte>> readImage(const Device& device, const GpuImage& image, const Access& now, std::uint32_t mip) {
  Result<GpuBuffer> staging = makeBuffer(device, mipBytes(image, mip), 0, MemoryUse::readback);
  if (!staging) return staging.error();
  const Result<Done> copied = runCommands(device, [&](VkCommandBuffer commands) {
    transition(commands, image, now, kTransferRead);
    const VkBufferImageCopy2 region = wholeMip(image, mip);
    VkCopyImageToBufferInfo2 copy{VK_STRUCTURE_TYPE_COPY_IMAGE_TO_BUFFER_INFO_2};
    copy.srcImage = image.image;
    copy.srcImageLayout = kTransferRead.layout;
    copy.dstBuffer = staging.value().buffer;
    copy.regionCount = 1;
    copy.pRegions = &region;
    vkCmdCopyImageToBuffer2(commands, &copy);
    transition(commands, image, kTransferRead, now);
    barrier(commands, kTransferWrite, kHostRead);
  });
  Result<std::vector<std::byte>> bytes = copied ? Result<std::vector<std::byte>>(copyOut(staging.value())) : copied.error();
  destroyBuffer(device, staging.value());
  return bytes;
}

}  // namespace overcast
