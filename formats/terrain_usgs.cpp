// USGS ASCII DEM ("Standards for Digital Elevation Models, Part 2: Specifications", USGS 1998): a record A and, for every profile from west
// to east, a record B of heights from south to north. Records are made of blocks of 1024 characters; fields have fixed columns.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/mesh_text.h"
#include "formats/terrain_parse.h"

namespace overcast {
namespace {

constexpr std::size_t kBlock = 1024;
constexpr std::size_t kHeaderWidth = 864;     ///< of record A, as far as it is read
constexpr std::size_t kFirstHeight = 144;     ///< where the heights of a record B start in its first block
constexpr std::size_t kFirstHeights = 146;    ///< how many that block holds
constexpr std::size_t kFurtherHeights = 170;  ///< and every further one
constexpr int kVoid = -32767;
constexpr double kMetresPerFoot = 0.3048;  ///< the surveyor's differs by 2 in a million
enum Unit { radians = 0, feet = 1, metres = 2, arcSeconds = 3 };

/// Blocks of 1024 characters each: lines, where there are any, are filled up with blanks.
std::string blocksOf(std::string_view text) {
  const std::size_t end = text.substr(0, kBlock + 2).find_first_of("\r\n");
  if (end == std::string_view::npos) return std::string(text);
  std::string blocks;
  while (!text.empty()) {
    const std::size_t length = std::min(text.find_first_of("\r\n"), text.size());
    blocks.append(text.substr(0, length));
    if (length > 0) blocks.append((kBlock - blocks.size() % kBlock) % kBlock, ' ');
    text.remove_prefix(std::min(length + 1, text.size()));
  }
  return blocks;
}

std::string_view field(std::string_view record, std::size_t first, std::size_t width) {
  std::string_view text = first < record.size() ? record.substr(first, width) : std::string_view();
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

/// A number with an exponent of Fortran (D) or C (E).
std::optional<double> realAt(std::string_view record, std::size_t first, std::size_t width) {
  std::string text(field(record, first, width));
  std::replace(text.begin(), text.end(), 'D', 'E');
  std::replace(text.begin(), text.end(), 'd', 'E');
  const auto value = toDouble(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> integerAt(std::string_view record, std::size_t first, std::size_t width) {
  return toInteger(field(record, first, width));
}

/// What record A says.
struct Header {
  std::int64_t groundUnit = metres;
  double heightUnit = 1.0;     ///< metres
  glm::dvec2 resolution{0.0};  ///< ground units
  double heightStep = 1.0;     ///< height units
  std::int64_t profiles = 0;
};

Result<Header> readHeader(std::string_view text) {
  if (text.size() < kHeaderWidth) return Error{"", "", "is neither an ESRI ASCII grid nor a USGS DEM, or cut short"};
  const auto pattern = integerAt(text, 150, 6), ground = integerAt(text, 528, 6), unit = integerAt(text, 534, 6);
  const auto profiles = integerAt(text, 858, 6);
  if (!pattern || !ground || !unit || !profiles) return Error{"", "", "is neither an ESRI ASCII grid nor a USGS DEM"};
  if (*pattern != 1) return Error{"", "record A", fmt::format("elevation pattern {} is not regular (1)", *pattern)};
  if (*ground < radians || *ground > arcSeconds) return Error{"", "record A", fmt::format("unit {} of the ground is unknown", *ground)};
  if (*unit != feet && *unit != metres)
    return Error{"", "record A", fmt::format("unit {} of the heights is neither feet nor metres", *unit)};
  const auto x = realAt(text, 816, 12), y = realAt(text, 828, 12), z = realAt(text, 840, 12);
  if (!x || !y || !(*x > 0.0) || !(*y > 0.0)) return Error{"", "record A", "the resolution of the ground is no length"};
  if (!z || !(*z > 0.0)) return Error{"", "record A", "the resolution of the heights is no length"};
  return Header{*ground, *unit == feet ? kMetresPerFoot : 1.0, {*x, *y}, *z, *profiles};
}

/// One record B: heights from south to north.
struct Profile {
  double x = 0.0, y = 0.0;  ///< of the southernmost height
  double datum = 0.0;       ///< added to all heights, height units
  std::size_t firstBlock = 0;
  std::size_t count = 0;
};

std::size_t blocksFor(std::size_t heights) {
  return heights <= kFirstHeights ? 1 : 1 + (heights - kFirstHeights + kFurtherHeights - 1) / kFurtherHeights;
}

std::size_t placeOfHeight(const Profile& profile, std::size_t i) {
  if (i < kFirstHeights) return profile.firstBlock * kBlock + kFirstHeight + 6 * i;
  const std::size_t further = i - kFirstHeights;
  return (profile.firstBlock + 1 + further / kFurtherHeights) * kBlock + 6 * (further % kFurtherHeights);
}

Result<std::vector<Profile>> readProfiles(std::string_view text, const Header& header) {
  std::vector<Profile> profiles;
  std::size_t block = 1;
  for (std::int64_t p = 0; p < header.profiles; ++p) {
    const std::string place = fmt::format("profile {}", p + 1);
    const std::size_t start = block * kBlock;
    if (start >= text.size()) return Error{"", place, fmt::format("is missing: the file is cut short (record A says {})", header.profiles)};
    const std::string_view record = text.substr(start, kFirstHeight);
    const auto count = integerAt(record, 12, 6), across = integerAt(record, 18, 6);
    const auto x = realAt(record, 24, 24), y = realAt(record, 48, 24), datum = realAt(record, 72, 24);
    if (!count || !across || !x || !y || !datum) return Error{"", place, "its record has no legible head"};
    if (*count < 1 || *across != 1) return Error{"", place, fmt::format("has {} by {} heights", *count, *across)};
    profiles.push_back({*x, *y, *datum, block, static_cast<std::size_t>(*count)});
    const Profile& added = profiles.back();
    if (added.count > text.size() / 6 || placeOfHeight(added, added.count - 1) >= text.size())
      return Error{"", place, fmt::format("is cut short: the file ends before its {} heights do", *count)};
    block += blocksFor(added.count);
  }
  return profiles;
}

/// The rectangle of samples that holds all profiles.
Result<Terrain> frameOf(const std::vector<Profile>& profiles, const Header& header) {
  double west = profiles[0].x, east = west, south = profiles[0].y, north = south;
  for (const Profile& p : profiles) {
    west = std::min(west, p.x);
    east = std::max(east, p.x);
    south = std::min(south, p.y);
    north = std::max(north, p.y + header.resolution.y * static_cast<double>(p.count - 1));
  }
  const double columns = std::round((east - west) / header.resolution.x) + 1.0;
  const double rows = std::round((north - south) / header.resolution.y) + 1.0;
  if (!(columns < 1e9 && rows < 1e9)) return Error{"", "", "its profiles lie too far apart"};
  if (const auto fits = checkTerrainSize(static_cast<std::int64_t>(columns), static_cast<std::int64_t>(rows)); !fits) return fits.error();
  Terrain terrain;
  terrain.columns = static_cast<int>(columns);
  terrain.rows = static_cast<int>(rows);
  terrain.origin = {west, south};
  terrain.spacing = header.resolution;
  terrain.heights.assign(static_cast<std::size_t>(terrain.columns) * static_cast<std::size_t>(terrain.rows), kNoHeight);
  return terrain;
}

Result<Done> putHeights(std::string_view text, const Header& header, const std::vector<Profile>& profiles, Terrain& terrain) {
  const auto at = [](double offset, double step) { return static_cast<std::size_t>(std::lround(offset / step)); };
  for (std::size_t p = 0; p < profiles.size(); ++p) {
    const Profile& profile = profiles[p];
    const std::size_t column = at(profile.x - terrain.origin.x, header.resolution.x);
    const std::size_t first = at(profile.y - terrain.origin.y, header.resolution.y);
    for (std::size_t i = 0; i < profile.count; ++i) {
      const auto value = integerAt(text, placeOfHeight(profile, i), 6);
      if (!value) return Error{"", fmt::format("profile {}", p + 1), fmt::format("height {} is no whole number", i + 1)};
      if (*value == kVoid) continue;
      const std::size_t row = static_cast<std::size_t>(terrain.rows) - 1 - std::min(first + i, static_cast<std::size_t>(terrain.rows) - 1);
      terrain.heights[row * static_cast<std::size_t>(terrain.columns) + column] =
          asHeight((static_cast<double>(*value) * header.heightStep + profile.datum) * header.heightUnit);
    }
  }
  return Done{};
}

/// Ground units to metres.
void convertGround(const Header& header, Terrain& terrain) {
  if (header.groundUnit == metres) return;
  if (header.groundUnit == feet) {
    terrain.spacing *= kMetresPerFoot;
    return;
  }
  const double degrees = header.groundUnit == arcSeconds ? 1.0 / 3600.0 : 180.0 / std::numbers::pi;
  const double latitude = degrees * (terrain.origin.y + 0.5 * terrain.spacing.y * (terrain.rows - 1));
  terrain.spacing *= degrees * metresPerDegree(latitude);
  terrain.notes.push_back(
      fmt::format("samples at latitude {:.2f} lie {:.2f} by {:.2f} m apart", latitude, terrain.spacing.x, terrain.spacing.y));
}

}  // namespace

Result<Terrain> parseTerrainUsgs(std::string_view text) {
  const std::string blocks = blocksOf(text);
  const auto header = readHeader(blocks);
  if (!header) return header.error();
  const auto profiles = readProfiles(blocks, header.value());
  if (!profiles) return profiles.error();
  if (profiles.value().empty()) return Error{"", "record A", "says there is no profile"};
  auto terrain = frameOf(profiles.value(), header.value());
  if (!terrain) return terrain.error();
  if (const auto put = putHeights(blocks, header.value(), profiles.value(), terrain.value()); !put) return put.error();
  convertGround(header.value(), terrain.value());
  return terrain;
}

}  // namespace overcast
