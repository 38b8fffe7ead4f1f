#include "bake/explain_command.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>

#include <tbb/global_control.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bake/bake_report.h"
#include "bake/choice_options.h"
#include "bake/choice_table.h"
#include "bake/command.h"
#include "bake/inputs.h"
#include "bake/pareto_svg.h"
#include "bake/scene_bake.h"
#include "formats/console.h"
#include "formats/files.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestShown = 128;  // every candidate of 256 samples takes a minute

struct Options {
  fs::path input;
  fs::path svg;
  fs::path costs;
  ChoiceOptions choice;
  MeasureSettings measure;
  std::optional<int> largest;
  int threads = 0;
  bool json = false;
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("INPUT", options.input,
                 "a mesh (.obj .ply .stl .off), a scene (.gltf .glb), or a folder of them, with those below it: then only what is chosen "
                 "of each, in one table")
      ->required();
  app.add_option("--svg", options.svg, "file for the Pareto fronts of error against bytes and against composite time; not for folders");
  app.add_option("--costs", options.costs, "composite costs of a device, from overcast-player cost [those of lavapipe, built in]");
  addChoiceOptions(app, options.choice);
  app.add_option("--largest", options.largest,
                 fmt::format("largest size of any candidate [{}; {} in a folder]", kLargestShown, kLargestCandidate))
      ->check(CLI::Range(8, kLargestCandidate));
  app.add_option("--error-samples", options.measure.samples, "random points at which errors are measured")
      ->check(CLI::Range(1, 100000000))
      ->capture_default_str();
  app.add_option("--seed", options.measure.seed, "seed of these points")->capture_default_str();
  app.add_option("--threads", options.threads, "threads to use; 0: all")->check(CLI::Range(0, 4096))->capture_default_str();
  app.add_flag("--json", options.json, "print one JSON document instead of tables");
}

/// Lengths in percent of the diagonal, composite times in nanoseconds.
void printTable(const ExplainedMesh& mesh) {
  const ChoiceRecord& record = mesh.record;
  printResult(fmt::format("{}: diagonal {:.6g}, errors in percent of it\n", oneLine(mesh.source), record.diagonal));
  printResult(fmt::format("{:22} {:>12} {:>11} {:>9} {:>9} {:>8} {:>6} {:>9}  {}\n", "candidate", "bytes", "surface rms", "max", "p99",
                          "sky rmse", "signs", "composite", "verdict"));
  for (const Score& score : record.scores) {
    const MeasuredError& error = score.error;
    if (error.samples == 0) {
      printResult(fmt::format("{:22} {:>12} {:>11} {:>9} {:>9} {:>8} {:>6} {:>9}  {}\n", name(score.candidate), "-", "-", "-", "-", "-",
                              "-", "-", score.reason));
      continue;
    }
    const double percent = 100.0 / record.diagonal;
    printResult(fmt::format("{:22} {:>12} {:>11.4f} {:>9.3f} {:>9.3f} {:>8.4f} {:>6} {:>9.1f}  {}\n", name(score.candidate),
                            grouped(score.bytes), percent * error.surfaceRms, percent * error.max, percent * error.p99, error.skyRmse,
                            error.signErrors, score.composite, score.reason));
  }
}

/// What is said of an input. A folder has rows alone.
struct Explained {
  std::vector<ExplainedMesh> meshes;
  std::vector<ChoiceRow> rows;
  std::vector<Error> errors;  ///< of the folder's files
};

