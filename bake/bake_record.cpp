#include "bake/bake_record.h"

#include <chrono>
#include <system_error>

#include "formats/archive.h"
#include "formats/files.h"
#include "formats/occluder_fields.h"
#include "formats/scene.h"

namespace overcast {

// The structured bindings name every member: who adds one finds here that the cache has to keep it.

template <class Archive>
void fields(Archive& archive, MeshDiagnosis& found) {
  auto& [merged, degenerate, duplicate, boundary, nonManifold, inconsistent, components, reoriented, turned, closed, insideOut] = found;
  archive(merged, degenerate, duplicate, boundary, nonManifold, inconsistent, components, reoriented, turned, closed, insideOut);
}

template <class Archive>
void fields(Archive& archive, Candidate& candidate) {
  auto& [representation, size, bits, shape, otherSide] = candidate;
  archive(representation, size, bits, shape, otherSide);
}

template <class Archive>
void fields(Archive& archive, Score& score) {
  auto& [candidate, bytes, error, composite, reason, thickened] = score;
  archive(candidate, bytes, error, composite, reason, thickened);
}

template <class Archive>
void fields(Archive& archive, ChoiceRecord& record) {
  auto& [scores, chosen, diagonal, withinLimits] = record;
  archive(scores, chosen, diagonal, withinLimits);
}

template <class Archive>
void fields(Archive& archive, EncodedAsset& asset) {
  archive(asset.extension);  // the bytes are an object of the cache
}

template <class Archive>
void fields(Archive& archive, InterpolationError& error) {
  auto& [radius, ambient, direction] = error;
  archive(radius, ambient, direction);
}

template <class Archive>
void fields(Archive& archive, ApertureReport& report) {
  auto& [vertices, points, interior, inward, shut, rays, seconds, samples, sampled, error, fitted] = report;
  archive(vertices, points, interior, inward, shut, rays, seconds, samples, sampled, error, fitted);
}

template <class Archive>
void fields(Archive& archive, ApertureMapReport& report) {
  auto& [size, traced, covered, overlapping, charts, interior, shut, rays, seconds, bytes, levels, samples, error] = report;
  archive(size, traced, covered, overlapping, charts, interior, shut, rays, seconds, bytes, levels, samples, error);
}

template <class Archive>
void fields(Archive& archive, MeshBake& bake) {
  auto& [mesh, input, source, sameAs, hash, faces, heights, seconds, cached, asset, volume, found, ambiguousSign, sheetTriangles, surface,
         inBox, choice, apertures, apertureMap, mapBytes, error, occluder] = bake;
  archive(mesh, input, source, sameAs, hash, faces, heights, seconds, asset, volume, found, ambiguousSign, sheetTriangles, surface, inBox,
          choice, apertures, apertureMap, occluder);
}

template <class Archive>
void fields(Archive& archive, OutputFile& file) {
  archive(file.path, file.hash, file.bytes);
}

template <class Archive>
void fields(Archive& archive, SceneRecord& record) {
  archive(record.notes, record.meshes, record.files);
}

namespace {

namespace fs = std::filesystem;

std::string meshKey(const std::string& hash) {
  const std::string text = fmt::format("mesh {} {}", programHash(), hash);
  return contentHash(std::as_bytes(std::span(text)));
}

bool isIntact(const OutputFile& file, const fs::path& folder) {
  std::error_code code;
  if (fs::file_size(folder / file.path, code) != file.bytes || code) return false;
  const auto hash = fileHash(folder / file.path);
  return hash && hash.value() == file.hash;
}

/// The name of the scene's .bin, which lies beside it; empty when there is none.
std::string binaryOf(const SceneRecord& record) {
  for (const OutputFile& file : record.files)
    if (file.path.ends_with(".bin") && file.path.find('/') == std::string::npos) return file.path;
  return "";
}

}  // namespace

bool restoreMesh(Cache& cache, MeshBake& job) {
  const auto payload = cache.entry(meshKey(job.hash));
  if (!payload) return false;
  auto kept = unarchived<MeshBake>(*payload);
  if (!kept || kept->hash != job.hash || !kept->asset) return false;
  if (!kept->asset->extension.empty()) {
    auto bytes = cache.object(kept->occluder.contentHash, kept->occluder.bytes);
    if (!bytes) return false;
    kept->asset->bytes = std::move(*bytes);
  }
  kept->mesh = job.mesh;
  kept->input = job.input;
  kept->source = job.source;
  kept->sameAs = job.sameAs;
  kept->heights = job.heights;
  job = std::move(*kept);
  job.cached = true;
  return true;
}

void keepMesh(Cache& cache, const MeshBake& job) {
  if (!job.asset->extension.empty()) cache.storeObject(job.occluder.contentHash, job.asset->bytes);
  cache.storeEntry(meshKey(job.hash), archived(job));
}

std::optional<SceneRecord> findScene(Cache& cache, const std::string& key) {
  const auto payload = cache.entry(key);
  if (!payload) return std::nullopt;
  auto record = unarchived<SceneRecord>(*payload);
  if (!record) return std::nullopt;
  for (MeshBake& mesh : record->meshes) mesh.cached = true;
  return record;
}

void keepScene(Cache& cache, const std::string& key, const SceneRecord& record, const fs::path& folder) {
  for (const OutputFile& file : record.files) {
    const auto bytes = readFile(folder / file.path);
    if (!bytes || contentHash(bytes.value()) != file.hash) return;
    cache.storeObject(file.hash, bytes.value());
  }
  cache.storeEntry(key, archived(record));
}

Result<Restored> restoreScene(Cache& cache, const SceneRecord& record, const fs::path& folder, bool dryRun) {
  Restored outcome = Restored::intact;
  for (const OutputFile& file : record.files) {
    if (isIntact(file, folder)) continue;
    const auto bytes = cache.object(file.hash, file.bytes);
    if (!bytes) return Restored::missing;
    outcome = Restored::rewritten;
    if (dryRun) continue;
    if (const auto written = writeFileAtomically(folder / file.path, *bytes); !written) return written.error();
  }
  if (dryRun || record.files.empty()) return outcome;
  const fs::path scene = folder / record.files.back().path;
  if (outcome == Restored::rewritten) removeOldBinaries(scene, binaryOf(record));
  std::error_code code;
  fs::last_write_time(scene, fs::file_time_type::clock::now(), code);
  return outcome;
}

Result<std::vector<OutputFile>> describeFiles(const std::vector<fs::path>& files, const fs::path& folder) {
  std::vector<OutputFile> described;
  for (const fs::path& file : files) {
    const auto hash = fileHash(file);
    if (!hash) return hash.error();
    std::error_code code;
    described.push_back({file.lexically_relative(folder).generic_string(), hash.value(), fs::file_size(file, code)});
  }
  return described;
}

}  // namespace overcast
