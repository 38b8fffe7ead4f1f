#include "bake/explain_command.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include <tbb/global_control.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bake/bake_report.h"
#include "bake/choice_options.h"
#include "bake/command.h"
#include "bake/pareto_svg.h"
#include "bake/scene_bake.h"
#include "formats/console.h"
#include "formats/files.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path input;
  fs::path svg;
  fs::path costs;
  ChoiceOptions choice;
  MeasureSettings measure;
  int largest = 128;
  int threads = 0;
  bool json = false;
};

void addOptions(CLI::App& app, Options& options) {
  app.add_option("INPUT", options.input, "a mesh (.obj .ply .stl .off) or a scene (.gltf .glb)")->required();
  app.add_option("--svg", options.svg, "file for the Pareto fronts of error against bytes and against composite time");
  app.add_option("--costs", options.costs, "composite costs of a device, from overcast-player cost [those of lavapipe, built in]");
  addChoiceOptions(app, options.choice);
  app.add_option("--largest", options.largest, "largest size of any candidate")
      ->check(CLI::Range(8, kLargestCandidate))
      ->capture_default_str();
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

/// The document of --json, version 1.
std::string explainJson(const fs::path& input, const CompositeCosts& costs, const std::vector<ExplainedMesh>& meshes) {
  nlohmann::ordered_json document = {{"format", "overcast-explain"},
                                     {"version", 1},
                                     {"file", input.string()},
                                     {"compositeDevice", costs.device},
                                     {"meshes", nlohmann::ordered_json::array()}};
  for (const ExplainedMesh& mesh : meshes)
    document["meshes"].push_back({{"source", mesh.source}, {"choice", nlohmann::ordered_json::parse(choiceJson(mesh.record))}});
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// The records of all distinct meshes, one after another.
Result<std::vector<ExplainedMesh>> explain(const Options& options, CompositeCosts costs) {
  auto input = readBakeInput(options.input);
  if (!input) return input.error();
  std::vector<BakeInput> inputs;
  inputs.push_back(std::move(input).value());
  const SceneBake bake = joinInputs(std::move(inputs), {});
  ChoiceSettings settings = choiceSettings(options.choice, options.measure);
  settings.everything = true;
  settings.costs = std::move(costs);
  settings.largest = options.largest;
  std::vector<ExplainedMesh> meshes;
  for (const MeshBake& mesh : bake.meshes) {
    if (mesh.sameAs >= 0) continue;
    auto choice = choose(bake.scene.meshes[static_cast<std::size_t>(mesh.mesh)], settings, [](double) { return !interrupted(); });
    if (!choice) return Error{options.input.string(), mesh.source, choice.error().reason};
    meshes.push_back({mesh.source, std::move(choice).value().record});
  }
  return meshes;
}

}  // namespace

int explainCommand(const std::vector<std::string>& arguments) {
  CLI::App app("Prints what every representation of a mesh costs and how far off it is, which one is chosen and why not the others.",
               "overcast-bake explain");
  Options options;
  addOptions(app, options);
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  watchInterrupts();
  std::optional<tbb::global_control> limit;
  if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
  const auto costs = options.costs.empty() ? Result<CompositeCosts>(defaultCompositeCosts()) : readCompositeCosts(options.costs);
  if (!costs) {
    complain(costs.error());
    return kBadInput;
  }
  const auto meshes = explain(options, costs.value());
  if (interrupted()) return kInterrupted;
  if (!meshes) {
    complain(meshes.error());
    return kBadInput;
  }
  if (options.json) {
    printResult(explainJson(options.input, costs.value(), meshes.value()) + "\n");
  } else {
    for (const ExplainedMesh& mesh : meshes.value()) printTable(mesh);
    printResult(fmt::format("composite: nanoseconds of one evaluation on {} ({})\n", costs.value().device, costs.value().driver));
  }
  if (options.svg.empty()) return kOk;
  if (const auto written = writeFileAtomically(options.svg, paretoSvg(meshes.value())); !written) {
    complain(written.error());
    return kCannotWrite;
  }
  return kOk;
}

}  // namespace overcast
