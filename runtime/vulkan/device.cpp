#include "runtime/vulkan/device.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <optional>

namespace overcast {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr std::size_t kKeptMessages = 64;

VKAPI_ATTR VkBool32 VKAPI_CALL collectMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                              const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
  auto* log = static_cast<ValidationLog*>(user);
  const std::lock_guard lock(log->mutex);
  ++log->count;
  if (log->texts.size() < kKeptMessages) log->texts.emplace_back(data->pMessage);
  return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messengerInfo(ValidationLog* log) {
  VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  info.pfnUserCallback = collectMessage;
  info.pUserData = log;
  return info;
}

bool layerInstalled(const char* name) {
  std::uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(), [&](const auto& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

Result<VkInstance> makeInstance(const DeviceSettings& settings, ValidationLog* log) {
  std::uint32_t version = VK_API_VERSION_1_0;
  vkEnumerateInstanceVersion(&version);
  if (version < VK_API_VERSION_1_3) return Error{"", "", "the Vulkan loader is older than Vulkan 1.3"};

  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "overcast";
  application.apiVersion = VK_API_VERSION_1_3;
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  std::vector<const char*> extensions;
  for (const std::string& extension : settings.instanceExtensions) extensions.push_back(extension.c_str());

  const VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &enabled;
  VkDebugUtilsMessengerCreateInfoEXT messenger = messengerInfo(log);
  if (log) {
    if (!layerInstalled(kValidationLayer))
      return Error{"", "", "validation was asked for, but VK_LAYER_KHRONOS_validation is not installed (package vulkan-validationlayers)"};
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kValidationLayer;
    messenger.pNext = &features;
    info.pNext = &messenger;
  }
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  VkInstance instance = VK_NULL_HANDLE;
  const VkResult made = vkCreateInstance(&info, nullptr, &instance);
  if (made == VK_ERROR_INCOMPATIBLE_DRIVER) return Error{"", "", "no Vulkan driver is installed"};
  if (made != VK_SUCCESS) return vulkanError(made, "cannot start Vulkan");
  return instance;
}

std::vector<VkPhysicalDevice> physicalDevices(VkInstance instance) {
  std::uint32_t count = 0;
  if (vkEnumeratePhysicalDevices(instance, &count, nullptr) != VK_SUCCESS) return {};
  std::vector<VkPhysicalDevice> devices(count);
  vkEnumeratePhysicalDevices(instance, &count, devices.data());
  return devices;
}

std::optional<std::uint32_t> mainQueueFamily(VkPhysicalDevice physical, std::uint32_t* timestampBits) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  constexpr VkQueueFlags kNeeded = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (std::uint32_t i = 0; i < count; ++i) {
    if ((families[i].queueFlags & kNeeded) != kNeeded) continue;
    if (timestampBits) *timestampBits = families[i].timestampValidBits;
    return i;
  }
  return std::nullopt;
}

/// Features with their chain; not copied, since the structs point at each other.
struct Features {
  VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
  VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  Features() { core.pNext = &v13; }
  Features(const Features&) = delete;
  Features& operator=(const Features&) = delete;
};

std::string missing(VkPhysicalDevice physical, const VkPhysicalDeviceProperties& properties) {
  if (properties.apiVersion < VK_API_VERSION_1_3) return "older than Vulkan 1.3";
  if (!mainQueueFamily(physical, nullptr)) return "no queue for graphics and compute";
  Features features;
  vkGetPhysicalDeviceFeatures2(physical, &features.core);
  if (!features.v13.synchronization2) return "no synchronization2";
  if (!features.v13.dynamicRendering) return "no dynamic rendering";
  if (!features.v13.maintenance4) return "no maintenance4";
  if (!features.core.features.shaderStorageImageExtendedFormats) return "no storage images of 16-bit floats";
  return "";
}

const char* kindOf(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "CPU";
    default:
      return "other";
  }
}

DeviceInfo describe(VkPhysicalDevice physical, int index) {
  VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  vkGetPhysicalDeviceProperties(physical, &properties.properties);
  const std::uint32_t version = properties.properties.apiVersion;
  if (version >= VK_API_VERSION_1_2) {
    properties.pNext = &driver;
    vkGetPhysicalDeviceProperties2(physical, &properties);
  }
  DeviceInfo info;
  info.index = index;
  info.name = properties.properties.deviceName;
  info.kind = kindOf(properties.properties.deviceType);
  info.driver = fmt::format("{} {}", driver.driverName, driver.driverInfo);
  info.apiVersion = fmt::format("{}.{}.{}", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version), VK_API_VERSION_PATCH(version));
  info.reason = missing(physical, properties.properties);
  info.usable = info.reason.empty();
  return info;
}

