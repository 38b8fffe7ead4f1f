#include "bake/bake_job.h"

#include <sys/stat.h>

#include <algorithm>
#include <memory>
#include <span>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "bake/bake_record.h"
#include "bake/memory.h"
#include "formats/files.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

/// What a file looked like when it was read: another look tells whether it was changed meanwhile.
struct Look {
  dev_t device = 0;
  ino_t inode = 0;
  off_t size = -1;
  timespec changed{};
  bool operator==(const Look& other) const {
    return device == other.device && inode == other.inode && size == other.size && changed.tv_sec == other.changed.tv_sec &&
           changed.tv_nsec == other.changed.tv_nsec;
  }
};

Look lookAt(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino, status.st_size, status.st_mtim};
}

/// Every file that decides what comes out of an input; the input alone where it cannot be told.
std::vector<fs::path> filesOf(const fs::path& input) {
  if (isSceneFile(input))
    if (auto files = sceneFiles(input); files.ok()) return std::move(files).value();
  return {input};
}

/// Hash of all that decides what the job makes; nothing when an input cannot be read, which reading it in earnest will explain.
std::optional<std::string> keyOf(const BakeJob& job, const std::vector<std::vector<fs::path>>& files) {
  std::string text = fmt::format("scene {} {}", programHash(), job.name);
  text += fmt::format("\n{}", settingsText(job.terrain));
  if (job.apertures) text += fmt::format("\n{}", settingsText(*job.apertures));
  for (std::size_t i = 0; i < job.inputs.size(); ++i) {
    text += fmt::format("\n{}\n{}", job.inputs[i].filename().string(), settingsText(job.settings[i]));
    for (const fs::path& file : files[i]) {
      const auto hash = fileHash(file);
      if (!hash) return std::nullopt;
      text += " " + hash.value();
    }
  }
  return contentHash(std::as_bytes(std::span(text)));
}

/// One run of a job.
class Runner {
 public:
  Runner(const BakeJob& job, const JobOptions& options) : job_(job), options_(options) {}

  JobReport run() {
    listFiles();
    if (stopped()) return finished(JobOutcome::interrupted);
    if (options_.context.cache && restored()) return std::move(report_);
    MemoryGate unlimited(~std::uint64_t{0});
    MemoryGate& everything = options_.context.memory ? *options_.context.memory : unlimited;
    MemoryGate::Share share(everything, expectedMemory());
    MemoryGate own(std::min(expectedMemory(), everything.limit()));
    std::vector<std::unique_ptr<MemoryGate::Share>> held(job_.inputs.size());
    std::vector<BakeInput> inputs = readInputs(own, held);
    if (stopped()) return finished(JobOutcome::interrupted);
    share.shrink(knownMemory(inputs));
    const bool readAll = inputs.size() == job_.inputs.size();
    report_.bake = joinInputs(std::move(inputs));
    if (options_.dryRun) return plan();
    if (readAll || options_.keepGoing) {
      BakeContext context = options_.context;
      context.memory = &own;
      bakeMeshes(report_.bake, context);
      if (job_.apertures && !stopped()) bakeSceneApertures(report_.bake, *job_.apertures, context.progress, options_.lit);
    }
    if (stopped()) return finished(JobOutcome::interrupted);
    return write();
  }

 private:
  bool stopped() const { return options_.stop && options_.stop(); }

  JobReport finished(JobOutcome outcome) {
    report_.outcome = outcome;
    report_.bake.scene = {};
    for (MeshBake& mesh : report_.bake.meshes) {
      if (mesh.asset) mesh.asset->bytes = {};
      mesh.mapBytes = {};
    }
    return std::move(report_);
  }

  fs::path sceneFile() const { return job_.folder / (job_.name + ".gltf"); }

