#include "runtime/player/window.h"

#include <chrono>
#include <filesystem>

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>

#include "formats/console.h"
#include "runtime/frame.h"
#include "runtime/orbit.h"
#include "runtime/player/swapchain.h"

namespace overcast {
namespace {

using Clock = std::chrono::steady_clock;

/// What the callbacks of the window change.
struct Controls {
  std::optional<Orbit> orbit;  ///< from the first touch of the mouse on
  Orbit start;                 ///< the orbit of the view shown last
  glm::dvec2 mouse{0.0};
  bool paused = false;
  bool save = false;
};

/// A window's things on the device.
struct Screen {
  VkSurfaceKHR surface = VK_NULL_HANDLE;
  Swapchain swapchain;
  FrameRenderer renderer;
  bool stale = true;  ///< the swapchain does not fit the window
};

Controls& controlsOf(GLFWwindow* window) {
  return *static_cast<Controls*>(glfwGetWindowUserPointer(window));
}

Orbit& touched(Controls& controls) {
  if (!controls.orbit) controls.orbit = controls.start;
  return *controls.orbit;
}

void onMouse(GLFWwindow* window, double x, double y) {
  Controls& controls = controlsOf(window);
  const glm::dvec2 moved = glm::dvec2(x, y) - controls.mouse;
  controls.mouse = {x, y};
  int width = 1, height = 1;
  glfwGetWindowSize(window, &width, &height);
  if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS) turn(touched(controls), moved, height);
  if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS) pan(touched(controls), moved, height);
}

void onWheel(GLFWwindow* window, double, double steps) {
  zoom(touched(controlsOf(window)), steps);
}

void onKey(GLFWwindow* window, int key, int, int action, int) {
  if (action != GLFW_PRESS) return;
  Controls& controls = controlsOf(window);
  if (key == GLFW_KEY_SPACE) controls.paused = !controls.paused;
  if (key == GLFW_KEY_F12) controls.save = true;
  if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(window, GLFW_TRUE);
}

/// Swapchain and frame as large as the window is now.
Result<Done> fit(const Device& device, GLFWwindow* window, Screen& screen) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  if (width == 0 || height == 0) {  // minimised
    glfwWaitEventsTimeout(0.1);
    return Done{};
  }
  vkDeviceWaitIdle(device.device);
  const VkExtent2D size{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
  Result<Swapchain> made = makeSwapchain(device, screen.surface, size, screen.swapchain.swapchain ? &screen.swapchain : nullptr);
  if (!made) return made.error();
  screen.swapchain = std::move(made).value();
  screen.stale = false;
  return resizeFrames(device, screen.renderer, static_cast<int>(screen.swapchain.extent.width),
                      static_cast<int>(screen.swapchain.extent.height));
}

VkResult submit(const Device& device, Screen& screen, std::uint32_t index) {
  VkSemaphoreSubmitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
  wait.semaphore = screen.swapchain.acquired;
  wait.stageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
  VkSemaphoreSubmitInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
  signal.semaphore = screen.swapchain.rendered[index];
  signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
  buffer.commandBuffer = screen.renderer.commands;
  VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
  info.waitSemaphoreInfoCount = info.commandBufferInfoCount = info.signalSemaphoreInfoCount = 1;
  info.pWaitSemaphoreInfos = &wait;
  info.pCommandBufferInfos = &buffer;
  info.pSignalSemaphoreInfos = &signal;
  VkResult result = vkQueueSubmit2(device.queue, 1, &info, screen.renderer.done);
  if (result == VK_SUCCESS) result = vkWaitForFences(device.device, 1, &screen.renderer.done, VK_TRUE, UINT64_MAX);
  if (result == VK_SUCCESS) result = vkResetFences(device.device, 1, &screen.renderer.done);
  return result;
}

