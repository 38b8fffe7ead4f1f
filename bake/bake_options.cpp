#include "bake/bake_options.h"

#include <cctype>
#include <charconv>
#include <limits>
#include <set>

#include <CLI/CLI.hpp>

#include "bake/command.h"
#include "bake/config.h"
#include "bake/inputs.h"
#include "bake/terrain_options.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

/// Turns "2G" into bytes; what is wrong with it, or nothing.
std::string asBytes(std::string& text) {
  static const std::string units = "KMGT";
  std::string digits = text;
  if (digits.size() > 1 && (digits.back() == 'B' || digits.back() == 'b')) digits.pop_back();
  if (digits.size() > 1 && digits.back() == 'i') digits.pop_back();
  const std::size_t unit = digits.empty() ? std::string::npos : units.find(static_cast<char>(std::toupper(digits.back())));
  if (unit != std::string::npos) digits.pop_back();
  std::uint64_t number = 0;
  const auto [end, failed] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  const unsigned shift = unit == std::string::npos ? 0 : 10 * (static_cast<unsigned>(unit) + 1);
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max() >> shift;
  if (failed != std::errc() || end != digits.data() + digits.size() || number == 0 || number > most)
    return fmt::format("'{}' is not a number of bytes such as 800M or 2G", text);
  text = std::to_string(number << shift);
  return "";
}

std::string notEmpty(const std::string& text) {
  return text.empty() ? "is empty" : "";
}

void addSettings(CLI::App& app, BakeOptions& options) {
  const VolumeSettings defaults;
  SettingsLayer& settings = options.settings;
  app.add_option("--preset", settings.preset, presetHelp() + ". Options given beside it win");
  auto* resolution =
      app.add_option("--resolution", settings.resolution, "volumes with so many samples along the longest side, instead of a choice")
          ->check(CLI::Range(kMinResolution, kMaxResolution))
          ->default_str(std::to_string(defaults.resolution));
  app.add_option("--voxel-size", settings.voxelSize, "spacing of samples in units of the mesh, instead of --resolution")
      ->check(positiveNumber)
      ->excludes(resolution);
  app.add_option("--padding", settings.padding, "voxels around each mesh")
      ->check(numberWithin(0.0, kMaxPadding))
      ->default_str(fmt::format("{}", defaults.padding));
  app.add_option("--bits", settings.bits, "precision of the distances: 8 (signed normalised), 16, 32 or auto (16 unless they do not fit)")
      ->transform(CLI::CheckedTransformer(volumeBitsNames()))
      ->default_str("auto");
  app.add_option("--error-samples", settings.errorSamples, "random points at which the error is measured; 0: none")
      ->check(CLI::Range(std::uint64_t{0}, kMaxErrorSamples))
      ->default_str(std::to_string(defaults.errorSamples));
  app.add_option("--seed", settings.seed, "seed of these points")->default_str(std::to_string(defaults.seed));
  app.add_option(
         "--sheets", settings.sheets,
         "auto: parts without an inside and plates thinner than a voxel get two sides and a thickness; two-sided: everything; signed: "
         "nothing")
      ->transform(CLI::CheckedTransformer(sheetModeNames()))
      ->default_str("auto");
  app.add_option("--thickness", settings.thickness,
                 "thickness of such sheets in units of the mesh [the diagonal of a voxel: the least that leaves no hole]")
      ->check(positiveNumber);
  addChoiceOptions(app, options.choice);
  app.add_option("--largest", settings.largest, "largest size of any candidate")
      ->check(CLI::Range(kMinResolution, kLargestCandidate))
      ->default_str(std::to_string(kLargestCandidate));
  app.add_option("--config", options.config, "JSON file with settings, also for some of the inputs only; the command line wins over it");
}

void addScale(CLI::App& app, BakeOptions& options) {
  app.add_flag("--each", options.each,
               "bake every input on its own, into FOLDER/<its name>, as a command for it alone would. Goes on past inputs that fail (exit "
               "code 6); run again, it bakes only what is missing or changed");
  app.add_option(
         "--cache", options.cache,
         "folder of results that are taken instead of baking the same again; may be shared [none; with --each FOLDER/.overcast-cache]")
      ->check(notEmpty);
  app.add_option("--cache-limit", options.cacheLimit, "bytes it may take (K, M, G, T), what was not used for the longest time goes first")
      ->transform(CLI::Validator(asBytes, "BYTES"))
      ->default_str("5G");
  app.add_option("--memory", options.memory,
                 "bytes (K, M, G) to stay within: fewer meshes are baked at once when they would not fit [three quarters of what is free]")
      ->transform(CLI::Validator(asBytes, "BYTES"));
  app.add_option("--depfile", options.depfile, "file for the inputs of every scene in the syntax of make and ninja")->check(notEmpty);
  app.add_flag("--dry-run", options.dryRun, "only say what would be baked, taken from the cache and written; exit code as of a real run");
}

/// What the command line says about settings.
SettingsLayer commandLine(const BakeOptions& options) {
  SettingsLayer layer = options.settings;
  if (!options.choice.representation.empty()) layer.representation = options.choice.representation;
  layer.maxError = options.choice.maxError;
  layer.maxSkyError = options.choice.maxSkyError;
  layer.maxBytes = options.choice.maxBytes;
  return layer;
}

