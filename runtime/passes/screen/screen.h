// Screen: what all passes share that light the picture pixel by pixel. Read by C++ and GLSL.
#ifndef RUNTIME_PASSES_SCREEN_SCREEN_H
#define RUNTIME_PASSES_SCREEN_SCREEN_H

#include "runtime/shared_types.h"

OVERCAST_SHARED_BEGIN

const float kNoSurface = -1.0f;  ///< alpha of a pixel that sees no surface; of the others it is the sky visibility

/// The point nearest to p at which level `level` of a volume of `size` voxels is sampled: half a texel of the level inside the border,
/// where interpolation is whole. Further out the field is continued: phi there plus the distance to it, continuous and without streaks.
OVERCAST_INLINE vec3 insideLevel(vec3 p, vec3 size, int level) {
  vec3 inset = min(vec3(0.5f * exp2(float(level))), 0.5f * size);
  return clamp(p, inset, size - inset);
}

OVERCAST_SHARED_END

#endif
