#include "runtime/player/calibrate_command.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "formats/console.h"
#include "formats/extension_json.h"
#include "formats/scene_lighting.h"
#include "runtime/calibrate/calibrate.h"
#include "runtime/passes/shade/sky_estimator.h"
#include "runtime/player/command.h"
#include "runtime/player/headless.h"
#include "runtime/player/options.h"
#include "runtime/report/scene_truth.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

constexpr double kCommonPull = 1e-9;  // only keeps constants from drifting that nothing depends on
constexpr std::uint64_t kCommonStarts = 2;

struct Options {
  std::vector<fs::path> scenes;
  fs::path reference;
  std::string estimator;
  int taps = 0;
  std::size_t points = 6000;
  std::string device;
  bool dryRun = false;
  bool json = false;
};

/// What is fitted: the samples of all scenes, and the lighting of the first.
struct Job {
  CalibrationSamples samples;
  Lighting lighting;
  bool apertures = false;  ///< the first has some
  Estimator present;
  Estimator start;
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("SCENE", options.scenes, "baked scene (.gltf); of several one common set of constants is printed and nothing written")
      ->required();
  app.add_option("--reference", options.reference,
                 "folder of overcast-bake reference, views or points, or of one such folder for each scene (default: the folder reference "
                 "beside the first scene)");
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.add_option(
      "--estimator", options.estimator,
      fmt::format("published, calibrated, cones or hybrid (default: the scene's; where rays light it, which have no constants, {}, "
                  "or {} over apertures)",
                  tapsEstimator(false), tapsEstimator(true)));
  app.add_option("--taps", options.taps, "readings along a line (default: the scene's)")->check(CLI::Range(1, shared::kMaxTaps));
  app.add_option("--points", options.points, "of each scene that are fitted to, at most")
      ->check(CLI::Range(std::size_t{100}, std::size_t{1000000}))
      ->capture_default_str();
  app.add_option("--device", options.device, "index or part of the name of the Vulkan device (default: the best GPU, else the CPU)");
  app.add_flag("--dry-run", options.dryRun, "write nothing");
  app.add_flag("--json", options.json, "one JSON object instead of a table");
  app.footer(
      "Writes nothing either where the fit does no better, on frames and objects that were left out, than the constants there are.\nExit "
      "codes: 0 done, 1 internal error, 2 usage, 3 unreadable scene or reference, 4 cannot write, 5 no usable device.");
}

void checkTogether(Options& options) {
  if (!options.estimator.empty() && !canCalibrate(options.estimator))
    throw CLI::ValidationError("--estimator", fmt::format("'{}' is not an estimator that can be fitted", options.estimator));
  if (options.reference.empty()) options.reference = options.scenes.front().parent_path() / "reference";
}

/// The constants that the scene has under the name of the estimator that is asked for, or the program's.
Result<Estimator> presentOf(const Options& options, const fs::path& path, const RuntimeScene& scene) {
  const bool apertures = hasApertures(scene);
  const Estimator& own = scene.lighting.estimator;
  const std::string_view used = usedEstimator(own.name, apertures);
  Estimator present = own;
  present.name = !options.estimator.empty() ? options.estimator : readsTaps(used) ? used : tapsEstimator(apertures);
  if (present.name != own.name) present = Estimator{present.name, own.taps};
  if (!canCalibrate(present.name))
    return Error{path.string(), "", fmt::format("its estimator, {}, cannot be fitted: say which with --estimator", present.name)};
  if (options.taps > 0) present = withTaps(std::move(present), options.taps);
  return withOwnConstants(std::move(present));
}

/// The program's constants for that estimator.
Estimator startOf(const Estimator& present) {
  Estimator start;
  start.name = present.name;
  start.taps = present.taps;
  start = withOwnConstants(std::move(start));
  if (present.cones && start.cones) start.cones->directions = present.cones->directions;
  return start;
}