std::vector<DeviceInfo> describeAll(const std::vector<VkPhysicalDevice>& devices) {
  std::vector<DeviceInfo> infos;
  for (std::size_t i = 0; i < devices.size(); ++i) infos.push_back(describe(devices[i], static_cast<int>(i)));
  return infos;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string known(const std::vector<DeviceInfo>& infos) {
  std::string list;
  for (const DeviceInfo& info : infos) list += fmt::format("{}{}: {}", list.empty() ? "" : ", ", info.index, info.name);
  return list;
}

Result<int> bestDevice(const std::vector<DeviceInfo>& infos) {
  constexpr std::array<const char*, 5> kOrder{"discrete GPU", "integrated GPU", "virtual GPU", "other", "CPU"};
  for (const char* kind : kOrder)
    for (const DeviceInfo& info : infos)
      if (info.usable && info.kind == kind) return info.index;
  if (infos.empty()) return Error{"", "", "no Vulkan device was found (without a GPU, install package mesa-vulkan-drivers)"};
  return Error{"", "", fmt::format("no usable Vulkan 1.3 device: {} has {}", infos.front().name, infos.front().reason)};
}

Result<int> chooseDevice(const std::vector<DeviceInfo>& infos, const std::string& wanted) {
  if (wanted.empty() || infos.empty()) return bestDevice(infos);
  std::vector<int> matches;
  const bool number = wanted.size() < 4 && std::all_of(wanted.begin(), wanted.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  for (const DeviceInfo& info : infos)
    if (number ? info.index == std::stoi(wanted) : lower(info.name).find(lower(wanted)) != std::string::npos) matches.push_back(info.index);
  if (matches.empty()) return Error{"", "", fmt::format("no Vulkan device matches '{}'; there is {}", wanted, known(infos))};
  if (matches.size() > 1) return Error{"", "", fmt::format("several Vulkan devices match '{}'; there is {}", wanted, known(infos))};
  const DeviceInfo& info = infos[static_cast<std::size_t>(matches.front())];
  if (!info.usable) return Error{"", "", fmt::format("device {} cannot be used: {}", info.name, info.reason)};
  return info.index;
}

Result<Done> makeLogicalDevice(Device& device, bool swapchain) {
  device.queueFamily = *mainQueueFamily(device.physical, &device.timestampBits);
  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = device.queueFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  Features features;
  features.v13.synchronization2 = VK_TRUE;
  features.v13.dynamicRendering = VK_TRUE;
  features.v13.maintenance4 = VK_TRUE;
  features.core.features.shaderStorageImageExtendedFormats = VK_TRUE;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
  info.pNext = &features.core;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  const char* extension = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
  info.enabledExtensionCount = swapchain ? 1 : 0;
  info.ppEnabledExtensionNames = &extension;
  VkResult made = vkCreateDevice(device.physical, &info, nullptr, &device.device);
  if (made != VK_SUCCESS) return vulkanError(made, fmt::format("cannot open device {}", device.info.name));
  vkGetDeviceQueue(device.device, device.queueFamily, 0, &device.queue);

  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = device.queueFamily;
  made = vkCreateCommandPool(device.device, &pool, nullptr, &device.commandPool);
  if (made != VK_SUCCESS) return vulkanError(made, "cannot make a command pool");
  return Done{};
}

Result<Done> fillDevice(Device& device, const DeviceSettings& settings) {
  Result<VkInstance> instance = makeInstance(settings, device.validation.get());
  if (!instance) return instance.error();
  device.instance = instance.value();
  if (device.validation) {
    const auto create =
        reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(device.instance, "vkCreateDebugUtilsMessengerEXT"));
    const VkDebugUtilsMessengerCreateInfoEXT info = messengerInfo(device.validation.get());
    const VkResult made = create(device.instance, &info, nullptr, &device.messenger);
    if (made != VK_SUCCESS) return vulkanError(made, "cannot listen to validation");
  }
  const std::vector<VkPhysicalDevice> devices = physicalDevices(device.instance);
  const std::vector<DeviceInfo> infos = describeAll(devices);
  const Result<int> chosen = chooseDevice(infos, settings.device);
  if (!chosen) return chosen.error();
  const auto index = static_cast<std::size_t>(chosen.value());
  device.physical = devices[index];
  device.info = infos[index];
  vkGetPhysicalDeviceProperties(device.physical, &device.properties);
  vkGetPhysicalDeviceMemoryProperties(device.physical, &device.memory);
  return makeLogicalDevice(device, settings.swapchain);
}

}  // namespace

