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

/// Unit axes with the unit vector `normal` as the third: those of the world turned along the shortest arc from +y, so that they change
/// slowly over a surface everywhere but at a normal of -y.
OVERCAST_INLINE mat3 frameAbout(vec3 normal) {
  float level = normal.x * normal.x + normal.z * normal.z;
  float rise = normal.y < 0.0f ? level / (1.0f - normal.y) : 1.0f + normal.y;
  if (rise < 1.0e-12f) return mat3(vec3(1.0f, 0.0f, 0.0f), vec3(0.0f, 0.0f, 1.0f), normal);
  vec3 x = vec3(1.0f - normal.x * normal.x / rise, -normal.x, -normal.x * normal.z / rise);
  vec3 z = vec3(-normal.x * normal.z / rise, -normal.z, 1.0f - normal.z * normal.z / rise);
  return mat3(x, z, normal);
}

/// How far from `p` along the unit vector `direction` the volume [0, size] ends for good; 0 where it lies behind.
OVERCAST_INLINE float reachInVolume(vec3 p, vec3 direction, vec3 size) {
  float end = 1.0e9f;
  for (int axis = 0; axis < 3; ++axis) {
    float rise = abs(direction[axis]) < 1.0e-9f ? 1.0e-9f : direction[axis];
    end = min(end, max(-p[axis] / rise, (size[axis] - p[axis]) / rise));
  }
  return max(end, 0.0f);
}

OVERCAST_SHARED_END

#endif
