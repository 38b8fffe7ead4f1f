#include "bake/settings_layer.h"

#include <algorithm>
#include <array>

namespace overcast {
namespace {

constexpr std::array kPresets = {
    Preset{"preview", "a look while modelling", 0.03, 0.08, 32, 1024},
    Preset{"game", "assets that are shipped", 0.01, kDefaultMaxSkyError, 128, 4096},
    Preset{"film", "as good as it gets", 0.002, 0.02, 256, 16384},
};

const Preset* presetNamed(const std::string& name) {
  const auto found = std::find_if(kPresets.begin(), kPresets.end(), [&](const Preset& preset) { return preset.name == name; });
  return found == kPresets.end() ? nullptr : &*found;
}

bool saysSize(const SettingsLayer& layer) {
  return layer.resolution || layer.voxelSize || layer.bits;
}

/// Beside the representation "volume", which a size goes with.
bool saysChoice(const SettingsLayer& layer) {
  return layer.maxError || layer.maxSkyError || layer.maxBytes || layer.largest ||
         (layer.representation && *layer.representation != "volume");
}

/// The layer with its preset spelled out.
SettingsLayer expanded(SettingsLayer layer) {
  const Preset* preset = layer.preset ? presetNamed(*layer.preset) : nullptr;
  layer.preset.reset();
  if (preset == nullptr) return layer;
  if (!layer.errorSamples) layer.errorSamples = preset->errorSamples;
  if (saysSize(layer)) return layer;
  if (!layer.maxError && !layer.maxBytes) layer.maxError = preset->maxError;
  if (!layer.maxSkyError) layer.maxSkyError = preset->maxSkyError;
  if (!layer.largest) layer.largest = preset->largest;
  return layer;
}

template <class T>
void putOver(std::optional<T>& base, const std::optional<T>& top) {
  if (top) base = top;
}

}  // namespace

std::span<const Preset> presets() {
  return kPresets;
}

std::string presetHelp() {
  std::string text;
  for (const Preset& preset : kPresets)
    text += fmt::format("{}{}: error at most {:g} % of the diagonal and {:g} of the sky light, sizes up to {}, {} error samples ({})",
                        text.empty() ? "" : "; ", preset.name, 100.0 * preset.maxError, preset.maxSkyError, preset.largest,
                        preset.errorSamples, preset.use);
  return text;
}

const std::map<std::string, VolumeBits>& volumeBitsNames() {
  static const std::map<std::string, VolumeBits> names = {
      {"auto", VolumeBits::automatic}, {"8", VolumeBits::snorm8}, {"16", VolumeBits::half}, {"32", VolumeBits::single}};
  return names;
}

const std::map<std::string, SheetMode>& sheetModeNames() {
  static const std::map<std::string, SheetMode> names = {
      {"auto", SheetMode::automatic}, {"signed", SheetMode::none}, {"two-sided", SheetMode::all}};
  return names;
}

std::string contradiction(const SettingsLayer& layer) {
  if (layer.preset && presetNamed(*layer.preset) == nullptr) {
    std::string known;
    for (const Preset& preset : kPresets) known += fmt::format("{}{}", known.empty() ? "" : ", ", preset.name);
    return fmt::format("'{}' is no preset; there are {}", *layer.preset, known);
  }
  if (layer.resolution && layer.voxelSize) return "resolution and voxel size exclude each other";
  if (saysSize(layer) && saysChoice(layer))
    return "resolution, voxel size and bits ask for a volume of that size: there is nothing to choose";
  return "";
}

SettingsLayer overlaid(const SettingsLayer& base, const SettingsLayer& top) {
  SettingsLayer under = expanded(base);
  const SettingsLayer over = expanded(top);
  if (saysSize(over)) {
    under.representation.reset();
    under.maxError.reset();
    under.maxSkyError.reset();
    under.maxBytes.reset();
    under.largest.reset();
  }
  if (saysChoice(over)) {
    under.resolution.reset();
    under.voxelSize.reset();
    under.bits.reset();
  }
  if (over.voxelSize) under.resolution.reset();
  if (over.resolution) under.voxelSize.reset();
  putOver(under.representation, over.representation);
  putOver(under.maxError, over.maxError);
  putOver(under.maxSkyError, over.maxSkyError);
  putOver(under.maxBytes, over.maxBytes);
  putOver(under.largest, over.largest);
  putOver(under.resolution, over.resolution);
  putOver(under.voxelSize, over.voxelSize);
  putOver(under.padding, over.padding);
  putOver(under.bits, over.bits);
  putOver(under.sheets, over.sheets);
  putOver(under.thickness, over.thickness);
  putOver(under.errorSamples, over.errorSamples);
  putOver(under.seed, over.seed);
  return under;
}

Result<BakeSettings> bakeSettings(const SettingsLayer& asGiven) {
  const SettingsLayer layer = expanded(asGiven);
  BakeSettings settings;
  VolumeSettings& volume = settings.volume;
  volume.resolution = layer.resolution.value_or(volume.resolution);
  volume.voxelSize = layer.voxelSize.value_or(volume.voxelSize);
  volume.padding = layer.padding.value_or(volume.padding);
  volume.bits = layer.bits.value_or(volume.bits);
  volume.sheets.mode = layer.sheets.value_or(volume.sheets.mode);
  volume.sheets.thickness = layer.thickness.value_or(volume.sheets.thickness);
  volume.errorSamples = layer.errorSamples.value_or(volume.errorSamples);
  volume.seed = layer.seed.value_or(volume.seed);
  if (saysSize(layer)) return settings;
  if (volume.errorSamples == 0)
    return Error{"", "", "choosing needs a measured error: the number of error samples must be above 0, or a resolution given"};
  ChoiceSettings& choice = settings.choice.emplace();
  choice.only = representationNamed(layer.representation.value_or("auto"));
  choice.maxError = layer.maxError;
  choice.maxSkyError = layer.maxSkyError.value_or(choice.maxSkyError);
  choice.maxBytes = layer.maxBytes;
  choice.largest = layer.largest.value_or(choice.largest);
  choice.padding = volume.padding;
  choice.sheets = volume.sheets;
  choice.measure = {volume.errorSamples, volume.seed};
  return settings;
}

}  // namespace overcast
