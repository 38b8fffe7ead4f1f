// From a heightfield to its texels in the fields buffer and the record of a placed one (heightfield.h).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "formats/heightfield.h"
#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/global_grid.h"

namespace overcast {

/// One mip level of a heightfield on the device.
struct HeightFieldLevel {
  std::uint32_t front = 0;  ///< first texel in the fields buffer; rows of size.x + 2, size.y + 2 of them
  std::uint32_t back = 0;   ///< kNoLayer when single sided
  glm::ivec2 size{0};
  float lipschitz = 1.0f;
  float highest = 0.0f;  ///< largest height either way, units
};

/// What a record needs to know of a heightfield.
struct HeightFieldEntry {
  glm::dmat3 localFromField{1.0};
  glm::dvec3 origin{0.0};
  glm::dvec3 halfExtent{0.0};
  double unit = 1.0;                     ///< longer side of a texel of the finest level, local units
  std::vector<HeightFieldLevel> levels;  ///< those with at least kMinHeightFieldSide texels per side, and always the finest
};

/// Appends the texels of all these levels: mean in units of `unit`, variance in units of its square.
HeightFieldEntry addHeightField(const HeightField& field, std::vector<glm::vec2>& texels);

/// The level that a heightfield is composited from: the coarsest with texels no longer than one voxel of the global volume, else the
/// finest. `voxelsPerUnit`: smallest singular value of the transform from `unit`s to global voxels.
std::size_t heightFieldLevel(const HeightFieldEntry& entry, double voxelsPerUnit);

/// The same of a field on the host, `voxel` the size of a global voxel in local units.
int heightFieldLevel(const HeightField& field, double voxel);

/// The record of a heightfield placed by `worldFromLocal` (affine).
shared::CompositeObject compositeObject(const HeightFieldEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid);

}  // namespace overcast
