// Settings from presets, config files and the command line: who wins, and what is refused.
#include "bake/config.h"

#include <fstream>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using testing::HasSubstr;

Config configOf(const std::string& json) {
  const auto config = parseConfig(json);
  EXPECT_TRUE(config.ok()) << message(config.error());
  return config ? config.value() : Config{};
}

BakeSettings settled(const SettingsLayer& layer) {
  const auto settings = bakeSettings(layer);
  EXPECT_TRUE(settings.ok());
  return settings.value();
}

TEST(Settings, APresetStandsForItsNumbers) {
  for (const Preset& preset : presets()) {
    SettingsLayer layer;
    layer.preset = preset.name;
    const BakeSettings settings = settled(layer);
    ASSERT_TRUE(settings.choice);
    EXPECT_EQ(settings.choice->maxError, preset.maxError);
    EXPECT_EQ(settings.choice->maxSkyError, preset.maxSkyError);
    EXPECT_EQ(settings.choice->largest, preset.largest);
    EXPECT_EQ(settings.choice->measure.samples, preset.errorSamples);
    EXPECT_THAT(presetHelp(), HasSubstr(fmt::format("{}: error at most {:g} %", preset.name, 100.0 * preset.maxError)));
  }
  EXPECT_EQ(presets().size(), 3u);
}

TEST(Settings, WhatIsSaidBesideAPresetWins) {
  SettingsLayer layer;
  layer.preset = "film";
  layer.maxError = 0.5;
  layer.errorSamples = 7;
  const BakeSettings settings = settled(layer);
  EXPECT_EQ(settings.choice->maxError, 0.5);
  EXPECT_EQ(settings.choice->measure.samples, 7u);
  EXPECT_EQ(settings.choice->largest, 256);
  layer.maxError.reset();
  layer.resolution = 20;
  EXPECT_FALSE(settled(layer).choice);
  EXPECT_EQ(settled(layer).volume.resolution, 20);
}

TEST(Settings, LaterLayersWinWhateverTheySpeakOf) {
  SettingsLayer low, high;
  low.preset = "film";
  low.padding = 5.0;
  high.resolution = 24;
  BakeSettings settings = settled(overlaid(low, high));
  EXPECT_FALSE(settings.choice) << "a size leaves nothing to choose";
  EXPECT_EQ(settings.volume.padding, 5.0);
  EXPECT_EQ(settings.volume.errorSamples, 16384u);
  settings = settled(overlaid(high, low));
  EXPECT_TRUE(settings.choice) << "a choice drops the size below it";
  EXPECT_EQ(settings.volume.resolution, VolumeSettings{}.resolution);
  high = {};
  high.preset = "preview";
  settings = settled(overlaid(low, high));
  EXPECT_EQ(settings.choice->maxError, 0.03);
  EXPECT_EQ(settings.choice->measure.samples, 1024u);
  low = {};
  low.voxelSize = 0.1;
  high = {};
  high.resolution = 9;
  EXPECT_EQ(settled(overlaid(low, high)).volume.voxelSize, 0.0);
  EXPECT_EQ(settled(overlaid(high, low)).volume.voxelSize, 0.1);
}

TEST(Settings, ContradictionsAreNamed) {
  SettingsLayer layer;
  layer.resolution = 16;
  EXPECT_EQ(contradiction(layer), "");
  layer.representation = "volume";
  EXPECT_EQ(contradiction(layer), "");
  layer.maxError = 0.1;
  EXPECT_THAT(contradiction(layer), HasSubstr("nothing to choose"));
  layer.maxError.reset();
  layer.voxelSize = 0.1;
  EXPECT_THAT(contradiction(layer), HasSubstr("exclude"));
  layer = {};
  layer.preset = "cinema";
  EXPECT_THAT(contradiction(layer), HasSubstr("'cinema' is no preset; there are preview, game, film"));
  layer = {};
  layer.maxError = 0.1;
  layer.errorSamples = 0;
  EXPECT_FALSE(bakeSettings(layer).ok());
}

