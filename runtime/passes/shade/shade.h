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
// `calibrated`: C = exp(-e) with g_i = f_i / d_i + alpha, which is 0 over open ground, of taps further apart, and
//   e = sum w_i g_i + sum_j h_j (s(z_j) - s(b_j)),   z_j = b_j + sum w_ji g_i + c_j alpha (1 - N.U),   s(z) = z / (1 + |z|):
// soft steps h_j, each across a plane through the taps, because what a far tap misses counts for more where the near ones miss something
// too; one that faces down sees less than its taps tell. Weights and heights are not negative, so a surface is never brighter for a tap
// that misses more, and C is in [0, 1]; open ground is exactly 1 with any of them.
// `cones`: C = (mean over cones of min_i clamp(phi(P + d_i c) / (d_i s) + b, 0, 1))^q, all taps of level 0.
// `traced`: the share of rays that leave the volume (rays.h), so many in each pixel: neighbours take turns with 256 sets, and the
// denoise pass (denoise.h), widened, gives each pixel the mean of all. Pixels whose neighbours lie on other surfaces take more sets. A ray
// that has not left after kRaySteps has met something: it creeps along a crease.
//
// `hybrid`, `hybrid-cones`, `hybrid-traced`: baked apertures, corrected by what `calibrated`, `cones` or `traced` says has changed since
// the bake (rest.h). Scenes without apertures get that estimator alone.
//
// The paper's tap at d_0 = 0 is left out: it has no reach and reads only by how much mesh and field disagree.
#ifndef RUNTIME_PASSES_SHADE_SHADE_H
#define RUNTIME_PASSES_SHADE_SHADE_H

#include "runtime/passes/denoise/denoise.h"
#include "runtime/passes/rays/rays.h"
#include "runtime/passes/shade/rest.h"

OVERCAST_SHARED_BEGIN

const int kMaxTaps = 8;
const int kMaxCones = 64;
const int kMaxSteps = 8;

/// One tap of the estimator, in voxels of the global volume.
struct SkyTap {
  float distance;  //  0: d_i
  float weight;    //  4: of what is missing of it, in the exponent
  int level;       //  8: of the pyramid
  int padding;     // 12
};

/// A soft step of `calibrated`.
struct SkyStep {
  vec4 nearWeights;  //  0: w_j1 to w_j4
  vec4 farWeights;   // 16: w_j5 to w_j8
  vec4 shape;        // 32: x: b_j, y: c_j, z: h_j
};

/// What does not change from frame to frame.
struct SkyConstants {
  vec4 cone;                   //    0: x: spread, y: bias, z: power
  SkyTap taps[kMaxTaps];       //   16
  vec4 directions[kMaxCones];  //  144: xyz: unit axes of the cones in the frame about the normal, which is its z
  SkyStep steps[kMaxSteps];    // 1168
};

struct ShadePush {
  mat4 voxelFromClip;  //  0: voxel coordinates (from the volume's corner) from clip space, before the division by w
  vec4 skew;           // 64: xyz: alpha U; w: alpha
  vec4 sky;            // 80: rgb: linear radiance of the sky
};

/// A point that sky_points.comp.glsl looks at.
struct SkyPoint {
  vec4 place;   //  0: xyz: voxels of the volume, from its corner
  vec4 normal;  // 16: xyz: unit length
};

struct SkyPointsPush {
  vec4 skew;    //  0: ShadePush::skew
  ivec4 count;  // 16: x: of the points
};

/// d_i of `published` in voxels; tap 0 is d_1.
OVERCAST_INLINE float tapDistance(int tap) {
  return exp2(float(tap));
}

/// What a tap misses of what open ground has, as a share of d: f / d + alpha. 0 over open ground, 1 + alpha where it is shut.
OVERCAST_INLINE float tapMissing(float phi, float d, float alpha) {
  return 1.0f + alpha - phi / d;
}

/// s(z), in (-1, 1).
OVERCAST_INLINE float softStep(float z) {
  return z / (1.0f + abs(z));
}

/// alpha (1 - N.U) of a skewed normal N'.
OVERCAST_INLINE float turnedAway(vec3 skewed, vec4 skew) {
  return skew.w + skew.w * skew.w - dot(skewed, vec3(skew));
}

/// What a step adds to the exponent where the taps miss `missing`, the first four and the others.
OVERCAST_INLINE float stepExponent(SkyStep step, vec4 nearMissing, vec4 farMissing, float turned) {
  float z = step.shape.x + dot(step.nearWeights, nearMissing) + dot(step.farWeights, farMissing) + step.shape.y * turned;
  return step.shape.z * (softStep(z) - softStep(step.shape.x));
}

/// How open a cone is at a tap.
OVERCAST_INLINE float coneOpenness(float phi, float d, vec4 cone) {
  return clamp(phi / (d * cone.x) + cone.y, 0.0f, 1.0f);
}

/// Balls about points over a pixel, as large as the field there says that nothing is in them: its rays pass through them without looking.
const int kBalls = 3;

/// Height of the middle of ball `i` above the point that rays start from, voxels: each reaches into the next where the surface is open.
OVERCAST_INLINE float ballHeight(int i) {
  return exp2(float(2 * i + 1));
}

/// How far along a ray is clear that is clear up to `t`: to where it leaves the ball of `radius` about a point `height` above its start, if
/// it is in there at `t`. `rise`: what the ray rises per unit.
OVERCAST_INLINE float throughBall(float t, float rise, float height, float radius) {
  float middle = height * rise;
  float squared = radius * radius - height * height + middle * middle;
  if (squared <= 0.0f) return t;
  float reach = sqrt(squared);
  return t < middle - reach ? t : max(t, middle + reach);
}

/// Cones that tell the denoise pass without noise where near things begin and end (its guide), and taps along each.
const int kGuideCones = 6;
const int kGuideTaps = 3;

/// How open a cone is at tap `tap` where the field is `phi`; the taps are at 1.5, 3 and 6 voxels.
OVERCAST_INLINE float guideDistance(int tap) {
  return 1.5f * exp2(float(tap));
}
OVERCAST_INLINE float guideOpenness(float phi, int tap) {
  return clamp(phi / (1.2f * guideDistance(tap)) + 0.2f, 0.0f, 1.0f);
}

/// Direction of ray `ray` of `count` about +z at `place` of the wide pattern (0 to 255), unit length, z > 0.
OVERCAST_INLINE vec3 tracedDirection(int ray, int count, int place) {
  const float share = 0.0245436926f;  // of a whole turn
  return spiralDirection(ray, count, (float((91 * place) & 255) + 0.5f) / 256.0f, share * float(place));
}

/// How far from `p` along the unit vector `direction` the volume [0, size] begins; 0 inside it.
OVERCAST_INLINE float wayToVolume(vec3 p, vec3 direction, vec3 size) {
  float way = 0.0f;
  for (int axis = 0; axis < 3; ++axis) {
    float rise = abs(direction[axis]) < 1.0e-9f ? 1.0e-9f : direction[axis];
    way = max(way, min(-p[axis] / rise, (size[axis] - p[axis]) / rise));
  }
  return way;
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

/// Sky visibility in [0, 1] from the exponent e.
OVERCAST_INLINE float skyVisibility(float exponent) {
  return exp(-easedExponent(exponent));
}

OVERCAST_SHARED_END

#endif
