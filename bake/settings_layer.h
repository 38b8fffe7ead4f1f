// Settings layers: where the settings of a bake come from. A preset, a config file, its rules and the command line each say something;
// later ones win, and what nobody says has its default.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "bake/mesh_bake.h"

namespace overcast {

inline constexpr double kMaxPadding = 255.0;
inline constexpr std::uint64_t kMaxErrorSamples = 100'000'000;

/// What one source says; empty: nothing.
struct SettingsLayer {
  std::optional<std::string> preset;
  std::optional<std::string> representation;  ///< "auto" or the name of one
  std::optional<double> maxError;
  std::optional<double> maxSkyError;
  std::optional<std::uint64_t> maxBytes;
  std::optional<int> largest;
  std::optional<int> resolution;
  std::optional<double> voxelSize;
  std::optional<double> padding;
  std::optional<VolumeBits> bits;
  std::optional<SheetMode> sheets;
  std::optional<double> thickness;
  std::optional<std::uint64_t> errorSamples;
  std::optional<std::uint64_t> seed;
};

/// Settings under one name.
struct Preset {
  const char* name;
  const char* use;  ///< what for
  double maxError;
  double maxSkyError;
  int largest;
  std::uint64_t errorSamples;
};

/// preview, game, film.
std::span<const Preset> presets();
/// What each of them stands for, for --help.
std::string presetHelp();

/// Names of the precisions on disk.
const std::map<std::string, VolumeBits>& volumeBitsNames();

/// Names of what may be a sheet (bake/sheets.h).
const std::map<std::string, SheetMode>& sheetModeNames();

/// What is wrong with one source by itself, as a reason: an unknown preset, or settings that exclude each other; empty when nothing is. A
/// size (resolution, voxelSize, bits) asks for a volume of that size and leaves nothing to choose.
std::string contradiction(const SettingsLayer& layer);

/// `base` with what `top` says on top. The preset of a layer stands for what it says wherever that layer says nothing itself. A size on top
/// drops what the base says about the choice, and the other way round. Neither layer contradicts itself.
SettingsLayer overlaid(const SettingsLayer& base, const SettingsLayer& top);

/// The settings of a bake. An Error without a file when a choice is to be made without measuring.
Result<BakeSettings> bakeSettings(const SettingsLayer& layer);

}  // namespace overcast
