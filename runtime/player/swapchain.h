// Swapchain: the images a window shows, filled by copying a frame into them.
#pragma once

#include <vector>

#include <vulkan/vulkan.h>

#include "formats/result.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

struct Swapchain {
  VkSwapchainKHR swapchain = VK_NULL_HANDLE;
  std::vector<GpuImage> images;       ///< owned by the swapchain: handle, format and extent only
  std::vector<VkSemaphore> rendered;  ///< one for each image: its copy is done
  VkSemaphore acquired = VK_NULL_HANDLE;
  VkExtent2D extent{};
};

/// A swapchain of `surface` with `size` pixels (or what the surface insists on), vertically synchronised; values are stored as they are
/// (display-encoded). `old` is retired and destroyed. The device must be idle.
Result<Swapchain> makeSwapchain(const Device& device, VkSurfaceKHR surface, VkExtent2D size, Swapchain* old);
void destroySwapchain(const Device& device, Swapchain& swapchain);

/// Copies `picture` (readable by transfers, kTransferRead) to image `index`, scaled to its size, and makes it ready to be shown.
void recordShow(VkCommandBuffer commands, const GpuImage& picture, const Swapchain& swapchain, std::uint32_t index);

}  // namespace overcast
