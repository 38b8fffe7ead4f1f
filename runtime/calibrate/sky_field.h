// SkyField: the global volume and its pyramid read back from the device, for what is computed of them on the CPU.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "runtime/asset_store.h"
#include "runtime/passes/composite/composite_pass.h"
#include "runtime/passes/pyramid/pyramid_pass.h"
#include "runtime/scene.h"

namespace overcast {

/// One level of the pyramid: x fastest, in voxels of level 0.
struct FieldLevel {
  glm::ivec3 size{1};
  std::vector<float> values;
};

struct SkyField {
  GlobalGrid grid;
  std::vector<FieldLevel> levels;  ///< level 0 first
};

/// phi of a level at `p` in voxel coordinates of the grid, in voxels, as the shade pass reads it: trilinear, continued outside the volume
/// (shared::insideLevel).
float fieldAt(const SkyField& field, int level, const glm::vec3& p);

/// What composites the volume of one scene and filters it.
struct FieldMaker {
  AssetStore store;
  CompositePass composite;
  PyramidPass pyramid;
};

/// With `resolution` voxels along the longest side (a multiple of 8 from 32 to 256) and all levels. An Error when the device has no room.
Result<FieldMaker> makeFieldMaker(const Device& device, const RuntimeScene& scene, int resolution);
void destroyFieldMaker(const Device& device, FieldMaker& maker);

/// The field at `time` seconds.
Result<SkyField> readField(const Device& device, FieldMaker& maker, const RuntimeScene& scene, double time);

}  // namespace overcast
