#include "bake/config.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <nlohmann/json.hpp>

#include "bake/inputs.h"
#include "formats/files.h"

namespace overcast {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t kLargestConfig = std::uint64_t{16} << 20;

/// A value that is not what its key takes: the reason.
struct Refusal {
  std::string reason;
};

std::string textIn(const Json& value) {
  if (!value.is_string()) throw Refusal{"is not a string"};
  return value.get<std::string>();
}

double numberIn(const Json& value, double low, double high, bool lowIncluded) {
  if (!value.is_number()) throw Refusal{"is not a number"};
  const auto number = value.get<double>();
  if (number > high || number < low || (number == low && !lowIncluded))
    throw Refusal{lowIncluded ? fmt::format("is {}, allowed are {} to {}", number, low, high)
                              : fmt::format("is {}, not above {}", number, low)};
  return number;
}

std::uint64_t integerIn(const Json& value, std::uint64_t low, std::uint64_t high) {
  if (!value.is_number_integer()) throw Refusal{"is not an integer"};
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() < low || value.get<std::uint64_t>() > high)
    throw Refusal{fmt::format("is {}, allowed are {} to {}", value.dump(), low, high)};
  return value.get<std::uint64_t>();
}

int smallIntegerIn(const Json& value, int low, int high) {
  return static_cast<int>(integerIn(value, static_cast<std::uint64_t>(low), static_cast<std::uint64_t>(high)));
}

std::string representationIn(const Json& value) {
  const std::string text = textIn(value);
  if (text != "auto" && !representationNamed(text)) throw Refusal{fmt::format("'{}' is no representation", text)};
  return text;
}

template <class T>
T namedIn(const std::map<std::string, T>& names, const std::string& text, const char* what) {
  const auto found = names.find(text);
  if (found == names.end()) throw Refusal{fmt::format("'{}' is no {}", text, what)};
  return found->second;
}

VolumeBits bitsIn(const Json& value) {
  return namedIn(volumeBitsNames(), value.is_number_integer() ? value.dump() : textIn(value), "precision");
}

constexpr double kAnyDouble = std::numeric_limits<double>::max();
constexpr std::uint64_t kAnyInteger = std::numeric_limits<std::uint64_t>::max();

/// Every key of settings, and how its value is taken.
const std::map<std::string, std::function<void(const Json&, SettingsLayer&)>>& settingKeys() {
  static const std::map<std::string, std::function<void(const Json&, SettingsLayer&)>> keys = {
      {"preset", [](const Json& value, SettingsLayer& layer) { layer.preset = textIn(value); }},
      {"representation", [](const Json& value, SettingsLayer& layer) { layer.representation = representationIn(value); }},
      {"maxError", [](const Json& value, SettingsLayer& layer) { layer.maxError = numberIn(value, 0.0, kAnyDouble, false); }},
      {"maxSkyError", [](const Json& value, SettingsLayer& layer) { layer.maxSkyError = numberIn(value, 0.0, kAnyDouble, false); }},
      {"maxBytes", [](const Json& value, SettingsLayer& layer) { layer.maxBytes = integerIn(value, 1, kAnyInteger); }},
      {"largest",
       [](const Json& value, SettingsLayer& layer) { layer.largest = smallIntegerIn(value, kMinResolution, kLargestCandidate); }},
      {"resolution",
       [](const Json& value, SettingsLayer& layer) { layer.resolution = smallIntegerIn(value, kMinResolution, kMaxResolution); }},
      {"voxelSize", [](const Json& value, SettingsLayer& layer) { layer.voxelSize = numberIn(value, 0.0, kAnyDouble, false); }},
      {"padding", [](const Json& value, SettingsLayer& layer) { layer.padding = numberIn(value, 0.0, kMaxPadding, true); }},
      {"bits", [](const Json& value, SettingsLayer& layer) { layer.bits = bitsIn(value); }},
      {"sheets",
       [](const Json& value, SettingsLayer& layer) { layer.sheets = namedIn(sheetModeNames(), textIn(value), "way with sheets"); }},
      {"thickness", [](const Json& value, SettingsLayer& layer) { layer.thickness = numberIn(value, 0.0, kAnyDouble, false); }},
      {"errorSamples", [](const Json& value, SettingsLayer& layer) { layer.errorSamples = integerIn(value, 0, kMaxErrorSamples); }},
      {"seed", [](const Json& value, SettingsLayer& layer) { layer.seed = integerIn(value, 0, kAnyInteger); }},
  };
  return keys;
}

