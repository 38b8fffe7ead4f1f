// The Vulkan device.
