#include "runtime/passes/composite/heightfield_object.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "runtime/passes/composite/composite_object.h"
#include "runtime/passes/composite/heightfield.h"

namespace overcast {
namespace {

/// Steps of single floats that a height above the surface may be off by, relative to the box: a sum of nine products.
constexpr double kHeightRounding = 0x1p-19;

std::uint32_t addLayer(const HeightField& field, const HeightLevels& layer, int level, double unit, std::vector<glm::vec2>& texels) {
  if (layer.empty()) return shared::kNoLayer;
  const auto first = static_cast<std::uint32_t>(texels.size());
  const glm::ivec2 size = levelSize(field, level);
  const double scale = field.halfExtent.z / unit;
  for (int j = -1; j <= size.y; ++j)
    for (int i = -1; i <= size.x; ++i) {
      const HeightTexel texel = texelBeyond(field, layer, level, i, j);
      texels.emplace_back(static_cast<float>(scale * texel.mean), static_cast<float>(scale * scale * texel.variance));
    }
  return first;
}

}  // namespace

HeightFieldEntry addHeightField(const HeightField& field, std::vector<glm::vec2>& texels) {
  const glm::dvec2 cell = cellSize(field);
  HeightFieldEntry entry{field.localFromField, field.origin, field.halfExtent, std::max(cell.x, cell.y), {}};
  for (int level = 0; level < levelCount(field); ++level) {
    const glm::ivec2 size = levelSize(field, level);
    const int shorter = std::min(size.x, size.y);
    if (level > 0 && shorter < kMinHeightFieldSide) {
      // A sheet's search reads these.
      if (field.back.empty() && shorter >= shared::kLeastSheetSide) addLayer(field, field.front, level, entry.unit, texels);
      continue;
    }
    HeightFieldLevel& placed = entry.levels.emplace_back();
    placed.front = addLayer(field, field.front, level, entry.unit, texels);
    placed.back = addLayer(field, field.back, level, entry.unit, texels);
    placed.size = size;
    for (std::size_t i = placed.front; i < texels.size(); ++i) placed.highest = std::max(placed.highest, std::abs(texels[i].x));
    // Rounded to a float it must not become lower.
    placed.lipschitz = std::nextafter(static_cast<float>(lipschitzBound(field, level)), 3e38f);
  }
  return entry;
}

std::size_t heightFieldLevel(const HeightFieldEntry& entry, double voxelsPerUnit) {
  std::size_t level = 0;
  while (level + 1 < entry.levels.size() && std::exp2(static_cast<double>(level + 1)) * voxelsPerUnit <= 1.0) ++level;
  return level;
}

int heightFieldLevel(const HeightField& field, double voxel) {
  const auto fits = [&](int level) {
    const glm::ivec2 size = levelSize(field, level);
    const glm::dvec2 cell = cellSize(field, level);
    return std::min(size.x, size.y) >= kMinHeightFieldSide && std::max(cell.x, cell.y) <= voxel;
  };
  int level = 0;
  while (level + 1 < levelCount(field) && fits(level + 1)) ++level;
  return level;
}

shared::CompositeObject compositeObject(const HeightFieldEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid) {
  glm::dmat4 worldFromUnits = worldFromLocal * glm::dmat4(entry.localFromField * entry.unit);
  worldFromUnits[3] = worldFromLocal * glm::dvec4(entry.origin, 1.0);
  const glm::dvec3 half = entry.halfExtent / entry.unit;
  PlacedObject placed = placeObject({-half, half}, worldFromUnits, grid);
  shared::CompositeObject& object = placed.object;
  if (object.present == 0) return object;
  const HeightFieldLevel& level = entry.levels[heightFieldLevel(entry, placed.sigmaMin)];
  object.kind = shared::kKindHeightField;
  object.field = {level.front, level.back, static_cast<std::uint32_t>(level.size.x), static_cast<std::uint32_t>(level.size.y)};
  object.parameters = glm::vec4(glm::dvec4(2.0 * half.x / level.size.x, 2.0 * half.y / level.size.y, 1.0 / level.lipschitz, level.highest));
  object.boxMax.w = level.lipschitz;
  object.more.x = static_cast<float>((half.z + level.highest) * placed.sigmaMin);
  const double evaluation = kHeightRounding * half.z * placed.sigmaMin;
  object.slack = static_cast<float>(2.0 * (placed.rounding * static_cast<double>(level.lipschitz) + evaluation));
  return object;
}

}  // namespace overcast
