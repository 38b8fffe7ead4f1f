// overcast-player: plays a baked scene.
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <string_view>

#include "formats/console.h"
#include "runtime/player/calibrate_command.h"
#include "runtime/player/command.h"
#include "runtime/player/cost_command.h"
#include "runtime/player/headless.h"
#include "runtime/player/measure_command.h"
#include "runtime/player/options.h"
#include "runtime/player/report.h"
#include "runtime/player/report_command.h"
#include "runtime/player/window.h"
#include "runtime/scene.h"
#include "runtime/vulkan/shader.h"

namespace overcast {
namespace {

/// Mesa maps its shader cache into memory, in the same folder as ours, and on a full disk it ends the process with SIGBUS: there it has to
/// do without. Its index alone takes 1.3 MB.
void keepDriverOffFullDisk() {
  constexpr std::uintmax_t kRoom = std::uintmax_t{16} << 20;
  std::filesystem::path folder = shaderCacheFolder();
  std::error_code code;
  while (!folder.empty() && folder != folder.parent_path() && !std::filesystem::exists(folder, code)) folder = folder.parent_path();
  const std::filesystem::space_info space = std::filesystem::space(folder, code);
  if (!code && space.available < kRoom) setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
}

int printDevices(bool asJson) {
  const std::vector<DeviceInfo> devices = listDevices();
  printResult(asJson ? json(devices) : table(devices));
  if (devices.empty()) return fail({"", "", "no Vulkan device was found"}, ExitCode::noDevice);
  return static_cast<int>(ExitCode::ok);
}

std::optional<Failure> playPictures(const Device& device, const RuntimeScene& scene, const PlayerOptions& options) {
  PlayResult result;
  if (auto failure = playHeadless(device, scene, options, result)) return failure;
  printResult(options.json ? json(options, result) : table(result));
  if (!options.json && !result.pictures.empty())
    printResult(
        fmt::format("pictures: {}{}\n", result.pictures.front(), result.pictures.size() > 1 ? " to " + result.pictures.back() : ""));
  return std::nullopt;
}

/// Loads and plays on an open device; the exit code.
int playOn(const Device& device, const PlayerOptions& options, const Window& window) {
  Result<RuntimeScene> scene = loadScene(device, options.scene);
  if (!scene) return fail(scene.error(), scene.error().file.empty() ? ExitCode::noDevice : ExitCode::unreadable);
  if (!options.sky.empty()) {
    const Result<SkyHarmonics> sky = readSky(options.sky);
    if (!sky) {
      destroyScene(device, scene.value());
      return fail(sky.error(), ExitCode::unreadable);
    }
    scene.value().sky = sky.value();
  }
  for (const std::string& note : scene.value().scene.notes) printMessage(oneLine("overcast-player: note: " + note) + "\n");
  const auto failure =
      options.headless ? playPictures(device, scene.value(), options) : playInWindow(device, scene.value(), options, window);
  destroyScene(device, scene.value());
  return failure ? fail(*failure) : static_cast<int>(ExitCode::ok);
}

/// Plays on the device that the options name; the exit code.
int play(const PlayerOptions& options, const Window& window) {
  Result<Device> device = openDevice({options.device, options.validate, window.instanceExtensions, !options.headless});
  if (!device) return fail(device.error(), ExitCode::noDevice);
  int code = playOn(device.value(), options, window);
  closeDevice(device.value());
  if (const std::uint64_t messages = validationMessages(device.value())) {
    for (const std::string& text : device.value().validation->texts) printMessage(text + "\n");
    code = fail({"", "", fmt::format("{} validation messages", messages)}, ExitCode::internal);
  }
  return code;
}

int run(const PlayerOptions& options) {
  if (options.listDevices) return printDevices(options.json);
  if (options.headless) return play(options, {});
  Result<Window> window = openWindow(options);
  if (!window) return fail(window.error(), ExitCode::usage);
  const int code = play(options, window.value());
  closeWindow(window.value());
  return code;
}

struct Subcommand {
  std::string_view name;
  int (*run)(int argc, char** argv);
};
constexpr Subcommand kSubcommands[] = {{"calibrate", calibrateCommand},
                                       {"compare", compareCommand},
                                       {"cost", costCommand},
                                       {"measure", measureCommand},
                                       {"report", reportCommand}};

int runCommand(int argc, char** argv) {
  for (const Subcommand& command : kSubcommands)
    if (argc > 1 && argv[1] == command.name) return command.run(argc - 1, argv + 1);
  const ParsedOptions parsed = parseOptions(argc, argv);
  return parsed.exitCode ? *parsed.exitCode : run(parsed.options);
}

}  // namespace
}  // namespace overcast

int main(int argc, char** argv) {
  using namespace overcast;
  holdStandardStreams();
  try {
    keepDriverOffFullDisk();
    const int code = runCommand(argc, argv);
    const auto flushed = flushResults();
    return flushed || code != 0 ? code : fail(flushed.error(), ExitCode::unwritable);
  } catch (const std::bad_alloc&) {
    return fail({"", "", "out of memory"}, ExitCode::internal);
  } catch (const std::exception& problem) {
    return fail({"", "", fmt::format("internal error: {}", problem.what())}, ExitCode::internal);
  }
}