PlanError wrongUsage(std::string reason) {
  return {PlanFault::usage, Error{"", "", std::move(reason) + " (see --help)"}};
}

/// True when writing the scene would replace one of its inputs.
bool overwritesInput(const BakeJob& job) {
  std::error_code code;
  for (const fs::path& input : job.inputs)
    if (fs::equivalent(input, job.folder / (job.name + ".gltf"), code)) return true;
  return false;
}

/// The settings of one input. A terrain becomes a field of heights, unless something else is asked for.
Result<BakeSettings> settle(const Config& config, const SettingsLayer& top, const InputFile& input) {
  SettingsLayer layer = overlaid(settingsFor(config, input.name), top);
  if (isTerrainFile(input.path) && !layer.representation && !layer.resolution && !layer.voxelSize && !layer.bits)
    layer.representation = name(Representation::heightfield);
  return bakeSettings(layer);
}

/// One job of all inputs, or one for each of them; without settings.
Result<std::vector<BakeJob>> jobsOf(const BakeOptions& options, std::vector<InputFile>& files) {
  std::vector<BakeJob> jobs;
  if (!options.each) {
    BakeJob job{{}, {}, options.folder, options.name, {}};
    for (const InputFile& file : files) job.inputs.push_back(file.path);
    if (job.name.empty()) job.name = outputName(job.inputs);
    jobs.push_back(std::move(job));
    return jobs;
  }
  std::set<fs::path> seen;
  std::erase_if(files, [&](const InputFile& file) { return !seen.insert(file.path.lexically_normal()).second; });
  const auto folders = foldersOfEach(files);
  if (!folders) return folders.error();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string name = options.name.empty() ? outputName({files[i].path}) : options.name;
    jobs.push_back({{files[i].path}, {}, options.folder / folders.value()[i], name, {}});
  }
  return jobs;
}

}  // namespace

void addBakeOptions(CLI::App& app, BakeOptions& options) {
  app.add_option(
         "INPUT", options.inputs,
         "meshes (.obj .ply .stl .off) and scenes (.gltf .glb), side by side in one scene; folders of them; @FILE: a list, one a line. "
         "Outside "
         "of folders also terrains, y up, north -z: heights as 16-bit PNG or EXR of one channel, ESRI grid (.asc .dem), USGS DEM (.dem)")
      ->required();
  app.add_option("-o,--output", options.folder, "folder for the baked scene; made when missing")
      ->required()
      ->check([](const std::string& text) { return std::string(text.empty() ? "names no folder" : ""); });
  app.add_option("--name", options.name, "file name of the scene without .gltf [a single glTF keeps its name, else \"scene\"]");
  addSettings(app, options);
  addApertureOptions(app, options.apertures);
  addTerrainOptions(app, options.terrain);
  addScale(app, options);
  app.add_option("--threads", options.threads, "threads to use; 0: all. The result is the same for any number")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_flag("--keep-going", options.keepGoing, "bake the good inputs although others are bad (exit code 6)");
  app.add_flag("--json", options.json, "print one JSON document about everything on stdout");
  app.add_flag("--quiet", options.quiet, "print nothing on stderr but errors");
}

std::variant<BakePlan, PlanError> planBake(const BakeOptions& options) {
  const std::string& name = options.name;
  if (!name.empty() && (fs::path(name).filename() != name || name == "." || name == ".."))
    return PlanError{PlanFault::usage, Error{"", "", fmt::format("--name '{}' is not a plain file name", name)}};
  const SettingsLayer top = commandLine(options);
  if (std::string wrong = contradiction(top); !wrong.empty()) return wrongUsage(std::move(wrong));
  const auto apertures = apertureSettings(options.apertures);
  if (!apertures) return PlanError{PlanFault::usage, apertures.error()};
  BakePlan plan;
  Config config;
  if (!options.config.empty()) {
    auto read = readConfig(options.config);
    if (!read) return PlanError{PlanFault::usage, read.error()};
    config = std::move(read).value();
    plan.configs.push_back(options.config);
  }
  auto inputs = expandInputs(options.inputs, options.folder);
  if (!inputs) return PlanError{PlanFault::input, inputs.error()};
  plan.configs.insert(plan.configs.end(), inputs.value().lists.begin(), inputs.value().lists.end());
  std::vector<InputFile>& files = inputs.value().files;
  auto jobs = jobsOf(options, files);
  if (!jobs) return PlanError{PlanFault::usage, jobs.error()};
  plan.jobs = std::move(jobs).value();
  for (BakeJob& job : plan.jobs) {
    job.apertures = apertures.value();
    job.terrain = options.terrain;
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    auto settings = settle(config, top, files[i]);
    if (!settings) return wrongUsage(settings.error().reason);
    plan.jobs[options.each ? i : 0].settings.push_back(std::move(settings).value());
  }
  for (const BakeJob& job : plan.jobs)
    if (overwritesInput(job))
      return PlanError{PlanFault::usage,
                       Error{(job.folder / (job.name + ".gltf")).string(), "", "is an input; choose another folder or --name"}};
  return plan;
}

}  // namespace overcast
