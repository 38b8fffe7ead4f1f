#include "bake/reference_job.h"

#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "formats/archive.h"
#include "formats/files.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

View viewOf(const Scene& scene, const ReferenceJob& job) {
  return chooseView(scene, worldBounds(scene), job.camera, job.time, static_cast<double>(job.width) / job.height);
}

/// Hash of all that decides what is traced.
std::string inputsOf(const std::string& sceneHash, const ReferenceJob& job, const View& view, const TraceSettings& settings) {
  std::string text = fmt::format("reference {}\n{}\n{}\n", kTraceVersion, sceneHash, settingsText(settings));
  if (job.sky != nullptr) text += fmt::format("sky {}\n", job.sky->hash);
  if (job.points > 0) {
    text += fmt::format("points {}", job.points);
  } else {
    text += fmt::format("view {} {} {} {}", job.width, job.height, view.verticalFieldOfView, view.nearPlane);
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 3; ++row) text += fmt::format(" {}", view.worldFromView[column][row]);
  }
  return contentHash(std::as_bytes(std::span(text)));
}

/// What the file says besides what was traced.
void name(ReferenceInfo& info, const ReferenceJob& job, const std::string& sceneName, const std::string& picture) {
  info.scene = sceneName;
  info.picture = picture;
  info.camera = job.cameraName;
  info.frame = job.frame;
  info.time = job.time;
}

/// The info of the file when it is whole and of these inputs.
std::optional<ReferenceInfo> present(const fs::path& json, const std::string& inputs) {
  const auto info = readReferenceInfo(json);
  if (!info || info.value().inputs != inputs) return std::nullopt;
  const auto hash = fileHash(json.parent_path() / info.value().picture);
  if (!hash || hash.value() != info.value().pictureHash) return std::nullopt;
  return info.value();
}

/// An entry of the cache.
struct CachedReference {
  std::string json;
  std::uint64_t bytes = 0;  ///< of the picture
};

template <class Archive>
void fields(Archive& archive, CachedReference& value) {
  archive(value.json, value.bytes);
}

/// Info and picture from the cache.
std::optional<std::pair<ReferenceInfo, Cache::Bytes>> fetch(Cache& cache, const std::string& inputs) {
  const auto entry = cache.entry(inputs);
  if (!entry) return std::nullopt;
  ArchiveReader reader{Unpacker(*entry)};
  CachedReference cached;
  reader(cached);
  auto info = parseReferenceInfo(cached.json, "");
  if (!reader.rest.good() || !info || info.value().inputs != inputs) return std::nullopt;
  auto picture = cache.object(info.value().pictureHash, cached.bytes);
  if (!picture) return std::nullopt;
  return std::pair(std::move(info).value(), std::move(*picture));
}

void store(Cache& cache, const fs::path& json, const ReferenceInfo& info) {
  const auto picture = readFile(json.parent_path() / info.picture);
  if (!picture) return;
  CachedReference cached{referenceJson(info), picture.value().size()};
  ArchiveWriter writer;
  writer(cached);
  cache.storeObject(info.pictureHash, picture.value());
  cache.storeEntry(info.inputs, writer.bytes);
}

ReferenceReport failed(ReferenceOutcome outcome, const Error& error) {
  return {outcome, {}, error};
}

Result<Done> writeCached(const ReferenceJob& job, const ReferenceInfo& info, const Cache::Bytes& picture) {
  const auto written = writeFileAtomically(job.json.parent_path() / info.picture, picture);
  if (!written) return written;
  return writeFileAtomically(job.json, std::string_view(referenceJson(info)));
}

Result<Done> writePreview(const fs::path& json, const Scene& scene) {
  const auto reference = readReference(json);
  if (!reference) return reference.error();
  const double exposure = static_cast<double>(scene.lighting.value_or(Lighting{}).exposure);
  return writePng(fs::path(json).replace_extension(".png"), previewOf(reference.value(), exposure));
}

ReferenceReport traceJob(const Scene& scene, const ReferenceJob& job, const View& view, const TraceSettings& settings,
                         const std::pair<std::string, std::string>& hashes, const std::string& sceneName, const Progress& progress) {
  const auto traced = makeTracedScene(scene, job.time, job.sky);
  if (!traced) return failed(ReferenceOutcome::badScene, {sceneName, fmt::format("frame {}", job.frame), traced.error().reason});
  auto reference = job.points > 0 ? tracePoints(traced.value(), job.points, settings, progress)
                                  : traceView(traced.value(), {view, job.width, job.height}, settings, progress);
  if (!reference) return failed(ReferenceOutcome::stopped, {});
  std::tie(reference->info.sceneHash, reference->info.inputs) = hashes;
  name(reference->info, job, sceneName, "");
  if (const auto written = writeReference(job.json, *reference); !written) return failed(ReferenceOutcome::cannotWrite, written.error());
  return {ReferenceOutcome::traced, reference->info, {}};
}

}  // namespace

ReferenceReport runReferenceJob(const Scene& scene, const std::string& sceneName, const ReferenceJob& job, const TraceSettings& settings,
                                Cache* cache, bool preview, const Progress& progress) {
  const View view = job.points > 0 ? View{} : viewOf(scene, job);
  const std::string sceneHash = tracedHash(scene, job.time), inputs = inputsOf(sceneHash, job, view, settings);
  const std::string picture = fs::path(job.json).replace_extension(".exr").filename().string();
  ReferenceReport report;
  if (const auto there = present(job.json, inputs)) {
    report = {ReferenceOutcome::upToDate, *there, {}};
  } else if (auto cached = cache == nullptr ? std::nullopt : fetch(*cache, inputs)) {
    name(cached->first, job, sceneName, picture);
    if (const auto written = writeCached(job, cached->first, cached->second); !written)
      return failed(ReferenceOutcome::cannotWrite, written.error());
    report = {ReferenceOutcome::cached, cached->first, {}};
  } else {
    report = traceJob(scene, job, view, settings, {sceneHash, inputs}, sceneName, progress);
    if (report.outcome != ReferenceOutcome::traced) return report;
    if (cache != nullptr) store(*cache, job.json, report.info);
  }
  if (!preview) return report;
  if (const auto written = writePreview(job.json, scene); !written) return failed(ReferenceOutcome::cannotWrite, written.error());
  return report;
}

}  // namespace overcast
