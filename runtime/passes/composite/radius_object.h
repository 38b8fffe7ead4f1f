// From a placed radius field to the record the composite's shaders read.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include "formats/radius.h"
#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/global_grid.h"

namespace overcast {

/// One level on the device. Lengths in units of RadiusEntry::unit, about the centre.
struct RadiusLevelEntry {
  std::uint32_t first = 0;  ///< place of its first texel in the fields buffer
  int side = 0;
  double smallest = 0.0;
  double largest = 0.0;
  double lipschitz = 1.0;
  double gentlest = 1.0;  ///< RadiusLevel::gentlest
  Box box;
};

/// Where a radius field is on the device.
struct RadiusEntry {
  glm::dvec3 centre{0.0};  ///< local space
  double unit = 1.0;       ///< largest radius of the finest level, local units
  std::vector<RadiusLevelEntry> levels;
};

/// Appends the texels (radius and slope in units) of all levels, finest first, to `texels`.
RadiusEntry packRadius(const RadiusField& field, std::vector<glm::vec2>& texels);

/// The level that a radius field is composited from: the coarsest whose texels, at the largest radius, are at most half a global voxel
/// wide; `voxel` is the size of a global voxel in local units.
int radiusLevel(const RadiusField& field, double voxel);

/// The record of a radius field placed by `worldFromLocal` (affine), of the level that suits its largest scale: finer ones hold what the
/// global volume cannot.
shared::CompositeObject compositeObject(const RadiusEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid);

}  // namespace overcast
