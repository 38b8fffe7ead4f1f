// What the readers of height files hand to readTerrain. Internal to formats; everything here runs inside the sandbox.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string_view>

#include "formats/result.h"
#include "formats/terrain.h"

namespace overcast {

inline constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();

/// `value` as a height; kNoHeight where it is no number or beyond kHighestTerrain.
float asHeight(double value);

/// Whether a grid of so many samples is read at all.
Result<Done> checkTerrainSize(std::int64_t columns, std::int64_t rows);

/// Metres on the ground of one degree of longitude (x) and of latitude (y), at a latitude in degrees.
glm::dvec2 metresPerDegree(double latitude);

// One reader for each format. Error::place says where; Error::file is filled in by the caller.
/// Heights are 0 to 1; readTerrain scales them.
Result<Terrain> parseTerrainPng(std::span<const std::byte> bytes);
Result<Terrain> parseTerrainExr(std::span<const std::byte> bytes);
Result<Terrain> parseTerrainEsri(std::string_view text);
Result<Terrain> parseTerrainUsgs(std::string_view text);

/// Whether the text starts like the header of an ESRI grid.
bool isEsriText(std::string_view text);

}  // namespace overcast