/// Those that are tried, and the present one: only `published` has any, and of several scenes the constants are to go with the program's.
std::vector<float> skyWeightsOf(const Options& options, const Job& job) {
  std::set<float> weights{job.start.skyWeight, job.present.skyWeight};
  if (options.scenes.size() == 1 && job.start.name == "published") weights.insert({0.25f, 0.375f, 0.5f});
  return {weights.begin(), weights.end()};
}

std::optional<Failure> addScene(const Device& device, const Options& options, const fs::path& path, Job& job) {
  auto loaded = loadScene(device, path);
  if (!loaded) return Failure{loaded.error(), loaded.error().file.empty() ? ExitCode::noDevice : ExitCode::unreadable};
  RuntimeScene& scene = loaded.value();
  const bool first = job.samples.skyWeights.empty();
  const auto add = [&]() -> std::optional<Failure> {
    if (first) {
      const auto present = presentOf(options, path, scene);
      if (!present) return Failure{present.error(), ExitCode::unreadable};
      job.present = present.value();
      job.start = startOf(job.present);
      job.lighting = scene.lighting;
      job.apertures = hasApertures(scene);
      job.samples.resolution = scene.lighting.globalVolume.resolution;
      job.samples.skyWeights = skyWeightsOf(options, job);
    }
    const auto references = readReferences(options.reference, path);
    if (!references) return Failure{references.error(), ExitCode::unreadable};
    const auto added = addSamples(device, scene, references.value(), job.start, options.points, job.samples);
    if (!added) return Failure{added.error(), ExitCode::noDevice};
    return std::nullopt;
  };
  auto failure = add();
  destroyScene(device, scene);
  return failure;
}

template <class Values>
std::size_t distinct(const Values& values) {
  return std::set(values.begin(), values.end()).size();
}

/// The constants as runtime/passes/shade/calibrated_constants.cpp has them.
std::string sourceOf(const Estimator& estimator) {
  std::string text;
  for (const SkyStep& step : estimator.steps)
    text += fmt::format("{{{{{:.4g}}}, {{{:.4g}}}, {:.4g}, {:.4g}, {:.4g}}},\n", fmt::join(step.weights, ", "), fmt::join(step.gaps, ", "),
                        step.start, step.slant, step.height);
  return text;
}

std::string textOf(const Job& job, const Calibration& made) {
  const Estimator& estimator = made.estimator;
  std::string text = fmt::format("{}, {} taps: {} points of {} frames and {} objects or parts of large ones\n", estimator.name,
                                 estimator.taps, job.samples.sky.size(), distinct(job.samples.frames), distinct(job.samples.objects));
  const auto row = [&](const char* what, double error) {
    text += fmt::format("  {:<36}{}\n", what, error < 0.0 ? "too few to leave out" : fmt::format("{:.4f}", error));
  };
  row("RMSE of the constants before", made.startError);
  row("RMSE of the fit", estimator.fitError);
  row("RMSE of a fit without these frames", made.framesError);
  row("RMSE of a fit without these objects", made.objectsError);
  if (estimator.name == "published") return text + fmt::format("  sky weight {:.4g}, k {:.4g}\n", estimator.skyWeight, estimator.k);
  if (estimator.name == "cones")
    return text + fmt::format("  spread {:.4g}, bias {:.4g}, power {:.4g}\n", estimator.cones->spread, estimator.cones->bias,
                              estimator.cones->power);
  return text + fmt::format("  {} steps\n", estimator.steps.size());
}

std::string jsonOf(const Job& job, const Calibration& made, bool written) {
  Lighting lighting = job.lighting;
  lighting.estimator = made.estimator;
  const auto known = [](double error) { return error < 0.0 ? nlohmann::json() : nlohmann::json(error); };
  const nlohmann::json json = {{"points", job.samples.sky.size()},
                               {"frames", distinct(job.samples.frames)},
                               {"objects", distinct(job.samples.objects)},
                               {"startError", made.startError},
                               {"fitError", made.estimator.fitError},
                               {"framesError", known(made.framesError)},
                               {"objectsError", known(made.objectsError)},
                               {"better", made.better},
                               {"written", written},
                               {"estimator", nlohmann::json::parse(lightingJson(lighting)).at("estimator")}};
  return json.dump(1) + "\n";
}

