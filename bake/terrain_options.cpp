#include "bake/terrain_options.h"

#include <CLI/CLI.hpp>

#include "bake/command.h"

namespace overcast {
namespace {

/// "0:420" as two numbers, the second above the first.
std::optional<glm::dvec2> rangeIn(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return std::nullopt;
  glm::dvec2 range(0.0);
  if (!CLI::detail::lexical_cast(text.substr(0, colon), range.x) || !CLI::detail::lexical_cast(text.substr(colon + 1), range.y))
    return std::nullopt;
  if (!(range.x < range.y && std::abs(range.x) <= double{kHighestTerrain} && std::abs(range.y) <= double{kHighestTerrain}))
    return std::nullopt;
  return range;
}

}  // namespace

void addTerrainOptions(CLI::App& app, TerrainOptions& options) {
  app.add_option("--terrain-spacing", options.spacing,
                 "metres between the samples of height files, instead of what they say [PNG and EXR do not say: 1]")
      ->check(positiveNumber);
  app.add_option_function<std::string>(
         "--terrain-height", [&options](const std::string& text) { options.height = rangeIn(text); },
         "metres of black and white (0 and 1) of pictures with heights [PNG: from 0 to a fifth of the longer side; EXR: metres as they "
         "are]")
      ->check([](const std::string& text) {
        return rangeIn(text) ? std::string() : fmt::format("'{}' is not MIN:MAX in metres, MIN below MAX", text);
      })
      ->type_name("MIN:MAX");
}

}  // namespace overcast
