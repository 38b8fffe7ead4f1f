// overcast-player: plays a baked scene.
#include <cstdio>

#include "runtime/player/headless.h"
#include "runtime/player/options.h"
#include "runtime/player/report.h"
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

/// Loads and plays on an open device; the exit code.
int playOn(const Device& device, const PlayerOptions& options) {
  Result<RuntimeScene> scene = loadScene(device, options.scene);
  if (!scene) return fail(scene.error(), scene.error().file.empty() ? ExitCode::noDevice : ExitCode::unreadable);
  for (const std::string& note : scene.value().scene.notes) fmt::print(stderr, "overcast-player: note: {}\n", note);
  PlayResult result;
  const auto failure = playHeadless(device, scene.value(), options, result);
  destroyScene(device, scene.value());
  if (failure) return fail(failure->error, failure->code);
  fmt::print("{}", options.json ? json(options, result) : table(result));
  if (!options.json && !result.pictures.empty())
    fmt::print("pictures: {}{}\n", result.pictures.front(), result.pictures.size() > 1 ? " to " + result.pictures.back() : "");
  return static_cast<int>(ExitCode::ok);
}

int run(const PlayerOptions& options) {
  if (options.listDevices) return listDevicesTo(stdout, options.json);
  if (!options.headless) return fail({"", "", "there is no window yet: use --headless"}, ExitCode::usage);
  Result<Device> device = openDevice({options.device, options.validate, {}, false});
  if (!device) return fail(device.error(), ExitCode::noDevice);
  int code = playOn(device.value(), options);
  closeDevice(device.value());
  if (const std::uint64_t messages = validationMessages(device.value())) {
    for (const std::string& text : device.value().validation->texts) fmt::print(stderr, "{}\n", text);
    code = fail({"", "", fmt::format("{} validation messages", messages)}, ExitCode::internal);
  }
  return code;
}

}  // namespace
}  // namespace overcast

int main(int argc, char** argv) {
  const overcast::ParsedOptions parsed = overcast::parseOptions(argc, argv);
  return parsed.exitCode ? *parsed.exitCode : overcast::run(parsed.options);
}