std::string writtenText(const Job& job, const Estimator& made) {
  const std::string& before = job.lighting.estimator.name;
  const std::string_view used = usedEstimator(made.name, job.apertures);
  std::string text = "written into the scene";
  if (before != made.name) text += fmt::format(", whose estimator it is now in place of {}", before);
  if (job.apertures && used != made.name)
    text += fmt::format("; over its apertures {} lights it all the same, unless a hybrid is fitted", used);
  return text + "\n";
}

/// Of one set for all scenes: the best fit, and the least error of those that knew nothing of the program's constants.
struct CommonFit {
  Calibration best;
  double anew = -1.0;  ///< negative: there are no constants to find anew
};

/// Fits from the program's constants and from some that say nothing.
CommonFit fitCommon(const Job& job) {
  CommonFit common{calibrate(job.samples, job.start, {kCommonPull})};
  Estimator bestStart = job.start;
  const double before = common.best.startError;
  for (std::uint64_t seed = 1; !job.start.steps.empty() && seed <= kCommonStarts; ++seed) {
    const Estimator start = neutralStart(job.start, seed);
    Calibration made = calibrate(job.samples, start, {kCommonPull});
    if (common.anew < 0.0 || made.estimator.fitError < common.anew) common.anew = made.estimator.fitError;
    if (made.estimator.fitError >= common.best.estimator.fitError) continue;
    common.best = std::move(made);
    bestStart = start;
  }
  common.best.startError = before;
  crossValidate(job.samples, bestStart, {kCommonPull}, common.best);
  return common;
}

int finish(const Options& options, const Job& job) {
  if (options.scenes.size() > 1) {
    const CommonFit made = fitCommon(job);
    const std::string anew = made.anew < 0.0 ? "" : fmt::format("  RMSE of fits from nothing, at best   {:.4f}\n", made.anew);
    printResult(options.json ? jsonOf(job, made.best, false) : textOf(job, made.best) + anew + sourceOf(made.best.estimator));
    return static_cast<int>(ExitCode::ok);
  }
  const Calibration made = calibrateScene(job.samples, job.start, job.present);
  const bool writes = made.better && !options.dryRun;
  if (writes) {
    Lighting lighting = job.lighting;
    lighting.estimator = made.estimator;
    if (const auto written = replaceLighting(options.scenes.front(), lighting); !written)
      return fail(written.error(), ExitCode::unwritable);
  }
  printResult(options.json ? jsonOf(job, made, writes) : textOf(job, made));
  if (!options.json)
    printResult(writes        ? writtenText(job, made.estimator)
                : made.better ? "better than before; not written (--dry-run)\n"
                              : "no better than before on what was left out: the scene stays as it was\n");
  return static_cast<int>(ExitCode::ok);
}

int runCalibrate(const Options& options) {
  auto device = openDevice({options.device, false, {}, false});
  if (!device) return fail(device.error(), ExitCode::noDevice);
  Job job;
  std::optional<Failure> failure;
  for (const fs::path& scene : options.scenes)
    if (!failure) failure = addScene(device.value(), options, scene, job);
  closeDevice(device.value());
  return failure ? fail(*failure) : finish(options, job);
}

}  // namespace

int calibrateCommand(int argc, char** argv) {
  CLI::App app("Fits the constants of a baked scene's sky estimator to its ray-traced reference and writes them into it.",
               "overcast-player calibrate");
  Options options;
  addOptions(app, options);
  if (const auto code = parseArguments(app, argc, argv, [&] { checkTogether(options); })) return *code;
  return runCalibrate(options);
}

}  // namespace overcast
