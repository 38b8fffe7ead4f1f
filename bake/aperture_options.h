// Aperture options: --apertures and what belongs to it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bake/scene_apertures.h"

namespace CLI {
class App;
}

namespace overcast {

/// As given on the command line.
struct ApertureOptions {
  std::string where = "none";  ///< none, vertex or texel
  std::optional<int> rays;     ///< empty: not given, as of those below
  std::optional<int> bytes;
  std::optional<int> vertices;
  std::optional<int> texels;
  std::string occluders;  ///< self or scene
  bool transfer = false;
  bool atlas = false;
};

/// Adds the options to `app`.
void addApertureOptions(CLI::App& app, ApertureOptions& options);

/// What they ask for; nothing when they ask for no apertures. An Error when they ask for details of apertures but for none, or of others.
Result<std::optional<SceneApertureSettings>> apertureSettings(const ApertureOptions& options);

}  // namespace overcast
