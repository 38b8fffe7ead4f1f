// Where rays start (rays.h), for shaders that have float fieldAt(vec3 p), the field at a point, both in voxels.
#include "runtime/passes/rays/rays.h"

// x: how far above the surface at `p` rays start, voxels: higher only where that leads out of what covers the surface, and not into what
// stands over it. y: the field there.
vec2 heightOfStart(vec3 p, vec3 normal) {
  float height = kRayStart;
  float phi = fieldAt(p + height * normal);
  for (int i = 0; i < kRayLifts; ++i) {
    float lift = rayLift(height, phi);
    float higher = fieldAt(p + (height + lift) * normal);
    if (higher <= phi) break;
    height += lift;
    phi = higher;
  }
  return vec2(height, phi);
}
