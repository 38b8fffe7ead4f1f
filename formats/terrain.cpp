#include "formats/terrain.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "formats/archive.h"
#include "formats/files.h"
#include "formats/image_parse.h"
#include "formats/sandbox.h"
#include "formats/terrain_parse.h"

namespace overcast {

template <class Archive>
void fields(Archive& archive, Terrain& terrain) {
  archive(terrain.columns, terrain.rows, terrain.spacing, terrain.origin, terrain.heights, terrain.notes);
}

namespace {

namespace fs = std::filesystem;

constexpr double kFlattest = 0.01;  ///< of the longer side: heights below this and above kSteepest are mentioned
constexpr double kSteepest = 1.0;
constexpr double kAssumedRelief = 0.2;  ///< of the longer side: how high the white of a PNG is taken to be

enum class Format { png, exr, esri, usgs };

bool startsWith(std::span<const std::byte> bytes, std::initializer_list<unsigned> magic) {
  return bytes.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), bytes.begin(), [](unsigned m, std::byte b) { return std::to_integer<unsigned>(b) == m; });
}

Format formatOf(std::span<const std::byte> bytes, std::string_view text) {
  if (startsWith(bytes, {0x89, 'P', 'N', 'G'})) return Format::png;
  if (startsWith(bytes, {0x76, 0x2f, 0x31, 0x01})) return Format::exr;
  return isEsriText(text) ? Format::esri : Format::usgs;
}

/// Says so when values taken as metres make a plate or a needle: most such pictures hold something else.
void noteUnlikely(Terrain& terrain, double longer) {
  float low = kHighestTerrain, high = -kHighestTerrain;
  for (const float height : terrain.heights) {
    if (std::isnan(height)) continue;
    low = std::min(low, height);
    high = std::max(high, height);
  }
  const double relief = double{high} - double{low};
  if (relief > 0.0 && (relief < kFlattest * longer || relief > kSteepest * longer))
    terrain.notes.push_back(
        fmt::format("its values taken as metres make it {:.3g} m high over {:g} m: --terrain-spacing or --terrain-height may be missing",
                    relief, longer));
}

/// Gives the values of a picture their size in the world.
void placePicture(Terrain& terrain, bool png, const TerrainOptions& options) {
  const double longer = (std::max(terrain.columns, terrain.rows) - 1) * terrain.spacing.x;
  if (!options.spacing)
    terrain.notes.push_back(fmt::format(
        "does not say how far its samples lie apart: 1 m assumed, {:g} m along its longer side (--terrain-spacing sets it)", longer));
  if (!png && !options.height) {
    noteUnlikely(terrain, longer);
    return;
  }
  const glm::dvec2 range = options.height.value_or(glm::dvec2(0.0, kAssumedRelief * longer));
  if (!options.height)
    terrain.notes.push_back(
        fmt::format("does not say how high it is: 0 to {:g} m assumed, a fifth of its longer side (--terrain-height sets it)", range.y));
  for (float& height : terrain.heights) height = asHeight(range.x + (range.y - range.x) * double{height});
}

}  // namespace

std::string settingsText(const TerrainOptions& options) {
  const glm::dvec2 height = options.height.value_or(glm::dvec2(0.0));
  return fmt::format("terrain {:a} {} {:a} {:a}", options.spacing.value_or(0.0), options.height.has_value(), height.x, height.y);
}

float asHeight(double value) {
  return std::abs(value) <= double{kHighestTerrain} ? static_cast<float>(value) : kNoHeight;
}

Result<Done> checkTerrainSize(std::int64_t columns, std::int64_t rows) {
  if (columns < kLeastTerrainSide || rows < kLeastTerrainSide)
    return Error{"", "", fmt::format("has {} x {} heights, fewer than {} along a side", columns, rows, kLeastTerrainSide)};
  const auto most = static_cast<std::int64_t>(kMostTerrainSamples);
  if (columns > most / rows) return Error{"", "", fmt::format("has {} x {} heights, more than {}", columns, rows, most)};
  return Done{};
}

glm::dvec2 metresPerDegree(double latitude) {
  const double phi = latitude * std::numbers::pi / 180.0;
  // Series of the lengths of a degree on WGS 84; within a centimetre.
  return {111412.84 * std::cos(phi) - 93.5 * std::cos(3.0 * phi) + 0.118 * std::cos(5.0 * phi),
          111132.92 - 559.82 * std::cos(2.0 * phi) + 1.175 * std::cos(4.0 * phi) - 0.0023 * std::cos(6.0 * phi)};
}

bool isWhole(const Terrain& terrain) {
  if (!checkTerrainSize(terrain.columns, terrain.rows).ok()) return false;
  const auto samples = static_cast<std::size_t>(terrain.columns) * static_cast<std::size_t>(terrain.rows);
  const auto isLength = [](double d) { return d > 0.0 && std::isfinite(d); };
  return terrain.heights.size() == samples && isLength(terrain.spacing.x) && isLength(terrain.spacing.y) &&
         std::isfinite(terrain.origin.x) && std::isfinite(terrain.origin.y) &&
         std::all_of(terrain.heights.begin(), terrain.heights.end(),
                     [](float h) { return std::isnan(h) || std::abs(h) <= kHighestTerrain; }) &&
         !std::all_of(terrain.heights.begin(), terrain.heights.end(), [](float h) { return std::isnan(h); });
}

bool isTerrainFile(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension == ".png" || extension == ".exr" || extension == ".asc" || extension == ".dem";
}

Result<Terrain> parseTerrain(std::span<const std::byte> bytes, const std::string& file, const TerrainOptions& options) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const Format format = formatOf(bytes, text);
  auto read = format == Format::png    ? parseTerrainPng(bytes)
              : format == Format::exr  ? parseTerrainExr(bytes)
              : format == Format::esri ? parseTerrainEsri(text)
                                       : parseTerrainUsgs(text);
  if (!read) return Error{file, read.error().place, read.error().reason};
  Terrain terrain = std::move(read).value();
  if (options.spacing) {
    terrain.spacing = glm::dvec2(*options.spacing);
    terrain.notes.clear();
  }
  if (format == Format::png || format == Format::exr) placePicture(terrain, format == Format::png, options);
  if (std::all_of(terrain.heights.begin(), terrain.heights.end(), [](float h) { return std::isnan(h); }))
    return Error{file, "", "holds no height, only marks of missing ones"};
  if (!isWhole(terrain)) return Error{file, "", "has a spacing or an origin that is not finite"};
  return terrain;
}

Result<Terrain> readTerrain(const fs::path& path, const TerrainOptions& options) {
  const auto result = runSandboxed(path, {}, [&]() -> Result<std::vector<std::byte>> {
    const auto bytes = readFile(path, kMaxImageFileBytes);
    if (!bytes) return bytes.error();
    auto terrain = parseTerrain(bytes.value(), path.string(), options);
    if (!terrain) return terrain.error();
    return archived(terrain.value());
  });
  if (!result) return result.error();
  auto terrain = unarchived<Terrain>(result.value());
  if (!terrain || !isWhole(*terrain)) return Error{path.string(), "", "its reader returned something that is no terrain"};
  return *std::move(terrain);
}

}  // namespace overcast
