// Shade: sky light from a few taps of the distance pyramid (DESIGN 5.4; Evans 2006, 9.6). Read by C++ and GLSL.
//
// Taps f_i = d_i - phi_{i-1}(P + d_i N'), N' = N + alpha U, d_1 = one voxel, d_i = 2 d_{i-1}; tap i reads pyramid level i - 1, whose
// blur is proportional to d_i. Everything in voxels of the global volume.
//
// Estimator `published`: C = exp(-k' sum f_i). The paper leaves open what C is over open ground: with its skewed normal a surface that
// faces the sky reads phi = (1 + alpha) d_i, so that C = exp(k' alpha sum d_i) > 1. Ours, on top of it:
//  * We divide by that constant, so that open ground is exactly 1, and write k' = k / sum d_i, so that k means the same for any number
//    of taps and any resolution: C = exp(-e), e = k (alpha + sum f_i / sum d_i).
//  * Round tops read more than open ground, because blurring a convex distance raises it: e < 0. A clamp there draws a line across them,
//    so e eases into it, see easedExponent. An open wall, e = k alpha, gets its true half of the sky for the default k = 1.5, alpha = 0.5.
//
// The paper's tap at d_0 = 0 is left out: it has no reach and reads only by how much mesh and field disagree.
#ifndef RUNTIME_PASSES_SHADE_SHADE_H
#define RUNTIME_PASSES_SHADE_SHADE_H

#include "runtime/passes/screen/screen.h"

OVERCAST_SHARED_BEGIN

const int kMaxTaps = 8;

/// 128 bytes: all the push constants a device must have.
struct ShadePush {
  mat4 voxelFromClip;  //   0: voxel coordinates (from the volume's corner) from clip space, before the division by w
  vec4 skew;           //  64: xyz: alpha U; w: constant term of the exponent
  vec4 sky;            //  80: rgb: linear radiance of the sky
  vec4 weights[2];     //  96: of f_1 .. f_8 in the exponent
};

/// d_i in voxels; tap 0 is d_1.
OVERCAST_INLINE float tapDistance(int tap) {
  return exp2(float(tap));
}

/// N', from a normal of any length: a degenerate one (zero, not finite) counts as none, which leaves the skew.
OVERCAST_INLINE vec3 skewedNormal(vec3 normal, vec3 skew) {
  float squared = dot(normal, normal);
  return squared > 0.0f && squared < 1.0e30f ? normal / sqrt(squared) + skew : skew;
}

/// 0 below 0, e^2 / (e + 1/16) above: without a kink where the clamp starts, e - 1/16 where it is dark.
OVERCAST_INLINE float easedExponent(float exponent) {
  float e = clamp(exponent, 0.0f, 1.0e4f);
  return e * e / (e + 0.0625f);
}

/// Sky visibility in [0, 1] from the exponent w_0 + sum w_i f_i.
OVERCAST_INLINE float skyVisibility(float exponent) {
  return exp(-easedExponent(exponent));
}

OVERCAST_SHARED_END

#endif
