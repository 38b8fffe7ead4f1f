#include "bake/bake_command.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <CLI/CLI.hpp>

#include "bake/aperture_options.h"
#include "bake/bake_report.h"
#include "bake/choice_options.h"
#include "bake/command.h"
#include "bake/defects.h"
#include "bake/progress_bar.h"
#include "bake/scene_apertures.h"
#include "bake/scene_bake.h"
#include "formats/console.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<fs::path> inputs;
  fs::path folder;
  std::string name;
  BakeSettings settings;
  ChoiceOptions choice;
  ApertureOptions apertures;
  std::optional<SceneApertureSettings> apertureSettings;
  int threads = 0;
  bool json = false;
  bool quiet = false;
  bool keepGoing = false;
};

void addOptions(CLI::App& app, Options& options) {
  static const std::map<std::string, VolumeBits> bits = {
      {"auto", VolumeBits::automatic}, {"8", VolumeBits::snorm8}, {"16", VolumeBits::half}, {"32", VolumeBits::single}};
  VolumeSettings& settings = options.settings.volume;
  app.add_option("INPUT", options.inputs, "meshes (.obj .ply .stl .off) and scenes (.gltf .glb), side by side in one scene")->required();
  app.add_option("-o,--output", options.folder, "folder for the baked scene; made when missing")
      ->required()
      ->check([](const std::string& text) { return std::string(text.empty() ? "names no folder" : ""); });
  app.add_option("--name", options.name, "file name of the scene without .gltf [a single glTF keeps its name, else \"scene\"]");
  auto* resolution =
      app.add_option("--resolution", settings.resolution, "volumes with so many samples along the longest side, instead of a choice")
          ->check(CLI::Range(kMinResolution, kMaxResolution))
          ->capture_default_str();
  app.add_option("--voxel-size", settings.voxelSize, "spacing of samples in units of the mesh, instead of --resolution")
      ->check(positiveNumber)
      ->excludes(resolution);
  app.add_option("--padding", settings.padding, "voxels around each mesh")->check(numberWithin(0.0, 255.0))->capture_default_str();
  app.add_option("--bits", settings.bits, "precision of the distances: 8 (signed normalised), 16, 32 or auto (16 unless they do not fit)")
      ->transform(CLI::CheckedTransformer(bits))
      ->default_str("auto");
  app.add_option("--error-samples", settings.errorSamples, "random points at which the error is measured; 0: none")
      ->check(CLI::Range(0, 100000000))
      ->capture_default_str();
  app.add_option("--seed", settings.seed, "seed of these points")->capture_default_str();
  static const std::map<std::string, SheetMode> sheets = {
      {"auto", SheetMode::automatic}, {"signed", SheetMode::none}, {"two-sided", SheetMode::all}};
  app.add_option(
         "--sheets", settings.sheets.mode,
         "auto: parts without an inside and plates thinner than a voxel get two sides and a thickness; two-sided: everything; signed: "
         "nothing")
      ->transform(CLI::CheckedTransformer(sheets))
      ->default_str("auto");
  app.add_option("--thickness", settings.sheets.thickness,
                 "thickness of such sheets in units of the mesh [the diagonal of a voxel: the least that leaves no hole]")
      ->check(positiveNumber);
  addChoiceOptions(app, options.choice);
  addApertureOptions(app, options.apertures);
  app.add_option("--threads", options.threads, "threads to use; 0: all. The result is the same for any number")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_flag("--keep-going", options.keepGoing, "bake the good inputs although others are bad (exit code 6)");
  app.add_flag("--json", options.json, "print one JSON document about everything on stdout");
  app.add_flag("--quiet", options.quiet, "print nothing on stderr but errors");
}

/// A size given by hand asks for a volume of that size, everything else for a choice.
Result<Done> settleChoice(const CLI::App& app, Options& options) {
  const bool sized = app.count("--resolution") + app.count("--voxel-size") + app.count("--bits") > 0;
  const bool wanted = wantsChoice(options.choice);
  if (sized && wanted && (options.choice.representation != "volume" || options.choice.maxError || options.choice.maxBytes))
    return Error{"", "", "--resolution, --voxel-size and --bits ask for a volume of that size: there is nothing to choose (see --help)"};
  if (sized) return Done{};
  const VolumeSettings& volume = options.settings.volume;
  if (volume.errorSamples == 0)
    return Error{"", "", "choosing needs a measured error: --error-samples must be above 0, or --resolution given (see --help)"};
  options.settings.choice = choiceSettings(options.choice, {volume.errorSamples, volume.seed});
  options.settings.choice->padding = volume.padding;
  options.settings.choice->sheets = volume.sheets;
  return Done{};
}

/// Reads all inputs, several at once, in the order given.
std::vector<BakeInput> readInputs(const Options& options, std::vector<InputReport>& reports) {
  std::vector<std::optional<Result<BakeInput>>> read(options.inputs.size());
  tbb::parallel_for(std::size_t{0}, read.size(), [&](std::size_t i) {
    if (!interrupted()) read[i].emplace(readBakeInput(options.inputs[i]));
  });
  std::vector<BakeInput> good;
  for (std::size_t i = 0; i < read.size(); ++i) {
    InputReport report{options.inputs[i], {}, {}};
    if (read[i] && read[i]->ok()) {
      BakeInput& input = read[i]->value();
      if (input.report) report.notes = remarks(*input.report);
      report.notes.insert(report.notes.end(), input.scene.notes.begin(), input.scene.notes.end());
      good.push_back(std::move(input));
    } else if (read[i]) {
      report.errors.push_back(read[i]->error());
    }
    reports.push_back(std::move(report));
  }
  return good;
}

