#include "runtime/report/sweep.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "runtime/passes/shade/sky_estimator.h"

namespace overcast {
namespace {

/// Resolutions, taps and aperture modes of an estimator in a report. A row here is all that another takes.
struct SweepRow {
  const char* estimator;
  int resolution;
  int taps;
  bool apertures;  ///< needs them; the others are for scenes with and without
  ApertureMode apertureMode;
  bool quick;  ///< also in a quick report
};

constexpr ApertureMode kBest = ApertureMode::accurate;
constexpr std::array kSweep{
    SweepRow{"published", 128, 4, false, kBest, true},
    SweepRow{"published", 128, 5, false, kBest, false},
    SweepRow{"published", 128, 6, false, kBest, false},
    SweepRow{"published", 32, 5, false, kBest, false},
    SweepRow{"published", 64, 5, false, kBest, false},
    SweepRow{"published", 256, 5, false, kBest, false},
    SweepRow{"calibrated", 128, 4, false, kBest, true},
    SweepRow{"calibrated", 128, 5, false, kBest, false},
    SweepRow{"calibrated", 128, 6, false, kBest, false},
    SweepRow{"calibrated", 32, 4, false, kBest, false},
    SweepRow{"calibrated", 64, 4, false, kBest, false},
    SweepRow{"calibrated", 256, 4, false, kBest, false},
    SweepRow{"cones", 64, 5, false, kBest, true},
    SweepRow{"cones", 128, 5, false, kBest, false},
    SweepRow{"traced", 128, 1, false, kBest, true},
    SweepRow{"hybrid", 64, 4, true, kBest, true},
    SweepRow{"hybrid", 128, 4, true, kBest, true},
    SweepRow{"hybrid", 128, 4, true, ApertureMode::smoothstep, false},
    SweepRow{"hybrid", 128, 4, true, ApertureMode::fast, false},
};

constexpr int kResolution = 128;  // of techniques that read the volume and are not ours

std::string nameOf(const SweepSetting& setting) {
  if (setting.technique != Technique::overcast)
    return setting.resolution > 0 ? fmt::format("{}, {}^3", overcast::nameOf(setting.technique), setting.resolution)
                                  : overcast::nameOf(setting.technique);
  std::string name = setting.estimator == "traced"  // which steps where the field lets it
                         ? fmt::format("traced, {}^3", setting.resolution)
                         : fmt::format("{}, {} taps, {}^3", setting.estimator, setting.taps, setting.resolution);
  if (setting.apertures)
    name += setting.apertureMode == kBest ? ", apertures" : fmt::format(", apertures {}", nameOf(setting.apertureMode));
  return name;
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

std::vector<SweepSetting> sweepSettings(const Lighting& own, bool apertures, bool quick) {
  std::vector<SweepSetting> settings;
  const Estimator& estimator = own.estimator;
  add(settings, {.estimator = estimator.name,
                 .taps = estimator.taps,
                 .resolution = own.globalVolume.resolution,
                 .apertures = apertures,
                 .storable = true});
  for (const SweepRow& row : kSweep) {
    if ((row.apertures && !apertures) || (quick && !row.quick)) continue;
    add(settings, {.estimator = row.estimator,
                   .taps = row.taps,
                   .resolution = row.resolution,
                   .apertures = row.apertures,
                   .apertureMode = row.apertureMode,
                   .storable = row.apertures == apertures && row.apertureMode == kBest});
  }
  for (const NamedTechnique& named : kTechniques)
    if (named.technique != Technique::overcast)
      add(settings, {.technique = named.technique, .resolution = readsVolume(named.technique) ? kResolution : 0});
  return settings;
}

Lighting lightingWith(const Lighting& own, const SweepSetting& setting) {
  Lighting lighting = own;
  if (setting.technique != Technique::overcast) return lighting;
  lighting.globalVolume.resolution = setting.resolution;
  if (lighting.estimator.name != setting.estimator) {
    lighting.estimator = Estimator{};
    lighting.estimator.name = setting.estimator;
  }
  lighting.estimator = withTaps(std::move(lighting.estimator), setting.taps);
  return lighting;
}

FrameSettings frameSettings(const SweepSetting& setting, int width, int height) {
  FrameSettings settings;
  settings.width = width;
  settings.height = height;
  settings.apertureMode = setting.apertureMode;
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
