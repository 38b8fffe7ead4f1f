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

/// Rays start at least this far above the surface. The field should be 0 there, but where mesh and field disagree (blurred heights, spans
/// between voxels, creases between two samples) the surface may lie within it, and all rays would be stopped at once: there they start
/// where the field reads kRayOpen of their height above the surface. Not more (start.glsl), or contact shadows are lost that are right.
const float kRayStart = 0.25f;
const float kRayOpen = 0.25f;
const int kRayLifts = 3;       ///< looks for such a start
const float kRayFirst = 0.5f;  ///< voxels along a ray to where it first looks
/// And have hit where the field is below this: thin sheets do not read zero between two samples.
const float kRayHit = 0.25f;
/// Steps at most. The lowest ray of the sixteen sets of 64 rises 0.022 per voxel: over open ground it leaves a volume of 128 voxels after
/// 114. A ray that is still there after all has hit: it creeps along a crease.
const int kRaySteps = 128;
const float kRayShortest = 0.25f;  ///< voxels a step takes at least

/// How much higher above the surface to start than at `height`, where the field is `phi`, voxels: at most two in each look.
OVERCAST_INLINE float rayLift(float height, float phi) {
  return clamp(kRayOpen * height - phi, 0.0f, 2.0f);
}

/// Whether a ray has hit `t` voxels from its start and `height` above the plane of the surface, where the field is `phi`, having been
/// `before` a look earlier. What is enough grows to kRayHit within two voxels, and so far only where the field falls: rays that leave a
/// crease for the open are not stopped by what stands beside or over them. It is at most half of what that plane alone reads, so that no
/// ray is stopped by the ground it starts from.
OVERCAST_INLINE bool rayHits(float t, float height, float phi, float before) {
  float enough = min(kRayHit * min(0.5f * t, 1.0f), 0.5f * height);
  return phi < enough && (phi < before || t > 2.0f);
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
