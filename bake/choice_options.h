// Choice options: --representation, --max-error, --max-sky-error and --max-bytes, which several commands take.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bake/choose.h"

namespace CLI {
class App;
}

namespace overcast {

/// As given on the command line.
struct ChoiceOptions {
  std::string representation;  ///< empty: not given
  std::optional<double> maxError;
  std::optional<double> maxSkyError;
  std::optional<std::uint64_t> maxBytes;
};

/// Adds the options to `app`.
void addChoiceOptions(CLI::App& app, ChoiceOptions& options);

ChoiceSettings choiceSettings(const ChoiceOptions& options, const MeasureSettings& measure);

}  // namespace overcast