/// The document of --json, version 1.
std::string explainJson(const fs::path& input, const CompositeCosts& costs, const Explained& explained) {
  nlohmann::ordered_json document = {{"format", "overcast-explain"},
                                     {"version", 1},
                                     {"file", input.string()},
                                     {"compositeDevice", costs.device},
                                     {"meshes", nlohmann::ordered_json::array()}};
  for (const ExplainedMesh& mesh : explained.meshes)
    document["meshes"].push_back({{"source", mesh.source}, {"choice", nlohmann::ordered_json::parse(choiceJson(mesh.record))}});
  document["table"] = nlohmann::ordered_json::parse(choiceTableJson(explained.rows));
  document["errors"] = nlohmann::ordered_json::array();
  for (const Error& error : explained.errors) document["errors"].push_back(message(error));
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// The row of a mesh and its choice.
ChoiceRow rowOf(const MeshBake& job, const Mesh& mesh, const ChoiceRecord& record, const ChoiceSettings& settings) {
  ChoiceRow row{job.source, job.faces, record.diagonal, record.scores[record.chosen], record.withinLimits, {}, {}};
  const auto same = std::find_if(record.scores.begin(), record.scores.end(), [&](const Score& score) {
    return name(score.candidate) == name(kComparedWith) && score.error.samples == settings.measure.samples;
  });
  if (same != record.scores.end()) {
    row.volume = *same;
  } else if (auto volume = scoreOf(mesh, kComparedWith, settings)) {
    row.volume = std::move(volume).value();
  }
  return row;
}

/// Adds the distinct meshes of one file, one after another: they are timed.
Result<Done> explainFile(const fs::path& file, const Options& options, const CompositeCosts& costs, bool inFolder, Explained& explained) {
  auto input = readBakeInput(file);
  if (!input) return input.error();
  std::vector<BakeInput> inputs;
  inputs.push_back(std::move(input).value());
  const SceneBake bake = joinInputs(std::move(inputs));
  ChoiceSettings settings = choiceSettings(options.choice, options.measure);
  settings.everything = !inFolder;
  settings.costs = costs;
  settings.largest = options.largest.value_or(inFolder ? kLargestCandidate : kLargestShown);
  for (const MeshBake& job : bake.meshes) {
    if (job.sameAs >= 0) continue;
    const Mesh& mesh = bake.scene.meshes[static_cast<std::size_t>(job.mesh)];
    const auto start = std::chrono::steady_clock::now();
    auto choice = choose(mesh, settings, [](double) { return !interrupted(); });
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!choice) return Error{file.string(), job.source == file.filename().string() ? "" : job.source, choice.error().reason};
    explained.rows.push_back(rowOf(job, mesh, choice.value().record, settings));
    if (inFolder)
      explained.rows.back().seconds = seconds;
    else
      explained.meshes.push_back({job.source, std::move(choice).value().record});
  }
  return Done{};
}

Result<Explained> explain(const Options& options, const CompositeCosts& costs) {
  Explained explained;
  std::error_code code;
  if (!fs::is_directory(options.input, code)) {
    if (const auto done = explainFile(options.input, options, costs, false, explained); !done) return done.error();
    return explained;
  }
  const auto inputs = expandInputs({options.input}, {});
  if (!inputs) return inputs.error();
  for (const InputFile& file : inputs.value().files) {
    if (interrupted()) break;
    if (const auto done = explainFile(file.path, options, costs, true, explained); !done) explained.errors.push_back(done.error());
  }
  return explained;
}

void print(const Explained& explained, const CompositeCosts& costs, const Options& options) {
  if (options.json) {
    printResult(explainJson(options.input, costs, explained) + "\n");
    return;
  }
  for (const ExplainedMesh& mesh : explained.meshes) printTable(mesh);
  if (!explained.meshes.empty())
    printResult(fmt::format("composite: nanoseconds of one evaluation on {} ({})\n", costs.device, costs.driver));
  if (explained.rows.size() == 1 && !explained.meshes.empty()) return;
  printResult(choiceTable(explained.rows));
  printResult(
      fmt::format("Errors in percent of each mesh's diagonal; ratios against {} of the same mesh, geometric means in the last row.\n",
                  name(kComparedWith)));
}

}  // namespace

int explainCommand(const std::vector<std::string>& arguments) {
  CLI::App app("Prints what every representation of a mesh costs and how far off it is, which one is chosen and why not the others.",
               "overcast-bake explain");
  Options options;
  addOptions(app, options);
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  std::error_code ignored;
  if (!options.svg.empty() && fs::is_directory(options.input, ignored)) {
    complain(Error{options.input.string(), "", "is a folder: --svg draws one mesh or scene (see --help)"});
    return kUsage;
  }
  watchInterrupts();
  std::optional<tbb::global_control> limit;
  if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
  const auto costs = options.costs.empty() ? Result<CompositeCosts>(defaultCompositeCosts()) : readCompositeCosts(options.costs);
  if (!costs) {
    complain(costs.error());
    return kBadInput;
  }
  const auto explained = explain(options, costs.value());
  if (interrupted()) return kInterrupted;
  if (!explained) {
    complain(explained.error());
    return kBadInput;
  }
  for (const Error& error : explained.value().errors) complain(error);
  if (explained.value().rows.empty()) return kBadInput;
  print(explained.value(), costs.value(), options);
  if (!options.svg.empty()) {
    if (const auto written = writeFileAtomically(options.svg, paretoSvg(explained.value().meshes)); !written) {
      complain(written.error());
      return kCannotWrite;
    }
  }
  return explained.value().errors.empty() ? kOk : kPartial;
}

}  // namespace overcast
