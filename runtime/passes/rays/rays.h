// Rays: sky visibility by brute force, a fixed set of rays sphere-traced through the global volume (Hart 1996). Read by C++ and GLSL.
//
// The rays of a pixel are the points of a sunflower spiral on the disc (Vogel 1979), lifted to the hemisphere about the normal: each then
// stands for the same share of the cosine-weighted hemisphere (Malley), so visibility is the share of rays that leave the volume. One set
// for all pixels would show as steps where the edge of an occluder crosses a ray; so the sixteen pixels of a pattern turn the set and move
// it outward by sixteenths of a ray's share, and the denoise pass (denoise.h) gives every pixel their mean. Everything in voxels of the
// global volume.
#ifndef RUNTIME_PASSES_RAYS_RAYS_H
#define RUNTIME_PASSES_RAYS_RAYS_H

#include "runtime/passes/screen/screen.h"

OVERCAST_SHARED_BEGIN

struct RaysPush {
  mat4 voxelFromClip;  //  0: voxel coordinates (from the volume's corner) from clip space, before the division by w
  vec4 sky;            // 64: rgb: linear radiance of the sky
};

/// Rays start this far above the surface, more than mesh and field disagree; 0.5 and 0.25 gave the least error on scenes of 64 and 128
/// voxels against 256.
const float kRayStart = 0.5f;
/// And have hit where the field is below this: thin sheets do not read zero between two samples.
const float kRayHit = 0.25f;
/// Steps at most. The lowest of 64 rays rises 0.09 per voxel: over open ground it leaves a volume of 256 voxels after 65. A ray that is
/// still there after all has hit: it creeps along a crease.
const int kRaySteps = 96;
const float kRayShortest = 0.25f;  ///< voxels a step takes at least

/// The field below which a ray has hit, `t` voxels from its start: it grows to kRayHit within two voxels, so that rays which leave a crease
/// for the open are not stopped by the wall beside them.
OVERCAST_INLINE float rayHit(float t) {
  return kRayHit * min(0.5f * t, 1.0f);
}

/// Direction of ray `ray` of `count` about +z, unit length, z > 0, on a spiral moved outward by `shift` of a ray's share, above 0 and below
/// 1, and turned by `turn` radians.
OVERCAST_INLINE vec3 spiralDirection(int ray, int count, float shift, float turn) {
  const float goldenAngle = 2.39996323f;
  float squared = (float(ray) + shift) / float(count);
  float radius = sqrt(squared);
  float angle = goldenAngle * float(ray) + turn;
  return vec3(radius * cos(angle), radius * sin(angle), sqrt(1.0f - squared));
}

/// That at `place` of the pattern (0 to 15).
OVERCAST_INLINE vec3 rayDirection(int ray, int count, int place) {
  const float sixteenth = 0.392699082f;
  return spiralDirection(ray, count, (float((7 * place) & 15) + 0.5f) / 16.0f, sixteenth * float(place));
}

OVERCAST_SHARED_END

#endif
