// ESRI ASCII grids (ArcGIS, "Esri ASCII raster format").
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>

#include "formats/mesh_text.h"
#include "formats/terrain_parse.h"

namespace overcast {
namespace {

constexpr std::array kKeys = {"ncols", "nrows", "cellsize", "dx", "dy", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "nodata_value"};
constexpr double kLargestDegreeCell = 0.1;

std::string lower(std::string_view word) {
  std::string text(word);
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

bool isKey(std::string_view word) {
  return std::find(kKeys.begin(), kKeys.end(), lower(word)) != kKeys.end();
}

Result<double> numberIn(const TextScanner& scanner, std::string_view word) {
  const auto number = toDouble(word);
  if (number) return *number;
  if (word.find(',') != std::string_view::npos)
    return Error{"", placeOf(scanner), fmt::format("'{}': numbers have a decimal point, not a comma", shown(word))};
  return Error{"", placeOf(scanner), word.empty() ? "the file is cut short" : fmt::format("'{}' is no number", shown(word))};
}

/// The fields of the header; the scanner is left before the first height.
Result<std::map<std::string, double>> readHeader(TextScanner& scanner) {
  std::map<std::string, double> fields;
  for (;;) {
    TextScanner ahead = scanner;
    const std::string key = lower(nextWord(ahead));
    if (key.empty() || toDouble(key) || !(std::isalpha(static_cast<unsigned char>(key[0])))) return fields;
    if (!isKey(key)) return Error{"", placeOf(ahead), fmt::format("'{}' is no field of the header", shown(key))};
    const auto value = numberIn(ahead, nextWordOnLine(ahead));
    if (!value) return value.error();
    if (!fields.emplace(key, value.value()).second) return Error{"", placeOf(ahead), fmt::format("{} stands twice", key)};
    scanner = ahead;
  }
}

Result<int> countIn(const std::map<std::string, double>& fields, const char* key) {
  const auto found = fields.find(key);
  if (found == fields.end()) return Error{"", key, "is missing"};
  const double value = found->second;
  if (!(value >= 1.0 && value <= 1e9) || value != std::floor(value))
    return Error{"", key, fmt::format("{} is no number of samples", value)};
  return static_cast<int>(value);
}

Result<double> cellIn(const std::map<std::string, double>& fields, const char* key) {
  auto found = fields.find("cellsize");
  if (found == fields.end()) found = fields.find(key);
  if (found == fields.end()) return Error{"", "cellsize", fmt::format("is missing, and so is {}", key)};
  if (!(found->second > 0.0) || !std::isfinite(found->second))
    return Error{"", found->first, fmt::format("{} is no length", found->second)};
  return found->second;
}

/// Where the middle of the lower left cell lies.
double originIn(const std::map<std::string, double>& fields, char axis, double cell) {
  const auto corner = fields.find(fmt::format("{}llcorner", axis));
  if (corner != fields.end()) return corner->second + 0.5 * cell;
  const auto middle = fields.find(fmt::format("{}llcenter", axis));
  return middle != fields.end() ? middle->second : 0.0;
}

/// Takes cells in degrees for what they are.
void convertDegrees(Terrain& terrain, bool placed) {
  const glm::dvec2 last = terrain.origin + terrain.spacing * glm::dvec2(terrain.columns - 1, terrain.rows - 1);
  const bool degrees = placed && std::max(terrain.spacing.x, terrain.spacing.y) <= kLargestDegreeCell && terrain.origin.x >= -180.0 &&
                       last.x <= 360.0 && terrain.origin.y >= -90.0 && last.y <= 90.0;
  if (!degrees) return;
  const double latitude = 0.5 * (terrain.origin.y + last.y);
  terrain.spacing *= metresPerDegree(latitude);
  terrain.notes.push_back(fmt::format("cells taken as degrees at latitude {:.2f}: {:.2f} by {:.2f} m (--terrain-spacing sets another size)",
                                      latitude, terrain.spacing.x, terrain.spacing.y));
}

}  // namespace

bool isEsriText(std::string_view text) {
  TextScanner scanner{text};
  return isKey(nextWord(scanner));
}

Result<Terrain> parseTerrainEsri(std::string_view text) {
  TextScanner scanner{text};
  const auto header = readHeader(scanner);
  if (!header) return header.error();
  const std::map<std::string, double>& fields = header.value();
  const auto columns = countIn(fields, "ncols"), rows = countIn(fields, "nrows");
  for (const auto* count : {&columns, &rows})
    if (!*count) return count->error();
  if (const auto fits = checkTerrainSize(columns.value(), rows.value()); !fits) return fits.error();
  const auto dx = cellIn(fields, "dx"), dy = cellIn(fields, "dy");
  for (const auto* cell : {&dx, &dy})
    if (!*cell) return cell->error();
  Terrain terrain;
  terrain.columns = columns.value();
  terrain.rows = rows.value();
  terrain.spacing = {dx.value(), dy.value()};
  terrain.origin = {originIn(fields, 'x', dx.value()), originIn(fields, 'y', dy.value())};
  const auto mark = fields.find("nodata_value");
  const double none = mark == fields.end() ? -9999.0 : mark->second;
  const auto count = static_cast<std::size_t>(terrain.columns) * static_cast<std::size_t>(terrain.rows);
  // Every value takes a digit and a blank: a header cannot ask for more memory than the file is worth.
  if (count > (scanner.rest.size() + 1) / 2) return Error{"", "", fmt::format("is cut short: {} values do not fit into the file", count)};
  terrain.heights.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = numberIn(scanner, nextWord(scanner));
    if (!value) return value.error();
    const bool missing = value.value() == none || static_cast<float>(value.value()) == static_cast<float>(none);
    terrain.heights.push_back(missing ? kNoHeight : asHeight(value.value()));
  }
  if (const auto more = nextWord(scanner); !more.empty())
    return Error{"", placeOf(scanner), fmt::format("'{}' comes after the {} values of the header", shown(more), count)};
  convertDegrees(terrain, fields.contains("xllcorner") || fields.contains("xllcenter"));
  return terrain;
}

}  // namespace overcast
