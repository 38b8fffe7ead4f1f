// The Vulkan device: choosing one, opening it, and what validation says about how it is used.
// Vulkan 1.3 core with synchronization2, dynamic rendering and maintenance4; no descriptor indexing (lavapipe of Mesa 22.3 has none).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <vulkan/vulkan.h>

#include "formats/result.h"

namespace overcast {

/// Which device to open and how.
struct DeviceSettings {
  std::string device;       ///< index in listDevices(), or part of a name (any case); empty: the best GPU, else a CPU device
  bool validation = false;  ///< core and synchronization validation; messages are collected in Device::validation
  std::vector<std::string> instanceExtensions;  ///< what a window system needs; empty for headless work
  bool swapchain = false;                       ///< open with VK_KHR_swapchain
};

/// One physical device as a user sees it.
struct DeviceInfo {
  int index = 0;
  std::string name;
  std::string kind;    ///< "discrete GPU", "integrated GPU", "virtual GPU", "CPU" or "other"
  std::string driver;  ///< driver name and version
  std::string apiVersion;
  bool usable = false;
  std::string reason;  ///< why it is not usable; empty when it is
};

/// What the validation layer said. Warnings and errors only; messages may come from any thread.
struct ValidationLog {
  std::mutex mutex;
  std::uint64_t count = 0;
  std::vector<std::string> texts;  ///< the first 64
};

/// An open device with one queue that does graphics, compute and transfers. Plain handles; closeDevice ends it. Used from one thread.
struct Device {
  VkInstance instance = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queueFamily = 0;
  VkCommandPool commandPool = VK_NULL_HANDLE;  ///< command buffers can be reset one by one
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory{};
  std::uint32_t timestampBits = 0;  ///< valid bits of a timestamp; 0: the queue has no timestamps
  DeviceInfo info;
  mutable std::uint64_t allocatedBytes = 0;   ///< device memory taken so far for MemoryUse::device; what was given back counts too
  std::unique_ptr<ValidationLog> validation;  ///< null without validation
};

/// All physical devices the Vulkan loader knows, in its order. Empty when there is no loader, driver or device.
std::vector<DeviceInfo> listDevices();

/// Opens a device. Errors: no Vulkan driver, no device with what we need, none or several that match `settings.device`, validation asked
/// for but the layer not installed.
Result<Device> openDevice(const DeviceSettings& settings = {});

/// Waits for the device and frees it. Everything made with it must be destroyed before. Safe on a default-constructed Device.
void closeDevice(Device& device);

/// Number of validation messages so far; 0 without validation.
std::uint64_t validationMessages(const Device& device);

/// "what: VK_ERROR_OUT_OF_DEVICE_MEMORY" and the like as an Error without a file.
Error vulkanError(VkResult result, const std::string& what);

/// Records commands into a fresh command buffer, submits it and waits until the device has done it. For setting up, not for frames.
Result<Done> runCommands(const Device& device, const std::function<void(VkCommandBuffer)>& record);

}  // namespace overcast