/// Draws and shows one frame; a swapchain that no longer fits makes the screen stale.
Result<Done> show(const Device& device, const RuntimeScene& scene, Screen& screen, double time, const View& view) {
  std::uint32_t index = 0;
  VkResult result =
      vkAcquireNextImageKHR(device.device, screen.swapchain.swapchain, UINT64_MAX, screen.swapchain.acquired, VK_NULL_HANDLE, &index);
  screen.stale = result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR;
  if (result == VK_ERROR_OUT_OF_DATE_KHR) return Done{};
  if (result != VK_SUCCESS && result != VK_SUBOPTIMAL_KHR) return vulkanError(result, "cannot draw in the window");
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  vkBeginCommandBuffer(screen.renderer.commands, &begin);
  recordFrame(screen.renderer.commands, screen.renderer, scene, time, view);
  recordShow(screen.renderer.commands, screen.renderer.targets.tonemap.display, screen.swapchain, index);
  result = vkEndCommandBuffer(screen.renderer.commands);
  if (result == VK_SUCCESS) result = submit(device, screen, index);
  if (result != VK_SUCCESS) return vulkanError(result, "cannot draw a frame");
  VkPresentInfoKHR present{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
  present.waitSemaphoreCount = present.swapchainCount = 1;
  present.pWaitSemaphores = &screen.swapchain.rendered[index];
  present.pSwapchains = &screen.swapchain.swapchain;
  present.pImageIndices = &index;
  result = vkQueuePresentKHR(device.queue, &present);
  screen.stale = screen.stale || result == VK_ERROR_OUT_OF_DATE_KHR || result == VK_SUBOPTIMAL_KHR;
  if (result < 0 && result != VK_ERROR_OUT_OF_DATE_KHR) return vulkanError(result, "cannot show a frame");
  return Done{};
}

/// Saves the picture on the screen as the first overcast_NNNN.png that is not there yet.
std::optional<Failure> savePicture(const Device& device, const FrameRenderer& renderer) {
  int number = 1;
  while (std::filesystem::exists(fmt::format("overcast_{:04}.png", number))) ++number;
  const std::string file = fmt::format("overcast_{:04}.png", number);
  const Result<Image> picture = readDisplay(device, renderer);
  if (!picture) return Failure{picture.error(), ExitCode::noDevice};
  const Result<Done> written = writePng(file, picture.value());
  if (!written) return Failure{written.error(), ExitCode::unwritable};
  printMessage(fmt::format("overcast-player: saved {}\n", file));
  return std::nullopt;
}

std::optional<Failure> loop(const Device& device, const RuntimeScene& scene, const PlayerOptions& options, GLFWwindow* window,
                            Controls& controls, Screen& screen) {
  double time = options.firstFrame / options.framesPerSecond;
  Clock::time_point before = Clock::now();
  while (!glfwWindowShouldClose(window)) {
    glfwPollEvents();
    int width = 0, height = 0;
    glfwGetFramebufferSize(window, &width, &height);
    const FrameSettings& size = screen.renderer.settings;
    if (screen.stale || width != size.width || height != size.height) {
      const Result<Done> fitted = fit(device, window, screen);
      if (!fitted) return Failure{fitted.error(), ExitCode::noDevice};
      if (screen.stale) continue;
    }
    const Clock::time_point now = Clock::now();
    if (!controls.paused) time += std::chrono::duration<double>(now - before).count();
    before = now;
    PlayerOptions seen = options;
    seen.width = size.width;
    seen.height = size.height;
    const View view = controls.orbit ? viewOf(*controls.orbit) : viewOf(seen, scene, time);
    if (!controls.orbit) controls.start = orbitLike(view, centre(scene.bounds), diagonal(scene.bounds));
    const Result<Done> shown = show(device, scene, screen, time, view);
    if (!shown) return Failure{shown.error(), ExitCode::noDevice};
    if (std::exchange(controls.save, false))
      if (auto failure = savePicture(device, screen.renderer)) return failure;
  }
  return std::nullopt;
}

}  // namespace

Result<Window> openWindow(const PlayerOptions& options) {
  Window window;
  if (!glfwInit()) return Error{"", "", "there is no display to open a window on: use --headless"};
  std::uint32_t count = 0;
  const char** extensions = glfwGetRequiredInstanceExtensions(&count);
  window.instanceExtensions.assign(extensions, extensions + count);
  glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
  if (extensions)
    window.handle =
        glfwCreateWindow(options.width, options.height, ("Overcast: " + options.scene.filename().string()).c_str(), nullptr, nullptr);
  if (!window.handle) {
    glfwTerminate();
    return Error{"", "", "cannot open a window for Vulkan: use --headless"};
  }
  return window;
}

void closeWindow(Window& window) {
  glfwDestroyWindow(window.handle);
  glfwTerminate();
  window = {};
}

std::optional<Failure> playInWindow(const Device& device, const RuntimeScene& scene, const PlayerOptions& options, const Window& window) {
  Controls controls;
  glfwSetWindowUserPointer(window.handle, &controls);
  glfwSetCursorPosCallback(window.handle, onMouse);
  glfwSetScrollCallback(window.handle, onWheel);
  glfwSetKeyCallback(window.handle, onKey);
  Screen screen;
  const VkResult surface = glfwCreateWindowSurface(device.instance, window.handle, nullptr, &screen.surface);
  if (surface != VK_SUCCESS) return Failure{vulkanError(surface, "cannot draw in the window"), ExitCode::noDevice};
  std::optional<Failure> failure;
  Result<FrameRenderer> renderer = makeFrameRenderer(device, scene, frameSettings(options));
  if (renderer) {
    screen.renderer = std::move(renderer).value();
    failure = loop(device, scene, options, window.handle, controls, screen);
    vkDeviceWaitIdle(device.device);
    destroySwapchain(device, screen.swapchain);
    destroyFrameRenderer(device, screen.renderer);
  } else {
    failure = Failure{renderer.error(), renderer.error().file.empty() ? ExitCode::noDevice : ExitCode::internal};
  }
  vkDestroySurfaceKHR(device.instance, screen.surface, nullptr);
  return failure;
}

}  // namespace overcast
