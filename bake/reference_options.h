// Reference options: the command line of `overcast-bake reference`.
#pragma once

#include <filesystem>
#include <vector>

#include "bake/reference_job.h"
#include "formats/result.h"

namespace CLI {
class App;
}

namespace overcast {

/// As given on the command line.
struct ReferenceOptions {
  std::filesystem::path scene;
  std::filesystem::path folder;
  std::filesystem::path cache;
  std::filesystem::path sky;
  std::string frames = "0";
  std::string size = "640x360";
  std::vector<std::string> cameras;
  std::vector<std::string> quantities;
  double framesPerSecond = 30.0;
  std::uint64_t points = 0;
  bool pointsOnly = false;
  TraceSettings trace;
  int threads = 0;
  bool preview = false;
  bool json = false;
  bool quiet = false;
};

/// Adds the options to `app`.
void addReferenceOptions(CLI::App& app, ReferenceOptions& options);

/// The files they ask for, in order: for every frame every view (view0_0000.json, view1_0000.json, ...), then its points
/// (points_0000.json). An Error that names the option at fault. Sets options.trace.
Result<std::vector<ReferenceJob>> referenceJobs(ReferenceOptions& options);

}  // namespace overcast
