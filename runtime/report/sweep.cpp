#include "runtime/report/sweep.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "runtime/passes/shade/sky_estimator.h"

namespace overcast {
namespace {

/// A setting of ours in a report. A row here is all that another takes.
struct SweepRow {
  const char* estimator;
  int resolution;
  int taps;                           ///< as SweepSetting::taps
  int cones = 0;                      ///< as SweepSetting::cones
  bool apertures = false;             ///< needs them; the others are for scenes with and without
  SweepSize least = SweepSize::full;  ///< the smallest sweep that takes it
  ApertureMode apertureMode = ApertureMode::accurate;
};

constexpr ApertureMode kBest = ApertureMode::accurate;
constexpr SweepSize kVariant = SweepSize::variant, kQuick = SweepSize::quick, kFull = SweepSize::full;
constexpr bool kWithApertures = true;

constexpr std::array kSweep{
    SweepRow{"published", 64, 5, 0, false, kQuick},
    SweepRow{"published", 128, 4, 0, false, kQuick},
    SweepRow{"published", 128, 5, 0, false, kQuick},
    SweepRow{"published", 256, 5, 0, false, kQuick},
    SweepRow{"published", 32, 5},
    SweepRow{"published", 96, 5},
    SweepRow{"published", 128, 6},
    SweepRow{"published", 192, 5},
    SweepRow{"calibrated", 64, 4, 0, false, kQuick},
    SweepRow{"calibrated", 128, 4, 0, false, kVariant},
    SweepRow{"calibrated", 128, 6, 0, false, kQuick},
    SweepRow{"calibrated", 256, 4, 0, false, kQuick},
    SweepRow{"calibrated", 32, 4},
    SweepRow{"calibrated", 96, 4},
    SweepRow{"calibrated", 128, 5},
    SweepRow{"calibrated", 192, 4},
    SweepRow{"cones", 64, 5, 0, false, kQuick},
    SweepRow{"cones", 128, 4},
    SweepRow{"cones", 128, 5, 0, false, kQuick},
    SweepRow{"cones", 128, 5, 4},
    SweepRow{"cones", 128, 5, 13},
    SweepRow{"cones", 128, 8, 13},
    SweepRow{"cones", 256, 5},
    SweepRow{"traced", 64, 0, 0, false, kVariant},
    SweepRow{"traced", 128, 0, 4, false, kQuick},
    SweepRow{"traced", 128, 0, 0, false, kVariant},
    SweepRow{"traced", 128, 0, 16, false, kQuick},
    SweepRow{"traced", 256, 0, 0, false, kQuick},
    SweepRow{"traced", 32, 0},
    SweepRow{"traced", 96, 0},
    SweepRow{"traced", 128, 0, 1},
    SweepRow{"traced", 128, 0, 2},
    SweepRow{"traced", 128, 0, 32},
    SweepRow{"traced", 128, 0, 64},
    SweepRow{"traced", 192, 0},
    SweepRow{"hybrid", 64, 4, 0, kWithApertures, kQuick},
    SweepRow{"hybrid", 128, 4, 0, kWithApertures, kVariant},
    SweepRow{"hybrid", 256, 4, 0, kWithApertures, kQuick},
    SweepRow{"hybrid-traced", 64, 0, 0, kWithApertures, kQuick},
    SweepRow{"hybrid-traced", 128, 0, 0, kWithApertures, kVariant},
    SweepRow{"hybrid-traced", 256, 0, 0, kWithApertures},
    SweepRow{"hybrid-cones", 128, 5, 0, kWithApertures},
    SweepRow{"hybrid", 32, 4, 0, kWithApertures},
    SweepRow{"hybrid", 96, 4, 0, kWithApertures},
    SweepRow{"hybrid", 128, 5, 0, kWithApertures},
    SweepRow{"hybrid", 128, 6, 0, kWithApertures},
    SweepRow{"hybrid", 192, 4, 0, kWithApertures},
    SweepRow{"hybrid", 128, 4, 0, kWithApertures, kFull, ApertureMode::smoothstep},
    SweepRow{"hybrid", 128, 4, 0, kWithApertures, kFull, ApertureMode::fast},
};

/// The others; kTechniques has those without a volume.
struct OtherRow {
  Technique technique;
  int resolution = 0;  ///< 0: reads no volume
  SweepSize least = SweepSize::full;
};
constexpr std::array kOthers{
    OtherRow{Technique::constant, 0, kQuick},      OtherRow{Technique::gtao, 0, kQuick},  OtherRow{Technique::coneTracing, 64},
    OtherRow{Technique::coneTracing, 128, kQuick}, OtherRow{Technique::coneTracing, 256}, OtherRow{Technique::rays16, 64, kQuick},
    OtherRow{Technique::rays16, 128, kQuick},      OtherRow{Technique::rays16, 256},      OtherRow{Technique::rays64, 64},
    OtherRow{Technique::rays64, 128, kVariant},    OtherRow{Technique::rays64, 256},      OtherRow{Technique::surfels, 0, kQuick},
};

std::string nameOf(const SweepSetting& setting) {
  if (setting.technique != Technique::overcast)
    return setting.resolution > 0 ? fmt::format("{}, {}^3", overcast::nameOf(setting.technique), setting.resolution)
                                  : overcast::nameOf(setting.technique);
  std::string name = setting.estimator;
  const bool taps = readsTaps(setting.estimator);
  if (setting.cones > 0) name += fmt::format(", {} {}", setting.cones, taps ? "cones" : "rays");
  if (taps) name += fmt::format(", {} taps", setting.taps);  // which steps where the field lets it
  name += fmt::format(", {}^3", setting.resolution);
  if (setting.apertures)
    name += setting.apertureMode == kBest ? ", apertures" : fmt::format(", apertures {}", nameOf(setting.apertureMode));
  return name;
}

/// What lights the scene while nobody asks for anything else.
SweepSetting ownSetting(const Lighting& own, bool apertures) {
  const std::string name(usedEstimator(own.estimator.name, apertures));
  const Estimator estimator = withName(own.estimator, name);
  const int usual = ownDirections(name), directions = estimator.cones && usual > 0 ? estimator.cones->directions : usual;
  return {.estimator = name,
          .taps = readsTaps(name) ? estimator.taps : 0,
          .cones = directions == usual ? 0 : directions,
          .resolution = own.globalVolume.resolution,
          .apertures = apertures,
          .storable = true};
}

void add(std::vector<SweepSetting>& settings, SweepSetting setting) {
  setting.name = nameOf(setting);
  const auto same = [&](const SweepSetting& other) { return other.name == setting.name; };
  if (std::none_of(settings.begin(), settings.end(), same)) settings.push_back(std::move(setting));
}

}  // namespace

const char* nameOf(ApertureMode mode) {
  switch (mode) {
    case ApertureMode::exact:
      return "exact";
    case ApertureMode::smoothstep:
      return "smoothstep";
    case ApertureMode::fast:
      return "fast";
    case ApertureMode::accurate:
      break;
  }
  return "accurate";
}

std::vector<SweepSetting> sweepSettings(const Lighting& own, bool apertures, SweepSize size) {
  std::vector<SweepSetting> settings;
  add(settings, ownSetting(own, apertures));
  for (const SweepRow& row : kSweep) {
    if ((row.apertures && !apertures) || row.least > size) continue;
    add(settings, {.estimator = row.estimator,
                   .taps = row.taps,
                   .cones = row.cones,
                   .resolution = row.resolution,
                   .apertures = row.apertures,
                   .apertureMode = row.apertureMode,
                   .storable = row.apertures == apertures && row.apertureMode == kBest});
  }
  for (const OtherRow& row : kOthers)
    if (row.least <= size) add(settings, {.technique = row.technique, .resolution = row.resolution});
  return settings;
}

std::string leftOutOf(SweepSize size) {
  if (size == SweepSize::full) return "";
  std::vector<SweepSetting> all = sweepSettings({}, true, SweepSize::full), taken = sweepSettings({}, true, size);
  return fmt::format(
      "{} of {} settings: volumes of 32, 96 and 192 voxels, most numbers of taps and cones, aperture modes other than "
      "accurate, other techniques at resolutions other than 128",
      all.size() - taken.size(), all.size());
}

Lighting lightingWith(const Lighting& own, const SweepSetting& setting) {
  Lighting lighting = own;
  if (setting.technique != Technique::overcast) return lighting;
  lighting.globalVolume.resolution = setting.resolution;
  lighting.estimator = withName(std::move(lighting.estimator), setting.estimator);
  if (setting.taps > 0) lighting.estimator = withTaps(std::move(lighting.estimator), setting.taps);
  std::optional<SkyCones>& cones = lighting.estimator.cones;
  if (setting.cones > 0 && !cones) cones.emplace();
  const int directions = setting.cones > 0 ? setting.cones : ownDirections(setting.estimator);
  if (cones && directions > 0) cones->directions = directions;
  return lighting;
}

FrameSettings frameSettings(const SweepSetting& setting, int width, int height) {
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  settings.apertureMode = setting.apertureMode;
  settings.prefilter = setting.prefilter;
  settings.technique.technique = setting.technique;
  settings.technique.constant = setting.constant;
  if (setting.resolution > 0) settings.resolution = setting.resolution;
  return settings;
}

SweepSetting raysSetting(int resolution) {
  SweepSetting setting{.technique = Technique::rays64, .resolution = resolution};
  setting.name = nameOf(setting);
  return setting;
}

}  // namespace overcast