TEST(Configs, TheLastRuleThatMatchesWins) {
  const Config config = configOf(R"({"version": 1, "settings": {"preset": "game", "seed": 3},
    "rules": [{"files": "*.off", "settings": {"maxError": 0.5, "padding": 1}},
              {"files": ["props/**", "x.obj"], "settings": {"maxError": 0.25}},
              {"files": "fixed*", "settings": {"resolution": 12}}]})");
  EXPECT_EQ(settled(settingsFor(config, "y.obj")).choice->maxError, 0.01);
  EXPECT_EQ(settled(settingsFor(config, "a.off")).choice->maxError, 0.5);
  EXPECT_EQ(settled(settingsFor(config, "props/a.off")).choice->maxError, 0.25);
  EXPECT_EQ(settled(settingsFor(config, "props/a.off")).volume.padding, 1.0);
  EXPECT_EQ(settled(settingsFor(config, "sub/x.obj")).choice->maxError, 0.25);
  EXPECT_FALSE(settled(settingsFor(config, "fixed.off")).choice);
  for (const char* name : {"y.obj", "fixed.off"}) EXPECT_EQ(settled(settingsFor(config, name)).volume.seed, 3u);
}

TEST(Configs, TakeEverySetting) {
  const Config config =
      configOf(R"({"$schema": "x", "version": 1, "settings": {"representation": "volume", "resolution": 64, "padding": 3.5,
    "bits": 16, "errorSamples": 10, "seed": 18446744073709551615}})");
  const BakeSettings settings = settled(config.settings);
  EXPECT_EQ(settings.volume.resolution, 64);
  EXPECT_EQ(settings.volume.padding, 3.5);
  EXPECT_EQ(settings.volume.bits, VolumeBits::half);
  EXPECT_EQ(settings.volume.errorSamples, 10u);
  EXPECT_EQ(settings.volume.seed, ~std::uint64_t{0});
  const BakeSettings chosen = settled(
      configOf(R"({"version":1,"settings":{"representation":"radius","maxError":0.125,"maxSkyError":0.5,"maxBytes":9000,"largest":64}})")
          .settings);
  EXPECT_EQ(chosen.choice->only, Representation::radius);
  EXPECT_EQ(chosen.choice->maxError, 0.125);
  EXPECT_EQ(chosen.choice->maxSkyError, 0.5);
  EXPECT_EQ(chosen.choice->maxBytes, 9000u);
  EXPECT_EQ(chosen.choice->largest, 64);
}

