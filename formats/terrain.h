// Terrain: a grid of heights, and the reader of 16-bit PNG, OpenEXR, ESRI ASCII grids and USGS ASCII DEMs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "formats/result.h"

namespace overcast {

/// Heights over a regular grid, in metres. Row 0 is the northern one, column 0 the western one.
struct Terrain {
  int columns = 0;
  int rows = 0;
  glm::dvec2 spacing{1.0};         ///< metres between columns and between rows
  glm::dvec2 origin{0.0};          ///< where the file says its south-western sample lies, in the file's units
  std::vector<float> heights;      ///< heights[row * columns + column]; NaN where nothing is known
  std::vector<std::string> notes;  ///< what was assumed, one line each, for the user
};

/// What files do not say, or what is to hold instead of what they say.
struct TerrainOptions {
  std::optional<double> spacing;     ///< metres between samples; else the file's, and 1 where it has none (PNG, EXR)
  std::optional<glm::dvec2> height;  ///< metres of the values 0 and 1 (a PNG's white) of pictures; else 0 to a fifth of the longer side for
                                     ///< PNG, as they are for EXR
};

/// All of the options as text: equal exactly when they are.
std::string settingsText(const TerrainOptions& options);

inline constexpr int kLeastTerrainSide = 2;                                   ///< samples
inline constexpr std::uint64_t kMostTerrainSamples = std::uint64_t{1} << 25;  ///< larger grids are refused before they are allocated
inline constexpr float kHighestTerrain = 1e6f;                                ///< metres; what is higher or lower is no height but a mark

/// Sides and number of samples within the limits, as many heights as they say, each NaN or within kHighestTerrain, spacing above 0 and
/// finite, at least one height known.
bool isWhole(const Terrain& terrain);

/// True when the extension (any case) is .png, .exr, .asc or .dem.
bool isTerrainFile(const std::filesystem::path& path);

/// Reads a height file, told apart by content:
///  - PNG: grey (with or without alpha) of 16 bits; alpha 0 is no data. Gamma and colour profiles are not applied.
///  - OpenEXR: of one channel, or of several the one named height, Y or R; values are metres unless the options say what 0 and 1 stand for.
///    NaN and infinities are no data.
///  - ESRI ASCII grid: ncols, nrows, cellsize or dx and dy, xllcorner or xllcenter, nodata_value (else -9999), in any case of letters.
///    Values are metres. A grid whose corners are degrees (within 180 and 90, cells of at most 0.1) is taken as such.
///  - USGS ASCII DEM, fixed columns with or without line ends: ground in metres, feet, arc seconds or radians, profiles of any length,
///    -32767 is no data.
/// Degrees become metres on the WGS 84 ellipsoid at the grid's middle latitude. In all formats values beyond kHighestTerrain are no data.
/// The parse runs in a sandbox. An Error names the file and the place: unknown content, 8-bit or coloured PNG, EXR without such a channel,
/// missing or impossible header fields, decimal commas, fewer or more values than the header says, more than kMostTerrainSamples, nothing
/// but no data.
Result<Terrain> readTerrain(const std::filesystem::path& path, const TerrainOptions& options = {});

/// What readTerrain does inside the sandbox, for it and its fuzzer.
Result<Terrain> parseTerrain(std::span<const std::byte> bytes, const std::string& file, const TerrainOptions& options);

}  // namespace overcast
