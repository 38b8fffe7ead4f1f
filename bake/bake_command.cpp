#include "bake/bake_command.h"

#include <chrono>
#include <optional>

#include <tbb/global_control.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>
#include <CLI/CLI.hpp>

#include "bake/bake_job.h"
#include "bake/bake_options.h"
#include "bake/bake_report.h"
#include "bake/command.h"
#include "bake/defects.h"
#include "bake/depfile.h"
#include "bake/memory.h"
#include "bake/progress_bar.h"
#include "formats/console.h"
#include "formats/files.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

/// Jobs whose results wait for that of an earlier one.
constexpr std::size_t kJobsAhead = 256;

std::uint64_t memoryLimit(const BakeOptions& options) {
  return options.memory > 0 ? options.memory : availableMemory() / 4 * 3;
}

/// Everything that one run of the command prints and counts.
class Run {
 public:
  Run(const BakeOptions& options, const BakePlan& plan, Cache* cache)
      : options_(options),
        plan_(plan),
        cache_(cache),
        gate_(limitOf(options)),
        bar_(!options.quiet),
        start_(std::chrono::steady_clock::now()) {
    if (options_.json) json_.emplace([](const std::string& text) { printResult(text); });
  }

  ExitCode run() {
    tbb::parallel_pipeline(
        kJobsAhead, tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& flow) {
                      if (next_ == plan_.jobs.size() || interrupted()) flow.stop();
                      return next_++;
                    }) & tbb::make_filter<std::size_t, Finished>(tbb::filter_mode::parallel, [&](std::size_t job) {
                      // Isolated: a job that waits must not start on another.
                      return tbb::this_task_arena::isolate([&] { return bake(job); });
                    }) & tbb::make_filter<Finished, void>(tbb::filter_mode::serial_in_order, [&](const Finished& job) { take(job); }));
    return finish();
  }

 private:
  /// Shared, because a pipeline copies what it passes on.
  using Finished = std::shared_ptr<JobReport>;

  /// What jobs may take: the limit without what the program has by itself.
  static std::uint64_t limitOf(const BakeOptions& options) {
    const std::uint64_t limit = memoryLimit(options);
    return limit - std::min(limit, residentMemory());
  }

  Finished bake(std::size_t index) {
    JobOptions job;
    job.keepGoing = options_.keepGoing;
    job.dryRun = options_.dryRun;
    job.stop = interrupted;
    job.context.cache = cache_;
    job.context.locks = &locks_;
    job.context.memory = &gate_;
    job.context.progress = [&](double share) {
      if (plan_.jobs.size() == 1) bar_.update(share);
      return !interrupted();
    };
    if (!options_.quiet) {
      job.context.done = [&](const MeshBake& mesh) { say(mesh); };
      job.lit = [&](const MeshBake& mesh) {
        if (mesh.apertures) bar_.line(fmt::format("{}: {}", mesh.source, summaryLine(*mesh.apertures)));
        if (mesh.apertureMap) bar_.line(fmt::format("{}: {}", mesh.source, summaryLine(*mesh.apertureMap)));
      };
      job.read = [&](const InputReport& input) { say(input.path.filename().string(), input.notes); };
    }
    return std::make_shared<JobReport>(runJob(plan_.jobs[index], job));
  }

  void say(const std::string& source, const std::vector<std::string>& notes) {
    for (const std::string& note : notes) bar_.line(fmt::format("{}: note: {}", source, note));
  }

  void say(const MeshBake& mesh) {
    if (mesh.asset) {
      bar_.line(summaryLine(mesh));
      std::vector<std::string> notes;
      for (const Defect& defect : defectsOf(mesh)) notes.push_back(defect.text);
      say(mesh.source, notes);
    } else if (options_.dryRun) {
      bar_.line(fmt::format("{}: {} faces, would be baked", mesh.source, grouped(mesh.faces)));
    }
  }

  /// Takes the result of a job, in order.
  void take(const Finished& job) {
    if (job->outcome == JobOutcome::interrupted) return;
    count(summary_, job->inputs, job->bake, job->outcome == JobOutcome::upToDate, options_.dryRun);
    for (const InputReport& input : job->inputs)
      for (const Error& error : input.errors) complain(error);
    if (job->error) complain(*job->error);
    good_ |= job->outcome <= JobOutcome::partial;
    failed_ |= job->outcome == JobOutcome::partial || job->outcome == JobOutcome::failed;
    unwritten_ |= job->outcome == JobOutcome::cannotWrite;
    if (!job->files.empty()) remember(*job);
    if (json_) json_->add(job->inputs, job->bake, job->files);
    for (const fs::path& file : job->files)
      if (!json_ && (!options_.each || &file == &job->files.back())) printResult(file.string() + "\n");
    ++taken_;
    if (plan_.jobs.size() > 1) bar_.update(static_cast<double>(taken_) / static_cast<double>(plan_.jobs.size()));
  }

  void remember(const JobReport& job) {
    if (options_.depfile.empty()) return;
    Dependencies rule{job.files.back(), job.inputFiles};
    rule.inputs.insert(rule.inputs.end(), plan_.configs.begin(), plan_.configs.end());
    rules_.push_back(std::move(rule));
  }

  Result<Done> writeDepfile() const {
    if (options_.depfile.empty() || options_.dryRun || !good_) return Done{};
    const auto text = depfileText(rules_);
    if (!text) return text.error();
    return writeFileAtomically(options_.depfile, std::string_view(text.value()));
  }

  ExitCode finish() {
    if (cache_)
      for (const std::string& note : cache_->takeNotes())
        if (!options_.quiet) bar_.line("note: " + note);
    if (interrupted()) return kInterrupted;
    if (const auto written = writeDepfile(); !written) {
      complain(written.error());
      unwritten_ = true;
    }
    summary_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    summary_.peakMemory = peakMemory();
    summary_.memoryLimit = memoryLimit(options_);
    if (json_) json_->finish(summary_, options_.dryRun);
    if (!options_.quiet && !json_ && good_) bar_.line(summaryLine(summary_));  // the document says it, too
    if (unwritten_) return kCannotWrite;
    if (!failed_) return kOk;
    return good_ ? kPartial : kBadInput;
  }

  const BakeOptions& options_;
  const BakePlan& plan_;
  Cache* cache_;
  KeyLocks locks_;
  MemoryGate gate_;
  ProgressBar bar_;
  std::optional<JsonReport> json_;
  const std::chrono::steady_clock::time_point start_;
  std::size_t next_ = 0;
  std::size_t taken_ = 0;
  RunSummary summary_;
  std::vector<Dependencies> rules_;
  bool good_ = false;
  bool failed_ = false;
  bool unwritten_ = false;
};

