// overcast-player: plays a baked scene.
#include <cstdio>

#include "runtime/player/headless.h"
#include "runtime/player/options.h"
#include "runtime/player/report.h"
#include "runtime/player/window.h"
#include "runtime/scene.h"

namespace overcast {
namespace {

int fail(const Error& error, ExitCode code) {
  fmt::print(stderr, "overcast-player: {}\n", message(error));
  return static_cast<int>(code);
}

int listDevicesTo(std::FILE* out, bool asJson) {
  const std::vector<DeviceInfo> devices = listDevices();
  fmt::print(out, "{}", asJson ? json(devices) : table(devices));
  if (devices.empty()) return fail({"", "", "no Vulkan device was found"}, ExitCode::noDevice);
  return static_cast<int>(ExitCode::ok);
}

std::optional<Failure> playPictures(const Device& device, const RuntimeScene& scene, const PlayerOptions& options) {
  PlayResult result;
  if (auto failure = playHeadless(device, scene, options, result)) return failure;
  fmt::print("{}", options.json ? json(options, result) : table(result));
  if (!options.json && !result.pictures.empty())
    fmt::print("pictures: {}{}\n", result.pictures.front(), result.pictures.size() > 1 ? " to " + result.pictures.back() : "");
  return std::nullopt;
}

/// Loads and plays on an open device; the exit code.
int playOn(const Device& device, const PlayerOptions& options, const Window& window) {
  Result<RuntimeScene> scene = loadScene(device, options.scene);
  if (!scene) return fail(scene.error(), scene.error().file.empty() ? ExitCode::noDevice : ExitCode::unreadable);
  for (const std::string& note : scene.value().scene.notes) fmt::print(stderr, "overcast-player: note: {}\n", note);
  const auto failure =
      options.headless ? playPictures(device, scene.value(), options) : playInWindow(device, scene.value(), options, window);
  destroyScene(device, scene.value());
  return failure ? fail(failure->error, failure->code) : static_cast<int>(ExitCode::ok);
}

/// Plays on the device that the options name; the exit code.
int play(const PlayerOptions& options, const Window& window) {
  Result<Device> device = openDevice({options.device, options.validate, window.instanceExtensions, !options.headless});
  if (!device) return fail(device.error(), ExitCode::noDevice);
  int code = playOn(device.value(), options, window);
  closeDevice(device.value());
  if (const std::uint64_t messages = validationMessages(device.value())) {
    for (const std::string& text : device.value().validation->texts) fmt::print(stderr, "{}\n", text);
    code = fail({"", "", fmt::format("{} validation messages", messages)}, ExitCode::internal);
  }
  return code;
}

int run(const PlayerOptions& options) {
  if (options.listDevices) return listDevicesTo(stdout, options.json);
  if (options.headless) return play(options, {});
  Result<Window> window = openWindow(options);
  if (!window) return fail(window.error(), ExitCode::usage);
  const int code = play(options, window.value());
  closeWindow(window.value());
  return code;
}

}  // namespace
}  // namespace overcast

int main(int argc, char** argv) {
  const overcast::ParsedOptions parsed = overcast::parseOptions(argc, argv);
  return parsed.exitCode ? *parsed.exitCode : overcast::run(parsed.options);
}
