#include "bake/reference_command.h"

#include <memory>
#include <optional>

#include <tbb/global_control.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bake/command.h"
#include "bake/progress_bar.h"
#include "bake/reference_options.h"
#include "formats/console.h"
#include "formats/files.h"
#include "formats/scene.h"
#include "formats/sky.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// "view0_0000: 320x180, sky 1024 rays, error 0.002; light ..., 3.1 s"
std::string summaryLine(const ReferenceJob& job, const ReferenceReport& report) {
  std::string text = job.json.stem().string() + ": ";
  text += report.info.kind == ReferenceKind::points ? fmt::format("{} points", report.info.points)
                                                    : fmt::format("{}x{}", report.info.width, report.info.height);
  for (const ReferenceQuantity& quantity : report.info.quantities)
    if (quantity.name != "dome" && quantity.name != "ao")
      text += fmt::format("; {} {:.4g} +- {:.2g} ({} rays)", quantity.name, quantity.mean, quantity.meanError, quantity.samples);
  if (report.outcome == ReferenceOutcome::upToDate) return text + "; up to date";
  if (report.outcome == ReferenceOutcome::cached) return text + "; from the cache";
  return text + fmt::format("; {:.1f} s", report.info.seconds);
}

Json jobJson(const ReferenceJob& job, const ReferenceReport& report) {
  constexpr std::array kOutcomes{"traced", "up to date", "cached"};
  Json json = {{"file", job.json.string()}, {"outcome", kOutcomes[static_cast<std::size_t>(report.outcome)]}};
  json["reference"] = Json::parse(referenceJson(report.info));
  return json;
}

ExitCode codeOf(ReferenceOutcome outcome) {
  if (outcome == ReferenceOutcome::stopped) return kInterrupted;
  if (outcome == ReferenceOutcome::badScene) return kBadInput;
  return outcome == ReferenceOutcome::cannotWrite ? kCannotWrite : kOk;
}

int runJobs(const Scene& scene, const ReferenceOptions& options, const std::vector<ReferenceJob>& jobs, Cache* cache) {
  ProgressBar bar(!options.quiet);
  Json files = Json::array();
  const std::string name = options.scene.filename().string();
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const Progress progress = [&](double share) {
      bar.update((static_cast<double>(i) + share) / static_cast<double>(jobs.size()));
      return !interrupted();
    };
    if (interrupted()) return kInterrupted;
    const ReferenceReport report = runReferenceJob(scene, name, jobs[i], options.trace, cache, options.preview, progress);
    if (const ExitCode code = codeOf(report.outcome); code != kOk) {
      if (code != kInterrupted) complain(report.error);
      return code;
    }
    if (!options.quiet) bar.line(summaryLine(jobs[i], report));
    if (options.json) files.push_back(jobJson(jobs[i], report));
    if (!options.json) printResult(jobs[i].json.string() + "\n");
  }
  if (options.json) {
    const Json document = {{"format", "overcast-reference-run"}, {"version", 1}, {"scene", options.scene.string()}, {"files", files}};
    printResult(document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  }
  return kOk;
}

/// The picture that is the sky: the one asked for, else the scene's; none: its colour.
Result<std::optional<SkyImage>> skyOf(const Scene& scene, const ReferenceOptions& options) {
  fs::path file = options.sky;
  if (file.empty() && scene.lighting && !scene.lighting->skyImage.empty()) {
    const auto own = skyFile(options.scene.parent_path(), scene.lighting->skyImage);
    if (!own) return own.error();
    file = own.value();
  }
  if (file.empty()) return std::optional<SkyImage>();
  auto read = readSkyImage(file);
  if (!read) return read.error();
  return std::optional(std::move(read).value());
}

}  // namespace

int referenceCommand(const std::vector<std::string>& arguments) {
  CLI::App app(
      "Traces the truth that estimates are measured against: sky visibility, bounded ambient occlusion, area lights and one bounce, for "
      "views and for points on surfaces, each with its standard error. Files that are there already, of the same scene and settings, are "
      "not traced again: a run that was stopped goes on where it was.",
      "overcast-bake reference");
  ReferenceOptions options;
  addReferenceOptions(app, options);
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  const auto jobs = referenceJobs(options);
  if (!jobs) {
    complain(jobs.error());
    return kUsage;
  }
  auto scene = readScene(options.scene);
  if (!scene) {
    complain(scene.error());
    return kBadInput;
  }
  const auto sky = skyOf(scene.value(), options);
  if (!sky) {
    complain(sky.error());
    return kBadInput;
  }
  if (const auto writable = checkWritable(options.folder); !writable) {
    complain(writable.error());
    return kCannotWrite;
  }
  std::unique_ptr<Cache> cache;
  if (!options.cache.empty()) {
    auto opened = Cache::open(options.cache, kDefaultCacheLimit);
    if (!opened) {
      complain(opened.error());
      return kCannotWrite;
    }
    cache = std::move(opened).value();
  }
  std::vector<ReferenceJob> list = jobs.value();
  for (ReferenceJob& job : list) job.sky = sky.value() ? &*sky.value() : nullptr;
  watchInterrupts();
  std::optional<tbb::global_control> limit;
  if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
  return runJobs(scene.value(), options, list, cache.get());
}

}  // namespace overcast
