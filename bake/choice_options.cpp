#include "bake/choice_options.h"

#include <CLI/CLI.hpp>

#include "bake/command.h"

namespace overcast {

void addChoiceOptions(CLI::App& app, ChoiceOptions& options) {
  app.add_option("--representation", options.representation,
                 "auto: whatever is cheapest within the errors allowed [auto]; or only volume, primitive, radius or heightfield")
      ->check(CLI::IsMember({"auto", "volume", "primitive", "radius", "heightfield"}));
  app.add_option("--max-error", options.maxError,
                 fmt::format("error allowed: root mean square near the surface, as a share of the mesh's diagonal [{}]", kDefaultMaxError))
      ->check(positiveNumber);
  app.add_option(
         "--max-sky-error", options.maxSkyError,
         fmt::format("error of the sky light around a mesh allowed: root mean square of its visibility, 0 to 1 [{}]", kDefaultMaxSkyError))
      ->check(positiveNumber);
  app.add_option("--max-bytes", options.maxBytes, "bytes on disk allowed for each mesh; alone: the most accurate within them")
      ->check(CLI::PositiveNumber);
}

ChoiceSettings choiceSettings(const ChoiceOptions& options, const MeasureSettings& measure) {
  ChoiceSettings settings;
  settings.only = representationNamed(options.representation);
  settings.maxError = options.maxError;
  settings.maxSkyError = options.maxSkyError.value_or(kDefaultMaxSkyError);
  settings.maxBytes = options.maxBytes;
  settings.measure = measure;
  return settings;
}

}  // namespace overcast