  void listFiles() {
    std::vector<std::vector<fs::path>> files(job_.inputs.size());
    tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t i) { files[i] = filesOf(job_.inputs[i]); });
    for (const auto& some : files) report_.inputFiles.insert(report_.inputFiles.end(), some.begin(), some.end());
    if (!options_.context.cache) return;
    for (const fs::path& file : report_.inputFiles) looks_.push_back(lookAt(file));
    key_ = keyOf(job_, files);
  }

  /// Takes the whole result from the cache when it is there.
  bool restored() {
    if (!key_) return false;
    std::optional<SceneRecord> record = findScene(*options_.context.cache, *key_);
    if (!record || record->notes.size() != job_.inputs.size()) return false;
    const auto outcome = restoreScene(*options_.context.cache, *record, job_.folder, options_.dryRun);
    if (outcome && outcome.value() == Restored::missing) return false;
    report_.bake.inputs = job_.inputs;
    report_.bake.settings = job_.settings;
    for (std::size_t i = 0; i < job_.inputs.size(); ++i) {
      report_.inputs.push_back({job_.inputs[i], record->notes[i], {}});
      if (options_.read) options_.read(report_.inputs.back());
    }
    report_.bake.meshes = std::move(record->meshes);
    if (!outcome) {
      report_.outcome = JobOutcome::cannotWrite;
      report_.error = outcome.error();
      return true;
    }
    report_.outcome = outcome.value() == Restored::intact ? JobOutcome::upToDate : JobOutcome::restored;
    if (options_.context.done && outcome.value() == Restored::rewritten)
      for (const MeshBake& mesh : report_.bake.meshes)
        if (mesh.sameAs < 0) options_.context.done(mesh);
    if (options_.lit && outcome.value() == Restored::rewritten)
      for (const MeshBake& mesh : report_.bake.meshes) options_.lit(mesh);
    for (const OutputFile& file : record->files)
      if (!options_.dryRun || &file == &record->files.back()) report_.files.push_back(job_.folder / file.path);
    return true;
  }

  /// What the job may need, as far as the sizes of the files tell.
  std::uint64_t expectedMemory() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < job_.inputs.size(); ++i) {
      const FileMemory file = fileMemory(job_.inputs[i], job_.settings[i]);
      sum += file.read + file.bake;
    }
    return sum;
  }

  /// What the job may still need once its meshes are known.
  static std::uint64_t knownMemory(const std::vector<BakeInput>& inputs) {
    std::uint64_t sum = 0;
    for (const BakeInput& input : inputs)
      for (const Mesh& mesh : input.scene.meshes) sum += meshMemory(mesh) + bakeMemory(mesh, input.settings);
    return sum;
  }

  /// Reads all inputs, several at once, and keeps the good ones in the order given. `held` is what their meshes take from the gate.
  std::vector<BakeInput> readInputs(MemoryGate& gate, std::vector<std::unique_ptr<MemoryGate::Share>>& held) {
    std::vector<std::optional<Result<BakeInput>>> read(job_.inputs.size());
    tbb::parallel_for(std::size_t{0}, read.size(), [&](std::size_t i) {
      held[i] = std::make_unique<MemoryGate::Share>(gate, fileMemory(job_.inputs[i], job_.settings[i]).read);
      if (!stopped()) read[i].emplace(readBakeInput(job_.inputs[i], job_.terrain));
      std::uint64_t kept = 0;
      if (read[i] && read[i]->ok())
        for (const Mesh& mesh : read[i]->value().scene.meshes) kept += meshMemory(mesh);
      held[i]->settle(kept);
    });
    std::vector<BakeInput> good;
    for (std::size_t i = 0; i < read.size(); ++i) {
      InputReport report{job_.inputs[i], {}, {}};
      if (read[i] && read[i]->ok()) {
        BakeInput& input = read[i]->value();
        input.settings = job_.settings[i];
        if (input.report) report.notes = remarks(*input.report);
        report.notes.insert(report.notes.end(), input.scene.notes.begin(), input.scene.notes.end());
        good.push_back(std::move(input));
      } else if (read[i]) {
        report.errors.push_back(read[i]->error());
      }
      if (options_.read) options_.read(report);
      report_.inputs.push_back(std::move(report));
    }
    return good;
  }

  /// Adds the errors of the bake to their inputs and says whether there is any error at all.
  bool collectErrors() {
    for (const MeshBake& mesh : report_.bake.meshes) {
      if (!mesh.error) continue;
      for (InputReport& input : report_.inputs)
        if (input.path == report_.bake.inputs[static_cast<std::size_t>(mesh.input)]) {
          input.errors.push_back(*mesh.error);
          break;
        }
    }
    return std::any_of(report_.inputs.begin(), report_.inputs.end(), [](const InputReport& input) { return !input.errors.empty(); });
  }

  bool holdsMesh() const {
    const std::vector<Node>& nodes = report_.bake.scene.nodes;
    return std::any_of(nodes.begin(), nodes.end(), [](const Node& node) { return node.mesh >= 0; });
  }

  /// Says what a bake would do.
  JobReport plan() {
    const bool failed = collectErrors();
    for (MeshBake& mesh : report_.bake.meshes) {
      if (mesh.sameAs < 0 && options_.context.cache) restoreMesh(*options_.context.cache, mesh);
      if (mesh.sameAs < 0 && options_.context.done) options_.context.done(mesh);
    }
    const bool writes = !failed || (options_.keepGoing && holdsMesh());
    if (writes) report_.files.push_back(sceneFile());
    return finished(!failed ? JobOutcome::baked : writes ? JobOutcome::partial : JobOutcome::failed);
  }

  JobReport write() {
    const bool failed = collectErrors();
    if (failed) dropFailedInputs(report_.bake);
    if (failed && !(options_.keepGoing && holdsMesh())) return finished(JobOutcome::failed);
    auto written = writeBake(report_.bake, job_.folder, job_.name);
    if (!written) {
      report_.error = written.error();
      return finished(JobOutcome::cannotWrite);
    }
    report_.files = std::move(written).value();
    if (!failed) keep();
    return finished(failed ? JobOutcome::partial : JobOutcome::baked);
  }

  /// Keeps the whole result, unless an input was changed while it was baked.
  void keep() {
    if (!key_) return;
    for (std::size_t i = 0; i < report_.inputFiles.size(); ++i)
      if (!(lookAt(report_.inputFiles[i]) == looks_[i])) return;
    for (MeshBake& mesh : report_.bake.meshes)
      if (mesh.asset) mesh.asset->bytes = {};
    SceneRecord record;
    for (const InputReport& input : report_.inputs) record.notes.push_back(input.notes);
    record.meshes = report_.bake.meshes;
    auto files = describeFiles(report_.files, job_.folder);
    if (!files) return;
    record.files = std::move(files).value();
    keepScene(*options_.context.cache, *key_, record, job_.folder);
  }

  const BakeJob& job_;
  const JobOptions& options_;
  JobReport report_;
  std::optional<std::string> key_;
  std::vector<Look> looks_;  ///< of report_.inputFiles, before any of them was read
};

}  // namespace

JobReport runJob(const BakeJob& job, const JobOptions& options) {
  return Runner(job, options).run();
}

}  // namespace overcast
