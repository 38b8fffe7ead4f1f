#include "runtime/atlas.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>
#include <tuple>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/gtc/packing.hpp>

#include "runtime/passes/composite/composite.h"

namespace overcast {
namespace {

std::uint64_t texels(const glm::ivec3& extent) {
  return static_cast<std::uint64_t>(extent.x) * static_cast<std::uint64_t>(extent.y) * static_cast<std::uint64_t>(extent.z);
}

int powerOfTwoFrom(int side) {
  return static_cast<int>(std::bit_ceil(static_cast<unsigned>(side)));
}

/// Deepest first, then highest, then widest, then in the order given.
std::vector<std::size_t> packingOrder(std::span<const glm::ivec3> sizes) {
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tuple(sizes[a].z, sizes[a].y, sizes[a].x) > std::tuple(sizes[b].z, sizes[b].y, sizes[b].x);
  });
  return order;
}

/// Rows along x, stacked along y into layers, stacked along z; as deep as it becomes.
AtlasLayout packRows(std::span<const glm::ivec3> sizes, const std::vector<std::size_t>& order, int width, int height) {
  AtlasLayout layout{{width, height, 1}, std::vector<glm::ivec3>(sizes.size())};
  glm::ivec3 cursor(0);
  int rowHeight = 0;
  int layerDepth = 0;
  for (const std::size_t i : order) {
    const glm::ivec3 size = sizes[i];
    if (cursor.x + size.x > width) {
      cursor = {0, cursor.y + rowHeight, cursor.z};
      rowHeight = 0;
    }
    if (cursor.y + size.y > height) {
      cursor = {0, 0, cursor.z + layerDepth};
      rowHeight = layerDepth = 0;
    }
    layout.offsets[i] = cursor;
    cursor.x += size.x;
    rowHeight = std::max(rowHeight, size.y);
    layerDepth = std::max(layerDepth, size.z);
  }
  layout.extent.z = powerOfTwoFrom(std::max(1, cursor.z + layerDepth));
  return layout;
}

bool better(const AtlasLayout& a, const AtlasLayout& b) {
  const auto key = [](const AtlasLayout& l) {
    return std::tuple(texels(l.extent), std::max({l.extent.x, l.extent.y, l.extent.z}), l.extent.x);
  };
  return key(a) < key(b);
}

VkFormat formatOf(AtlasBits bits) {
  return bits == AtlasBits::half ? VK_FORMAT_R16_SFLOAT : VK_FORMAT_R32_SFLOAT;
}

float stored(float voxels, VkFormat format) {
  if (format != VK_FORMAT_R16_SFLOAT) return voxels;
  return glm::unpackHalf1x16(glm::packHalf1x16(std::clamp(voxels, -shared::kFarField, shared::kFarField)));
}

/// The volume in units of its voxels, with the values the device will see.
Volume inVoxels(const Volume& volume, VkFormat format) {
  Volume scaled = volume;
  scaled.voxelSize = 1.0;
  scaled.step = 0.0f;
  for (float& distance : scaled.distance) distance = stored(static_cast<float>(distance / volume.voxelSize), format);
  return scaled;
}

float lowestBorder(const Volume& volume) {
  float lowest = 0.0f;
  const glm::ivec3 last = volume.size - 1;
  std::size_t index = 0;
  for (int k = 0; k <= last.z; ++k)
    for (int j = 0; j <= last.y; ++j)
      for (int i = 0; i <= last.x; ++i, ++index)
        if (i == 0 || j == 0 || k == 0 || i == last.x || j == last.y || k == last.z) lowest = std::min(lowest, volume.distance[index]);
  return lowest;
}

/// The texel of one sample, of which `scaled` is inVoxels().
std::uint32_t texelOf(const Volume& volume, const Volume& scaled, std::size_t sample, VkFormat format) {
  if (format == VK_FORMAT_R16_SFLOAT) return glm::packHalf1x16(scaled.distance[sample]);
  if (format == VK_FORMAT_R32_SFLOAT) return std::bit_cast<std::uint32_t>(scaled.distance[sample]);
  return static_cast<std::uint8_t>(static_cast<std::int8_t>(std::lround(volume.distance[sample] / volume.step)));
}

void copyInto(std::vector<std::byte>& texelBuffer, const glm::ivec3& extent, const glm::ivec3& offset, const Volume& volume,
              const Volume& scaled, VkFormat format) {
  static_assert(std::endian::native == std::endian::little, "the low bytes of a texel are copied");
  const std::size_t bytes = texelBytes(format);
  std::size_t from = 0;
  for (int k = 0; k < scaled.size.z; ++k)
    for (int j = 0; j < scaled.size.y; ++j) {
      const std::size_t row =
          static_cast<std::size_t>(offset.z + k) * static_cast<std::size_t>(extent.y) + static_cast<std::size_t>(offset.y + j);
      std::byte* to = texelBuffer.data() + (row * static_cast<std::size_t>(extent.x) + static_cast<std::size_t>(offset.x)) * bytes;
      for (int i = 0; i < scaled.size.x; ++i, ++from, to += bytes) {
        const std::uint32_t texel = texelOf(volume, scaled, from, format);
        std::memcpy(to, &texel, bytes);
      }
    }
}