std::vector<DeviceInfo> listDevices() {
  const Result<VkInstance> instance = makeInstance({}, nullptr);
  if (!instance) return {};
  std::vector<DeviceInfo> infos = describeAll(physicalDevices(instance.value()));
  vkDestroyInstance(instance.value(), nullptr);
  return infos;
}

Result<Device> openDevice(const DeviceSettings& settings) {
  Device device;
  if (settings.validation) device.validation = std::make_unique<ValidationLog>();
  const Result<Done> filled = fillDevice(device, settings);
  if (!filled) {
    closeDevice(device);
    return filled.error();
  }
  return device;
}

void closeDevice(Device& device) {
  if (device.device) {
    vkDeviceWaitIdle(device.device);
    vkDestroyCommandPool(device.device, device.commandPool, nullptr);
    vkDestroyDevice(device.device, nullptr);
  }
  if (device.messenger) {
    const auto destroy =
        reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(device.instance, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(device.instance, device.messenger, nullptr);
  }
  if (device.instance) vkDestroyInstance(device.instance, nullptr);
  device.commandPool = VK_NULL_HANDLE;
  device.device = VK_NULL_HANDLE;
  device.messenger = VK_NULL_HANDLE;
  device.instance = VK_NULL_HANDLE;
}

std::uint64_t validationMessages(const Device& device) {
  if (!device.validation) return 0;
  const std::lock_guard lock(device.validation->mutex);
  return device.validation->count;
}

Error vulkanError(VkResult result, const std::string& what) {
  std::string reason;
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
      reason = "out of host memory";
      break;
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
      reason = "out of device memory";
      break;
    case VK_ERROR_DEVICE_LOST:
      reason = "the device was lost";
      break;
    case VK_ERROR_EXTENSION_NOT_PRESENT:
      reason = "a needed extension is missing";
      break;
    case VK_ERROR_LAYER_NOT_PRESENT:
      reason = "a needed layer is missing";
      break;
    case VK_ERROR_FORMAT_NOT_SUPPORTED:
      reason = "the format is not supported";
      break;
    case VK_ERROR_INITIALIZATION_FAILED:
      reason = "initialisation failed";
      break;
    default:
      reason = fmt::format("Vulkan error {}", static_cast<int>(result));
      break;
  }
  return {"", "", fmt::format("{}: {}", what, reason)};
}

Result<Done> runCommands(const Device& device, const std::function<void(VkCommandBuffer)>& record) {
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = device.commandPool;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkResult done = vkAllocateCommandBuffers(device.device, &allocate, &commands);
  if (done != VK_SUCCESS) return vulkanError(done, "cannot make a command buffer");

  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  vkBeginCommandBuffer(commands, &begin);
  record(commands);
  done = vkEndCommandBuffer(commands);
  if (done == VK_SUCCESS) {
    VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
    buffer.commandBuffer = commands;
    VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
    submit.commandBufferInfoCount = 1;
    submit.pCommandBufferInfos = &buffer;
    done = vkQueueSubmit2(device.queue, 1, &submit, VK_NULL_HANDLE);
  }
  if (done == VK_SUCCESS) done = vkQueueWaitIdle(device.queue);
  vkFreeCommandBuffers(device.device, device.commandPool, 1, &commands);
  if (done != VK_SUCCESS) return vulkanError(done, "cannot run commands on the device");
  return Done{};
}

}  // namespace overcast
