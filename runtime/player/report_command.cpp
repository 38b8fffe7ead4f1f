#include "runtime/player/report_command.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "formats/console.h"
#include "formats/files.h"
#include "runtime/player/command.h"
#include "runtime/player/options.h"
#include "runtime/report/compare.h"
#include "runtime/report/make_report.h"
#include "runtime/report/table.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<fs::path> scenes;
  fs::path output;
  fs::path reference;
  std::string device;
  std::string timedSize;
  MeasureSettings measure;
  bool quick = false;
  Wish wish;
  bool quiet = false;
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("SCENE", options.scenes,
                 "baked scenes (.gltf); those of one file name are bakes of one scene, shown together, the first as its own")
      ->required();
  app.add_option("-o,--output", options.output, "folder for report.html, report.csv, report.json and pictures")->required();
  app.add_option("--reference", options.reference,
                 "folder of overcast-bake reference, or of one such folder for each scene; told apart by what rays meet (default: the "
                 "folder reference beside the first scene)");
  app.add_option("--device", options.device, "index or part of the name of the Vulkan device (default: the best GPU, else the CPU)");
  app.add_option("--timed-size", options.timedSize, "WIDTHxHEIGHT in pixels of the frames that are timed (default 640x360)");
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.add_option("--rounds", options.measure.timing.rounds, "timed frames of the fastest settings")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--seconds", options.measure.timing.seconds,
                 "seconds on the device for each setting: slow ones are timed in fewer frames, in three at least")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--quick", options.quick, "fewer settings; the page says which are left out");
  auto* budget = app.add_option("--budget-ms", options.wish.budget,
                                "write the setting of the least error whose frame takes at most so many milliseconds into each scene");
  app.add_option("--max-error", options.wish.maxError, "write the fastest setting whose RMSE is at most this into each scene")
      ->check(CLI::PositiveNumber)
      ->excludes(budget->check(CLI::PositiveNumber));
  app.add_flag("--quiet", options.quiet, "do not say what is being measured");
  app.footer(
      "Exit codes: 0 done, 1 internal error, 2 usage, 3 unreadable scene or reference, 4 cannot write, 5 no usable device, 6 no setting "
      "keeps to --budget-ms or --max-error.");
}

/// What single options do not show.
void checkTogether(Options& options) {
  if (options.quick) options.measure.size = SweepSize::quick;
  if (options.reference.empty()) options.reference = options.scenes.front().parent_path() / "reference";
  if (options.timedSize.empty()) return;
  const auto size = parseSize(options.timedSize);
  if (!size) throw CLI::ValidationError("--timed-size", size.error().reason);
  std::tie(options.measure.timing.width, options.measure.timing.height) = size.value();
}

/// Writes the wished settings into the scenes and says so; the exit code.
int apply(const Options& options, const Report& report) {
  ExitCode code = ExitCode::ok;
  for (const ReportScene& scene : report.scenes) {
    const auto file =
        std::find_if(options.scenes.begin(), options.scenes.end(), [&](const fs::path& one) { return one.stem() == scene.name; });
    const auto row = applyWish(scene, *file, options.wish);
    if (!row) return fail(row.error(), ExitCode::unwritable);
    if (row.value() == nullptr) {
      code = ExitCode::unmet;
      fail({file->string(), "", "no setting that a scene can hold keeps to what was asked for; it stays as it was"}, code);
      continue;
    }
    printResult(fmt::format("{}: {} (RMSE {:.4f}, {:.2f} ms){}\n", scene.name, row.value()->setting, row.value()->errors.rmse,
                            row.value()->frame.median, row.value() == &scene.rows.front() ? ", as before" : ", written into the scene"));
  }
  return static_cast<int>(code);
}

int runReport(Options& options) {
  if (const auto writable = checkWritable(options.output); !writable) return fail(writable.error(), ExitCode::unwritable);
  auto device = openDevice({options.device, false, {}, false});
  if (!device) return fail(device.error(), ExitCode::noDevice);
  if (!options.quiet) options.measure.progress = [](const std::string& what) { printMessage(oneLine(what) + "\n"); };
  const auto report = makeReport(device.value(), {options.scenes, options.reference, options.output, options.measure});
  closeDevice(device.value());
  if (!report) return fail(report.error(), report.error().file.empty() ? ExitCode::noDevice : ExitCode::unreadable);
  printResult(summaryMarkdown(report.value()));
  return options.wish.budget || options.wish.maxError ? apply(options, report.value()) : static_cast<int>(ExitCode::ok);
}

}  // namespace

int reportCommand(int argc, char** argv) {
  CLI::App app("Measures error, time and memory of every way to light scenes and writes a page, a table and JSON.",
               "overcast-player report");
  Options options;
  addOptions(app, options);
  if (const auto code = parseArguments(app, argc, argv, [&] { checkTogether(options); })) return *code;
  return runReport(options);
}

int compareCommand(int argc, char** argv) {
  CLI::App app("Prints what changed between two reports, beyond noise.", "overcast-player compare");
  fs::path before, after;
  app.add_option("BEFORE", before, "report.json of overcast-player report")->required();
  app.add_option("AFTER", after, "another, of the same scenes")->required();
  app.footer(
      "Exit codes: 0 nothing got worse, 2 usage, 3 unreadable report, 6 something got worse beyond the noise that both reports state, or "
      "is gone.");
  if (const auto code = parseArguments(app, argc, argv)) return *code;
  const auto was = readReport(before), is = readReport(after);
  for (const auto* report : {&was, &is})
    if (!*report) return fail(report->error(), ExitCode::unreadable);
  const Comparisons comparisons = compareReports(was.value(), is.value());
  printResult(comparisonText(comparisons));
  return static_cast<int>(regressed(comparisons) ? ExitCode::unmet : ExitCode::ok);
}

}  // namespace overcast
