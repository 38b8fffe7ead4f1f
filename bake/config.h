// Config: settings of a bake in a JSON file, with rules for some of the inputs. formats/schema/overcast-bake.schema.json describes it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "bake/settings_layer.h"
#include "formats/result.h"

namespace overcast {

inline constexpr int kConfigVersion = 1;

/// Settings for the inputs that one of the patterns matches (bake/inputs.h: matchesGlob).
struct ConfigRule {
  std::vector<std::string> files;
  SettingsLayer settings;
};

struct Config {
  SettingsLayer settings;  ///< for all inputs
  std::vector<ConfigRule> rules;
};

/// An Error whose place is the key at fault ("rules/2/settings/maxError") for text that is not JSON, unknown keys, wrong types, values out
/// of range, settings that contradict each other, and a version that is missing or newer than this program.
Result<Config> parseConfig(std::string_view json);
/// The same of a file; the Error names it.
Result<Config> readConfig(const std::filesystem::path& file);

/// What the config says of an input: its settings, then every rule that matches the name, the last one on top.
SettingsLayer settingsFor(const Config& config, std::string_view name);

}  // namespace overcast