/// True when writing would replace one of the inputs.
bool overwritesInput(const Options& options) {
  std::error_code code;
  for (const fs::path& input : options.inputs)
    if (fs::equivalent(input, options.folder / (options.name + ".gltf"), code)) return true;
  return false;
}

void printNotes(ProgressBar& bar, const std::string& source, const std::vector<std::string>& notes) {
  for (const std::string& note : notes) bar.line(fmt::format("{}: note: {}", source, note));
}

/// Adds the errors of the bake to their inputs and says whether there is any error at all.
bool collectErrors(const SceneBake& bake, std::vector<InputReport>& reports) {
  for (const MeshBake& mesh : bake.meshes) {
    if (!mesh.error) continue;
    for (InputReport& report : reports)
      if (report.path == bake.inputs[static_cast<std::size_t>(mesh.input)]) {
        report.errors.push_back(*mesh.error);
        break;
      }
  }
  bool any = false;
  for (const InputReport& report : reports) any |= !report.errors.empty();
  return any;
}

/// Bakes with a bar and a line for each mesh.
void bakeWithMessages(SceneBake& bake, const Options& options) {
  ProgressBar bar(!options.quiet);
  const auto progress = [&](double share) {
    bar.update(share);
    return !interrupted();
  };
  bakeMeshes(bake, options.settings, progress, [&](const MeshBake& mesh) {
    if (options.quiet || !mesh.asset) return;
    bar.line(summaryLine(mesh));
    std::vector<std::string> notes;
    for (const Defect& defect : defectsOf(mesh)) notes.push_back(defect.text);
    printNotes(bar, mesh.source, notes);
  });
}

void bakeAperturesWithMessages(SceneBake& bake, const Options& options) {
  ProgressBar bar(!options.quiet);
  const auto progress = [&](double share) {
    bar.update(share);
    return !interrupted();
  };
  bakeSceneApertures(bake, *options.apertureSettings, progress, [&](const MeshBake& mesh) {
    if (!options.quiet && mesh.apertures) bar.line(fmt::format("{}: {}", mesh.source, summaryLine(*mesh.apertures)));
  });
}

bool holdsMesh(const Scene& scene) {
  return std::any_of(scene.nodes.begin(), scene.nodes.end(), [](const Node& node) { return node.mesh >= 0; });
}

int runBake(const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<InputReport> reports;
  std::vector<BakeInput> inputs = readInputs(options, reports);
  if (interrupted()) return kInterrupted;
  if (!options.quiet) {
    ProgressBar bar(false);
    for (const InputReport& report : reports) printNotes(bar, report.path.filename().string(), report.notes);
  }
  SceneBake bake = joinInputs(std::move(inputs), options.settings);
  const bool readAll = bake.inputs.size() == reports.size();
  if (readAll || options.keepGoing) bakeWithMessages(bake, options);
  if ((readAll || options.keepGoing) && options.apertureSettings && !interrupted()) bakeAperturesWithMessages(bake, options);
  if (interrupted()) return kInterrupted;

  const bool failed = collectErrors(bake, reports);
  for (const InputReport& report : reports)
    for (const Error& error : report.errors) complain(error);
  int code = failed ? kBadInput : kOk;
  std::vector<fs::path> files;
  if (failed) dropFailedInputs(bake);
  if (!failed || (options.keepGoing && holdsMesh(bake.scene))) {
    code = failed ? kPartial : kOk;
    auto written = writeBake(bake, options.folder, options.name, options.settings);
    if (written.ok()) {
      files = std::move(written).value();
    } else {
      complain(written.error());
      code = kCannotWrite;
    }
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (options.json) printResult(bakeJson(reports, bake, files, seconds) + "\n");
  if (!options.json)
    for (const fs::path& file : files) printResult(file.string() + "\n");
  return code;
}

}  // namespace

int bakeCommand(const std::vector<std::string>& arguments) {
  CLI::App app("Bakes occluders of meshes and scenes into a glTF scene that overcast-player opens.", "overcast-bake");
  Options options;
  addOptions(app, options);
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  if (const Result<Done> settled = settleChoice(app, options); !settled) {
    complain(settled.error());
    return kUsage;
  }
  auto apertures = apertureSettings(app, options.apertures);
  if (!apertures) {
    complain(apertures.error());
    return kUsage;
  }
  options.apertureSettings = apertures.value();
  if (options.name.empty()) options.name = outputName(options.inputs);
  if (fs::path(options.name).filename() != options.name || options.name == "." || options.name == "..") {
    complain(Error{"", "", fmt::format("--name '{}' is not a plain file name", options.name)});
    return kUsage;
  }
  if (overwritesInput(options)) {
    complain(Error{(options.folder / (options.name + ".gltf")).string(), "", "is an input; choose another folder or --name"});
    return kUsage;
  }
  watchInterrupts();
  std::optional<tbb::global_control> limit;
  if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
  return runBake(options);
}

}  // namespace overcast
