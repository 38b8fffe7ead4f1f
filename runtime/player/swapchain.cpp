#include "runtime/player/swapchain.h"

#include <algorithm>

namespace overcast {
namespace {

Result<VkSurfaceFormatKHR> chooseFormat(const Device& device, VkSurfaceKHR surface) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical, surface, &count, nullptr);
  std::vector<VkSurfaceFormatKHR> formats(count);
  vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical, surface, &count, formats.data());
  for (const VkSurfaceFormatKHR& format : formats) {
    const bool plain = format.format == VK_FORMAT_B8G8R8A8_UNORM || format.format == VK_FORMAT_R8G8B8A8_UNORM;
    if (plain && format.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) return format;
  }
  return Error{"", "", "the window has no 8-bit format: use --headless"};
}

Result<VkSemaphore> makeSemaphore(const Device& device) {
  const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
  VkSemaphore semaphore = VK_NULL_HANDLE;
  const VkResult made = vkCreateSemaphore(device.device, &info, nullptr, &semaphore);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a semaphore");
  return semaphore;
}

Result<Done> collectImages(const Device& device, VkFormat format, Swapchain& swapchain) {
  std::uint32_t count = 0;
  vkGetSwapchainImagesKHR(device.device, swapchain.swapchain, &count, nullptr);
  std::vector<VkImage> images(count);
  vkGetSwapchainImagesKHR(device.device, swapchain.swapchain, &count, images.data());
  for (VkImage handle : images) {
    GpuImage image;
    image.image = handle;
    image.format = format;
    image.extent = {swapchain.extent.width, swapchain.extent.height, 1};
    swapchain.images.push_back(image);
    const Result<VkSemaphore> rendered = makeSemaphore(device);
    if (!rendered) return rendered.error();
    swapchain.rendered.push_back(rendered.value());
  }
  const Result<VkSemaphore> acquired = makeSemaphore(device);
  if (!acquired) return acquired.error();
  swapchain.acquired = acquired.value();
  return Done{};
}

}  // namespace

Result<Swapchain> makeSwapchain(const Device& device, VkSurfaceKHR surface, VkExtent2D size, Swapchain* old) {
  VkBool32 shown = VK_FALSE;
  vkGetPhysicalDeviceSurfaceSupportKHR(device.physical, device.queueFamily, surface, &shown);
  if (!shown) return Error{"", "", fmt::format("{} cannot show pictures in this window: use --headless", device.info.name)};
  const Result<VkSurfaceFormatKHR> format = chooseFormat(device, surface);
  if (!format) return format.error();
  VkSurfaceCapabilitiesKHR limits;
  vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device.physical, surface, &limits);
  Swapchain swapchain;
  swapchain.extent = {std::clamp(size.width, limits.minImageExtent.width, limits.maxImageExtent.width),
                      std::clamp(size.height, limits.minImageExtent.height, limits.maxImageExtent.height)};
  VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
  info.surface = surface;
  info.minImageCount = std::max(limits.minImageCount, limits.maxImageCount == 0 ? 3u : std::min(3u, limits.maxImageCount));
  info.imageFormat = format.value().format;
  info.imageColorSpace = format.value().colorSpace;
  info.imageExtent = swapchain.extent;
  info.imageArrayLayers = 1;
  info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  info.preTransform = limits.currentTransform;
  info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  info.presentMode = VK_PRESENT_MODE_FIFO_KHR;
  info.clipped = VK_TRUE;
  info.oldSwapchain = old ? old->swapchain : VK_NULL_HANDLE;
  const VkResult made = vkCreateSwapchainKHR(device.device, &info, nullptr, &swapchain.swapchain);
  if (old) destroySwapchain(device, *old);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a swapchain");
  const Result<Done> collected = collectImages(device, info.imageFormat, swapchain);
  if (collected) return swapchain;
  destroySwapchain(device, swapchain);
  return collected.error();
}

void destroySwapchain(const Device& device, Swapchain& swapchain) {
  for (VkSemaphore semaphore : swapchain.rendered) vkDestroySemaphore(device.device, semaphore, nullptr);
  vkDestroySemaphore(device.device, swapchain.acquired, nullptr);
  vkDestroySwapchainKHR(device.device, swapchain.swapchain, nullptr);
  swapchain = {};
}

void recordShow(VkCommandBuffer commands, const GpuImage& picture, const Swapchain& swapchain, std::uint32_t index) {
  const GpuImage& image = swapchain.images[index];
  // The wait for `acquired` is at the transfer stage: the layout change must come after it.
  const Access before{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_NONE, VK_IMAGE_LAYOUT_UNDEFINED};
  const Access after{VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR};
  const auto corner = [](const VkExtent3D& extent) {
    return VkOffset3D{static_cast<std::int32_t>(extent.width), static_cast<std::int32_t>(extent.height), 1};
  };
  transition(commands, image, before, kTransferWrite);
  VkImageBlit2 region{VK_STRUCTURE_TYPE_IMAGE_BLIT_2};
  region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.srcOffsets[1] = corner(picture.extent);
  region.dstOffsets[1] = corner(image.extent);
  VkBlitImageInfo2 blit{VK_STRUCTURE_TYPE_BLIT_IMAGE_INFO_2};
  blit.srcImage = picture.image;
  blit.srcImageLayout = kTransferRead.layout;
  blit.dstImage = image.image;
  blit.dstImageLayout = kTransferWrite.layout;
  blit.regionCount = 1;
  blit.pRegions = &region;
  blit.filter = VK_FILTER_NEAREST;
  vkCmdBlitImage2(commands, &blit);
  transition(commands, image, kTransferWrite, after);
}

}  // namespace overcast
