// Bake options: the command line of `overcast-bake bake`, and what it comes to together with a config file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "bake/aperture_options.h"
#include "bake/bake_job.h"
#include "bake/cache.h"
#include "bake/choice_options.h"
#include "bake/settings_layer.h"
#include "formats/terrain.h"

namespace overcast {

/// As given on the command line.
struct BakeOptions {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path folder;
  std::string name;
  std::filesystem::path config;  ///< empty: none, as of the paths below
  std::filesystem::path cache;
  std::filesystem::path depfile;
  SettingsLayer settings;  ///< without what `choice` says
  ChoiceOptions choice;
  ApertureOptions apertures;
  TerrainOptions terrain;
  std::uint64_t cacheLimit = kDefaultCacheLimit;
  std::uint64_t memory = 0;  ///< 0: three quarters of what is available
  int threads = 0;
  bool each = false;
  bool dryRun = false;
  bool json = false;
  bool quiet = false;
  bool keepGoing = false;
};

/// Adds the options to `app`.
void addBakeOptions(CLI::App& app, BakeOptions& options);

/// What there is to do, in order.
struct BakePlan {
  std::vector<BakeJob> jobs;                   ///< one; with --each one for every input
  std::vector<std::filesystem::path> configs;  ///< config and list files that decide over all of them
};

/// Where a plan failed: wrong arguments or config, or an input.
enum class PlanFault { usage, input };
struct PlanError {
  PlanFault fault = PlanFault::usage;
  Error error;
};

/// Expands folders and lists and settles the settings of every input: defaults, then the config, then the command line on top.
std::variant<BakePlan, PlanError> planBake(const BakeOptions& options);

}  // namespace overcast