/// The cache that the options ask for, or null.
Result<std::unique_ptr<Cache>> openCache(const BakeOptions& options) {
  const fs::path folder = options.cache.empty() && options.each ? options.folder / ".overcast-cache" : options.cache;
  if (folder.empty()) return std::unique_ptr<Cache>();
  return Cache::open(folder, options.cacheLimit, options.dryRun ? CacheUse::readOnly : CacheUse::readWrite);
}

}  // namespace

int bakeCommand(const std::vector<std::string>& arguments) {
  CLI::App app("Bakes occluders of meshes and scenes into a glTF scene that overcast-player opens.", "overcast-bake");
  BakeOptions options;
  addBakeOptions(app, options);
  if (const int code = parseArguments(app, arguments); code >= 0) return code;
  const auto planned = planBake(options);
  if (const auto* wrong = std::get_if<PlanError>(&planned)) {
    complain(wrong->error);
    return wrong->fault == PlanFault::usage ? kUsage : kBadInput;
  }
  // Before any work: nobody wants to hear after an hour that the result cannot be kept.
  for (const fs::path& folder : {options.folder, options.depfile.parent_path()})
    if (const auto writable = checkWritable(folder); !writable) {
      complain(writable.error());
      return kCannotWrite;
    }
  auto cache = openCache(options);
  if (!cache) {
    complain(cache.error());
    return kCannotWrite;
  }
  watchInterrupts();
  returnLargeBlocks();
  std::optional<tbb::global_control> limit;
  if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
  return Run(options, std::get<BakePlan>(planned), cache.value().get()).run();
}

}  // namespace overcast