TEST(Configs, MistakesAreNamedWithTheirKey) {
  struct Case {
    const char* json;
    const char* place;
    const char* reason;
  };
  for (const Case& c : std::initializer_list<Case>{
           {"", "", "is not valid JSON"},
           {"[]", "", "is not an object"},
           {"{}", "version", "is missing"},
           {R"({"version": 2})", "version", "is 2, this program reads up to 1"},
           {R"({"version": 0})", "version", "is not a positive integer"},
           {R"({"version": "1"})", "version", "is not a positive integer"},
           {R"({"version": 1.0})", "version", "is not a positive integer"},
           {R"({"version": 1, "setings": {}})", "setings", "is not a key that is known here; these are: $schema, version, settings, rules"},
           {R"({"version": 1, "settings": {"maxEror": 1}})", "settings/maxEror", "is not a key"},
           {R"({"version": 1, "settings": {"maxError": "1"}})", "settings/maxError", "is not a number"},
           {R"({"version": 1, "settings": {"maxError": 0}})", "settings/maxError", "is 0, not above 0"},
           {R"({"version": 1, "settings": {"maxError": 1e999}})", "", "is not valid JSON"},
           {R"({"version": 1, "settings": {"resolution": 7}})", "settings/resolution", "is 7, allowed are 8 to 512"},
           {R"({"version": 1, "settings": {"resolution": 8.5}})", "settings/resolution", "is not an integer"},
           {R"({"version": 1, "settings": {"seed": -1}})", "settings/seed", "is -1, allowed are 0 to"},
           {R"({"version": 1, "settings": {"padding": 256}})", "settings/padding", "allowed are 0 to 255"},
           {R"({"version": 1, "settings": {"bits": 12}})", "settings/bits", "'12' is no precision"},
           {R"({"version": 1, "settings": {"preset": "x"}})", "settings", "'x' is no preset"},
           {R"({"version": 1, "settings": {"representation": "ball"}})", "settings/representation", "'ball' is no representation"},
           {R"({"version": 1, "settings": {"resolution": 8, "maxError": 1}})", "settings", "nothing to choose"},
           {R"({"version": 1, "rules": {}})", "rules", "is not an array"},
           {R"({"version": 1, "rules": [{"settings": {}}]})", "rules/0/files", "is missing"},
           {R"({"version": 1, "rules": [{"files": "a"}]})", "rules/0/settings", "is missing"},
           {R"({"version": 1, "rules": [{"files": [], "settings": {}}]})", "rules/0/files", "holds no pattern"},
           {R"({"version": 1, "rules": [{"files": 3, "settings": {}}]})", "rules/0/files", "is not a pattern"},
           {R"({"version": 1, "rules": [{"files": "a", "settings": {}}, {"files": "a", "settings": {"x": 1}}]})", "rules/1/settings/x",
            "is not a key"},
       }) {
    const auto config = parseConfig(c.json);
    ASSERT_FALSE(config.ok()) << c.json;
    EXPECT_EQ(config.error().place, c.place) << c.json;
    EXPECT_THAT(config.error().reason, HasSubstr(c.reason)) << c.json;
    EXPECT_EQ(message(config.error()).find('\n'), std::string::npos);
  }
}

TEST(Configs, FilesAreNamed) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path / "config.json") << R"({"version": 1, "settings": {"x": 1}})";
  EXPECT_THAT(message(readConfig(folder.path / "config.json").error()), HasSubstr("config.json: settings/x: is not a key"));
  EXPECT_THAT(message(readConfig(folder.path / "missing.json").error()), HasSubstr("missing.json"));
}

// The schema and the reader know the same keys, and the schema's bounds are the reader's.
TEST(Configs, HoldToTheSchema) {
  std::ifstream stream(std::string(OVERCAST_SOURCE_FOLDER) + "/formats/schema/overcast-bake.schema.json");
  const auto schema = nlohmann::json::parse(stream);
  EXPECT_EQ(schema["properties"]["version"]["maximum"], kConfigVersion);
  const auto& keys = schema["$defs"]["settings"]["properties"];
  const auto with = [](const std::string& key, const nlohmann::json& value) {
    return parseConfig(nlohmann::json({{"version", 1}, {"settings", {{key, value}}}}).dump());
  };
  std::set<std::string> named;
  for (const auto& [key, type] : keys.items()) {
    named.insert(key);
    if (type.contains("enum")) {
      for (const auto& value : type["enum"]) EXPECT_TRUE(with(key, value).ok()) << key << " " << value;
    }
    for (const char* bound : {"minimum", "maximum"}) {
      if (!type.contains(bound)) continue;
      EXPECT_TRUE(with(key, type[bound]).ok()) << key << " " << bound;
      EXPECT_FALSE(with(key, type[bound].get<int>() + (bound[1] == 'i' ? -1 : 1)).ok()) << key << " beyond " << bound;
    }
    if (type.contains("exclusiveMinimum")) {
      EXPECT_FALSE(with(key, type["exclusiveMinimum"]).ok()) << key;
    }
  }
  const std::string known = with("unknown", 1).error().reason;
  for (const std::string& key : named) EXPECT_THAT(known, HasSubstr(key));
  EXPECT_EQ(static_cast<std::size_t>(std::count(known.begin(), known.end(), ',')) + 1, named.size());
}

}  // namespace
}  // namespace overcast
