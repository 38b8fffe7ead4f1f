// Window: plays a scene on the screen. Left mouse button turns, right pans, wheel zooms, space pauses, F12 saves a picture, Escape ends.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/result.h"
#include "runtime/player/headless.h"
#include "runtime/player/options.h"
#include "runtime/scene.h"
#include "runtime/vulkan/device.h"

struct GLFWwindow;

namespace overcast {

struct Window {
  GLFWwindow* handle = nullptr;
  std::vector<std::string> instanceExtensions;  ///< what the device must be opened with
};

/// An Error that tells to use --headless when there is no display.
Result<Window> openWindow(const PlayerOptions& options);
void closeWindow(Window& window);

/// Plays until the window is closed. The device was opened with the window's extensions and a swapchain.
std::optional<Failure> playInWindow(const Device& device, const RuntimeScene& scene, const PlayerOptions& options, const Window& window);

}  // namespace overcast
