#include "runtime/player/cost_command.h"

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

#include "formats/console.h"
#include "formats/files.h"
#include "runtime/composite_cost.h"
#include "runtime/player/command.h"

namespace overcast {
namespace {

struct Options {
  CostSettings settings;
  std::filesystem::path output;
  std::string device;
  bool quiet = false;
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("-o,--output", options.output, "file for the costs, JSON, for overcast-bake explain --costs (default: stdout)");
  app.add_option("--device", options.device, "index or part of the name of the Vulkan device (default: the best GPU, else the CPU)");
  app.add_option("--runs", options.settings.runs, "timed runs of each kind")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--objects", options.settings.objects, "objects evaluated at every voxel")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--voxels", options.settings.voxels, "voxels along the side of the volume, a multiple of 8")
      ->check(CLI::Range(8, 256))
      ->capture_default_str();
  app.add_option("--largest", options.settings.largest, "largest size of an occluder")->check(CLI::Range(8, 256))->capture_default_str();
  app.add_flag("--quiet", options.quiet, "no table on stderr");
}

std::string table(const CompositeCosts& costs) {
  std::string lines = fmt::format("device: {} ({}, {})\n{} objects at {}^3 voxels, nanoseconds of one evaluation, {} runs\n", costs.device,
                                  costs.kind, costs.driver, costs.objects, costs.voxels, costs.runs);
  lines += fmt::format("{:<24} {:>9} {:>9} {:>9}\n", "occluder", "median", "fastest", "slowest");
  for (const CompositeCost& cost : costs.costs) {
    std::string what = name(cost.representation);
    if (!cost.variant.empty()) what += " " + cost.variant;
    if (cost.size > 0) what += fmt::format(" {}", cost.size);
    if (cost.bits > 0) what += fmt::format(", {} bits", cost.bits);
    lines += fmt::format("{:<24} {:>9.3f} {:>9.3f} {:>9.3f}\n", what, cost.median, cost.least, cost.most);
  }
  return lines;
}

int measureAndWrite(const Options& options) {
  Result<Device> device = openDevice({options.device, false, {}, false});
  if (!device) return fail(device.error(), ExitCode::noDevice);
  const auto costs = measureCompositeCosts(device.value(), options.settings);
  closeDevice(device.value());
  if (!costs) return fail(costs.error(), ExitCode::noDevice);
  if (!options.quiet) printMessage(table(costs.value()));
  const std::string json = compositeCostsJson(costs.value());
  if (options.output.empty()) {
    printResult(json);
  } else if (const auto written = writeFileAtomically(options.output, json); !written) {
    return fail(written.error(), ExitCode::unwritable);
  }
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

int costCommand(int argc, char** argv) {
  CLI::App app("Measures what one evaluation of each kind of occluder takes in the composite on this device.", "overcast-player cost");
  Options options;
  addOptions(app, options);
  const auto check = [&] {
    if (options.settings.voxels % 8 != 0) throw CLI::ValidationError("--voxels", "is not a multiple of 8");
  };
  if (const auto code = parseArguments(app, argc, argv, check)) return *code;
  return measureAndWrite(options);
}

}  // namespace overcast