std::string joined(const std::string& place, const std::string& key) {
  return place.empty() ? key : place + "/" + key;
}

Error unknownKey(const std::string& place, const std::vector<std::string>& known) {
  std::string list;
  for (const std::string& key : known) list += (list.empty() ? "" : ", ") + key;
  return Error{"", place, fmt::format("is not a key that is known here; these are: {}", list)};
}

/// An Error unless `json` is an object with none but these keys.
Result<Done> checkKeys(const Json& json, const std::string& place, const std::vector<std::string>& known) {
  if (!json.is_object()) return Error{"", place, "is not an object"};
  for (const auto& [key, value] : json.items())
    if (std::find(known.begin(), known.end(), key) == known.end()) return unknownKey(joined(place, key), known);
  return Done{};
}

Result<SettingsLayer> settingsIn(const Json& json, const std::string& place) {
  std::vector<std::string> known;
  for (const auto& [key, take] : settingKeys()) known.push_back(key);
  if (const auto checked = checkKeys(json, place, known); !checked) return checked.error();
  SettingsLayer layer;
  for (const auto& [key, value] : json.items()) {
    try {
      settingKeys().at(key)(value, layer);
    } catch (const Refusal& refusal) {
      return Error{"", joined(place, key), refusal.reason};
    }
  }
  if (std::string wrong = contradiction(layer); !wrong.empty()) return Error{"", place, std::move(wrong)};
  return layer;
}

Result<std::vector<std::string>> patternsIn(const Json& json, const std::string& place) {
  std::vector<std::string> patterns;
  for (const Json& pattern : json.is_array() ? json : Json::array({json})) {
    if (!pattern.is_string() || pattern.get_ref<const std::string&>().empty())
      return Error{"", place, "is not a pattern or an array of patterns"};
    patterns.push_back(pattern.get<std::string>());
  }
  if (patterns.empty()) return Error{"", place, "holds no pattern"};
  return patterns;
}

Result<ConfigRule> ruleIn(const Json& json, const std::string& place) {
  if (const auto checked = checkKeys(json, place, {"files", "settings"}); !checked) return checked.error();
  for (const char* key : {"files", "settings"})
    if (!json.contains(key)) return Error{"", joined(place, key), "is missing"};
  auto patterns = patternsIn(json["files"], place + "/files");
  if (!patterns) return patterns.error();
  auto settings = settingsIn(json["settings"], place + "/settings");
  if (!settings) return settings.error();
  return ConfigRule{std::move(patterns).value(), std::move(settings).value()};
}

Result<Config> configIn(const Json& json) {
  if (const auto checked = checkKeys(json, "", {"$schema", "version", "settings", "rules"}); !checked) return checked.error();
  if (!json.contains("version")) return Error{"", "version", fmt::format("is missing; this program reads version {}", kConfigVersion)};
  const Json& version = json["version"];
  if (!version.is_number_integer() || version < 1) return Error{"", "version", "is not a positive integer"};
  if (version > kConfigVersion)
    return Error{"", "version", fmt::format("is {}, this program reads up to {}", version.dump(), kConfigVersion)};
  Config config;
  if (json.contains("settings")) {
    auto settings = settingsIn(json["settings"], "settings");
    if (!settings) return settings.error();
    config.settings = std::move(settings).value();
  }
  if (!json.contains("rules")) return config;
  if (!json["rules"].is_array()) return Error{"", "rules", "is not an array"};
  for (const Json& entry : json["rules"]) {
    auto rule = ruleIn(entry, fmt::format("rules/{}", config.rules.size()));
    if (!rule) return rule.error();
    config.rules.push_back(std::move(rule).value());
  }
  return config;
}

}  // namespace

Result<Config> parseConfig(std::string_view text) {
  try {
    return configIn(Json::parse(text));
  } catch (const Json::exception& failure) {
    return Error{"", "", fmt::format("is not valid JSON: {}", failure.what())};
  }
}

Result<Config> readConfig(const std::filesystem::path& file) {
  const auto bytes = readFile(file, kLargestConfig);
  if (!bytes) return bytes.error();
  auto config = parseConfig({reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size()});
  if (!config) return Error{file.string(), config.error().place, config.error().reason};
  return config;
}

SettingsLayer settingsFor(const Config& config, std::string_view name) {
  SettingsLayer layer = config.settings;
  for (const ConfigRule& rule : config.rules)
    if (std::any_of(rule.files.begin(), rule.files.end(), [&](const std::string& pattern) { return matchesGlob(pattern, name); }))
      layer = overlaid(layer, rule.settings);
  return layer;
}

}  // namespace overcast
