// Terrain options: --terrain-spacing and --terrain-height.
#pragma once

#include "formats/terrain.h"

namespace CLI {
class App;
}

namespace overcast {

/// Adds the options to `app`.
void addTerrainOptions(CLI::App& app, TerrainOptions& options);

}  // namespace overcast
