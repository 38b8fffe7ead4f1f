// Cone tracing: sky visibility by nine cones through the global volume, as Unreal Engine 4's distance field ambient occlusion does (Wright,
// Dynamic Occlusion with Signed Distance Fields, SIGGRAPH 2015). Read by C++ and GLSL.
//
// The cones share the hemisphere about the normal: three about a ring between the heights 1 and 2/3 of the unit sphere, six about one
// between 2/3 and 0, each of the same solid angle 2 pi / 9, which also is that of a cone. Along its axis a cone takes ten spheres that
// touch its sides, each a fixed ratio further out than the last, and sees the least share phi / radius that any of them leaves. Where a
// cone dips below the horizon its spheres are kept above it: open ground then is exactly 1, without a bias. Visibility is the mean weighted
// by the integral of the cosine over each cone's share of its ring. A sphere that is half in the open counts as shut by this measure:
// beside objects the technique is too dark, by up to 0.3; so it is described, and so it is left. Everything in voxels of the global volume.
#ifndef RUNTIME_PASSES_CONE_TRACING_CONE_TRACING_H
#define RUNTIME_PASSES_CONE_TRACING_CONE_TRACING_H

#include "runtime/passes/screen/screen.h"

OVERCAST_SHARED_BEGIN

const int kTracedCones = 9;
const int kUpperCones = 3;
const int kTracedConeSteps = 10;
const float kTracedConeTangent = 0.515388203f;  ///< of the half angle of a cone of 2 pi / 9: sqrt(17) / 8
/// Cones start this far above the surface, more than mesh and field disagree.
const float kTracedConeLift = 0.5f;
const float kTracedConeFirst = 1.0f;  ///< voxels to the first sphere

struct ConeTracingPush {
  mat4 voxelFromClip;  //  0: voxel coordinates (from the volume's corner) from clip space, before the division by w
  vec4 sky;            // 64: rgb: linear radiance of the sky; w: ratio of the distances of two spheres that follow each other
};

/// Axis of a cone about +z, unit length.
OVERCAST_INLINE vec3 tracedConeAxis(int cone) {
  bool upper = cone < kUpperCones;
  float height = upper ? 5.0f / 6.0f : 1.0f / 3.0f;
  float angle = upper ? 2.09439510f * float(cone) + 0.523598776f : 1.04719755f * float(cone);
  float radius = sqrt(1.0f - height * height);
  return vec3(radius * cos(angle), radius * sin(angle), height);
}

/// Its weight; all sum to 1.
OVERCAST_INLINE float tracedConeWeight(int cone) {
  return cone < kUpperCones ? 5.0f / 27.0f : 2.0f / 27.0f;
}

/// Share of the sphere at `distance` along a cone of axis height `height` that is clear where the field is `phi`.
OVERCAST_INLINE float tracedConeClear(float phi, float distance, float height) {
  return clamp(phi / (distance * min(kTracedConeTangent, height)), 0.0f, 1.0f);
}

/// The ratio that brings the last sphere to `reach` voxels.
OVERCAST_INLINE float tracedConeRatio(float reach) {
  return pow(max(reach / kTracedConeFirst, 1.0f), 1.0f / float(kTracedConeSteps - 1));
}

OVERCAST_SHARED_END

#endif
