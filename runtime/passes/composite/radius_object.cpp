#include "runtime/passes/composite/radius_object.h"

#include <cmath>
#include <numbers>

#include "runtime/passes/composite/composite_object.h"

namespace overcast {
namespace {

/// Share of the largest radius by which single floats may miss a distance: sums of a few products of numbers up to the box's diagonal,
/// and a direction that is off by a few ulps, which the Lipschitz bound turns into distance.
constexpr double kRounding = 32.0 * 0x1p-24;

/// The coarsest level whose texels, `unit` voxels from the centre, are narrow enough.
template <class Level>
std::size_t levelFor(const std::vector<Level>& levels, double unit) {
  constexpr double kWidest = 0.5;  // global voxels
  std::size_t chosen = 0;
  while (chosen + 1 < levels.size() && 0.5 * std::numbers::pi / (levels[chosen + 1].side - 1) * unit <= kWidest) ++chosen;
  return chosen;
}

}  // namespace

int radiusLevel(const RadiusField& field, double voxel) {
  return static_cast<int>(levelFor(field.levels, field.levels.front().largest / voxel));
}

RadiusEntry packRadius(const RadiusField& field, std::vector<glm::vec2>& texels) {
  RadiusEntry entry{field.centre, field.levels.front().largest, {}};
  for (std::size_t l = 0; l < field.levels.size(); ++l) {
    const RadiusLevel& level = field.levels[l];
    RadiusLevelEntry& placed = entry.levels.emplace_back();
    placed.first = static_cast<std::uint32_t>(texels.size());
    placed.side = level.side;
    placed.smallest = level.smallest / entry.unit;
    placed.largest = level.largest / entry.unit;
    placed.lipschitz = lipschitzBound(field, static_cast<int>(l));
    placed.box = {level.box.min / entry.unit, level.box.max / entry.unit};
    placed.gentlest = level.gentlest;
    for (const RadiusTexel& t : level.texel) {
      const glm::vec3 slope(glm::dvec3(t.slope) / entry.unit);
      texels.emplace_back(static_cast<float>(t.mean / entry.unit), slope.x);
      texels.emplace_back(slope.y, slope.z);
    }
  }
  return entry;
}

shared::CompositeObject compositeObject(const RadiusEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid) {
  glm::dmat4 worldFromUnits = worldFromLocal;
  for (int axis = 0; axis < 3; ++axis) worldFromUnits[axis] *= entry.unit;
  worldFromUnits[3] = worldFromLocal * glm::dvec4(entry.centre, 1.0);
  if (placeObject(entry.levels.front().box, worldFromUnits, grid).object.present == 0) return {};
  const RadiusLevelEntry& level = entry.levels[levelFor(entry.levels, singularValues(glm::dmat3(worldFromUnits) / grid.voxelSize).x)];
  PlacedObject placed = placeObject(level.box, worldFromUnits, grid);
  shared::CompositeObject& object = placed.object;
  if (object.present == 0) return {};
  object.kind = shared::kKindRadius;
  object.parameters = glm::vec4(static_cast<float>(level.smallest), static_cast<float>(kRadiusCore * level.smallest),
                                static_cast<float>(level.largest), static_cast<float>(level.gentlest));
  object.field = {level.first, static_cast<std::uint32_t>(level.side), 0u, 0u};
  object.boxMax.w = static_cast<float>(level.lipschitz);
  object.slack = static_cast<float>(2.0 * (placed.rounding + kRounding * placed.sigmaMin) * level.lipschitz);
  return object;
}

}  // namespace overcast