AtlasLimits limitsOf(const Device& device, VkFormat format) {
  AtlasLimits limits{device.properties.limits.maxImageDimension3D, 0, texelBytes(format)};
  for (std::uint32_t heap = 0; heap < device.memory.memoryHeapCount; ++heap)
    if (device.memory.memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      limits.maxBytes = std::max<std::uint64_t>(limits.maxBytes, device.memory.memoryHeaps[heap].size);
  return limits;
}

bool filtersLinearly(const Device& device, VkFormat format) {
  VkFormatProperties properties{};
  vkGetPhysicalDeviceFormatProperties(device.physical, format, &properties);
  return properties.optimalTilingFeatures & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
}

Result<GpuImage> uploadAtlas(const Device& device, const glm::ivec3& extent, std::span<const std::byte> texelBuffer, VkFormat format) {
  ImageSettings settings;
  settings.extent = {static_cast<std::uint32_t>(extent.x), static_cast<std::uint32_t>(extent.y), static_cast<std::uint32_t>(extent.z)};
  settings.volume = true;
  settings.format = format;
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  Result<GpuImage> image = makeImage(device, settings);
  if (!image) return image.error();
  const Result<Done> uploaded = uploadImage(device, image.value(), texelBuffer, kComputeSample);
  if (uploaded) return image;
  destroyImage(device, image.value());
  return uploaded.error();
}

/// Packs those of the volumes that have 8 bits (`snorm8`), or the others, into one image and notes where.
Result<GpuImage> makeAtlasImage(const Device& device, std::span<const Volume* const> volumes, bool snorm8, VkFormat format,
                                std::vector<AtlasEntry>& entries) {
  if (!filtersLinearly(device, format))
    return Error{"", "volume atlas", fmt::format("this device does not filter texels of {} bytes", texelBytes(format))};
  std::vector<std::size_t> members;
  std::vector<glm::ivec3> sizes;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    if ((volumes[i]->step > 0.0f) != snorm8) continue;
    members.push_back(i);
    sizes.push_back(volumes[i]->size);
  }
  const Result<AtlasLayout> layout = packAtlas(sizes, limitsOf(device, format));
  if (!layout) return layout.error();
  const glm::ivec3 extent = layout.value().extent;
  std::vector<std::byte> texelBuffer(texels(extent) * texelBytes(format));
  for (std::size_t n = 0; n < members.size(); ++n) {
    const Volume& volume = *volumes[members[n]];
    const Volume scaled = inVoxels(volume, format);
    const glm::ivec3 offset = layout.value().offsets[n];
    copyInto(texelBuffer, extent, offset, volume, scaled, format);
    entries[members[n]] = {offset,
                           volume.size,
                           volume.origin,
                           volume.voxelSize,
                           std::nextafter(static_cast<float>(lipschitzBound(scaled)), 1e30f),
                           lowestBorder(scaled),
                           *std::max_element(scaled.distance.begin(), scaled.distance.end()),
                           snorm8,
                           snorm8 ? 127.0 * double{volume.step} / volume.voxelSize : 1.0};
  }
  return uploadAtlas(device, extent, texelBuffer, format);
}

}  // namespace

Result<AtlasLayout> packAtlas(std::span<const glm::ivec3> sizes, const AtlasLimits& limits) {
  glm::ivec3 largest(1);
  std::uint64_t wanted = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const glm::ivec3 size = sizes[i];
    OVERCAST_REQUIRE(size.x > 0 && size.y > 0 && size.z > 0, "volume {} is {} x {} x {}", i, size.x, size.y, size.z);
    largest = glm::max(largest, size);
    wanted += texels(size);
  }
  // Powers of two up to the limit: the limit itself need not be one.
  const int maxSide = static_cast<int>(std::bit_floor(std::max(1u, limits.maxSide)));
  if (std::max({largest.x, largest.y, largest.z}) > maxSide)
    return Error{"", "volume atlas",
                 fmt::format("a local volume of {} x {} x {} samples is larger than the {} texels a side of this device's 3D images allows",
                             largest.x, largest.y, largest.z, maxSide)};
  const std::vector<std::size_t> order = packingOrder(sizes);
  std::optional<AtlasLayout> best;
  for (int width = powerOfTwoFrom(largest.x); width <= maxSide; width *= 2)
    for (int height = powerOfTwoFrom(largest.y); height <= maxSide; height *= 2) {
      AtlasLayout layout = packRows(sizes, order, width, height);
      if (layout.extent.z <= maxSide && (!best || better(layout, *best))) best = std::move(layout);
    }
  const std::uint64_t bytes = (best ? texels(best->extent) : wanted) * limits.texelBytes;
  if (!best || bytes > limits.maxBytes)
    return Error{
        "", "volume atlas",
        fmt::format("{} local volumes with {} samples need {} MiB{}; this device allows {} MiB and {} texels a side (bake at a "
                    "lower resolution)",
                    sizes.size(), wanted, bytes >> 20, best ? "" : " and do not fit into one 3D image", limits.maxBytes >> 20, maxSide)};
  return std::move(*best);
}

Result<Atlas> makeAtlas(const Device& device, std::span<const Volume* const> volumes, AtlasBits bits) {
  Atlas atlas;
  atlas.entries.resize(volumes.size());
  const auto failed = [&](const Error& error) {
    destroyAtlas(device, atlas);
    return error;
  };
  for (const auto& [into, snorm8, format] :
       {std::tuple(&atlas.image, false, formatOf(bits)), std::tuple(&atlas.snorm8, true, VK_FORMAT_R8_SNORM)}) {
    Result<GpuImage> image = makeAtlasImage(device, volumes, snorm8, format, atlas.entries);
    if (!image) return failed(image.error());
    *into = std::move(image).value();
  }
  Result<VkSampler> sampler = makeSampler(device, VK_FILTER_LINEAR);
  if (!sampler) return failed(sampler.error());
  atlas.sampler = sampler.value();
  return atlas;
}

void destroyAtlas(const Device& device, Atlas& atlas) {
  if (atlas.sampler) vkDestroySampler(device.device, atlas.sampler, nullptr);
  destroyImage(device, atlas.image);
  destroyImage(device, atlas.snorm8);
  atlas = {};
}

}  // namespace overcast
