// Bake report: what a bake found and made, as lines for people and as JSON for programs.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bake/scene_bake.h"

namespace overcast {

/// "bunny.off: 69,630 faces, 32x31x25, 0.12 s, rms 0.03 voxel, closed, signed-crossings", or of a chosen asset
/// "bunny.off: 69,630 faces, volume 24 half, 31,415 bytes, 0.41 s, surface rms 0.62 % of the diagonal, closed" (and, before "closed",
/// "3 points on the wrong side" where some of those measured are; "cached" for the seconds of one from
/// the cache)
std::string summaryLine(const MeshBake& mesh);

/// "apertures: 34,817 vertices, 12 in solids, 3 shut, 0.41 s, between vertices rms 0.012 rad of radius, 0.008 of sky light"
std::string summaryLine(const ApertureReport& report);

/// "aperture map: 512x512, 180,312 texels in 1 chart, 12 in solids, 3 shut, 2.10 s, 1,234,567 bytes, between texels rms 0.012 rad of
/// radius, 0.008 of sky light"
std::string summaryLine(const ApertureMapReport& report);

/// The record as JSON text: diagonal, withinLimits, chosen (an index), scores.
std::string choiceJson(const ChoiceRecord& record);

/// What the user should know about how a mesh was read, one line each without its name; empty for a clean one.
std::vector<std::string> remarks(const MeshReadReport& report);

/// The number with thousands separated by commas.
std::string grouped(std::uint64_t number);

/// "1 edge", "1,234 edges".
std::string counted(std::uint64_t number, const char* one, const char* many);

/// What happened to one input besides its meshes.
struct InputReport {
  std::filesystem::path path;
  std::vector<std::string> notes;
  std::vector<Error> errors;
};

/// Totals of a run, for the end of the document and for the summary.
struct RunSummary {
  std::uint64_t inputs = 0;
  std::uint64_t meshesBaked = 0;
  std::uint64_t meshesCached = 0;  ///< taken from the cache, or found up to date
  std::uint64_t upToDate = 0;      ///< inputs whose whole result lay there already
  std::uint64_t failed = 0;        ///< inputs
  double seconds = 0.0;
  std::uint64_t peakMemory = 0;  ///< bytes resident at most, this process alone
  std::uint64_t memoryLimit = 0;
};

/// Adds what the meshes and inputs of one job say; `planned`: meshes that are not baked yet count as if they were.
void count(RunSummary& summary, const std::vector<InputReport>& inputs, const SceneBake& bake, bool upToDate, bool planned = false);

/// "3 inputs: 2 meshes baked, 1 from the cache, 0 inputs failed; 1.2 s, peak memory 81 MB"
std::string summaryLine(const RunSummary& summary);

/// The document of `overcast-bake --json`, version 1, written piece by piece so that it need not fit into memory: inputs (file, notes,
/// errors, meshes), files (path, bytes), summary, seconds. Lengths are in local units of the mesh, errors also in voxels.
class JsonReport {
 public:
  using Print = std::function<void(const std::string&)>;
  explicit JsonReport(Print print);
  void add(const std::vector<InputReport>& inputs, const SceneBake& bake, const std::vector<std::filesystem::path>& files);
  void finish(const RunSummary& summary, bool dryRun);

 private:
  void begin();

  Print print_;
  bool begun_ = false;
  bool first_ = true;
  std::vector<std::filesystem::path> files_;
};

}  // namespace overcast
