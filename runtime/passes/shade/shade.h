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
// `calibrated`: neighbours take turns with directions about the normal, and the denoise pass (denoise.h), widened, gives each
// pixel the mean of all. A pixel looks along its direction u = N.D alone: taps at distances d_i that grow by one factor up to where the ray
// leaves the volume, so that walls count as far off as the scene has any. Of the unfiltered field,
//   g_i = (u - phi_i / d_i) / (u + 1/20)    what a tap misses of what open ground has, as a share,
//   v_i = 1 - (phi_i + phi_i+1) / (d_i+1 - d_i)    what of the way between two taps no ball of free space covers, less that of open ground,
//   C = exp(-e),   e = sum_j h_j (tanh z_j - tanh o_j),   z_j = o_j + sum w_ji g_i + sum x_ji v_i,   o_j = b_j + c_j (1 - u):
// soft steps h_j, each across a plane through the taps, because a ray that passes close to something at one tap may be free, at two not.
// Weights and heights are not negative, so a surface is never brighter for a tap that misses more, and C is in [0, 1]; open ground is
// exactly 1 with any of them.
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
  float distance;  //  0: d_i; of `calibrated`, where its taps start
  float weight;    //  4: of what is missing of it, in the exponent; of `calibrated`, how far out it is (calibratedDistance), 0 to 1
  int level;       //  8: of the pyramid
  int padding;     // 12
};

/// A soft step of `calibrated`.
struct SkyStep {
  vec4 nearWeights;  //  0: w_j1 to w_j4
  vec4 farWeights;   // 16: w_j5 to w_j8
  vec4 nearGaps;     // 32: x_j1 to x_j4
  vec4 farGaps;      // 48: x_j5 to x_j7
  vec4 shape;        // 64: x: b_j, y: c_j, z: h_j
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

/// What a tap of `published` misses of what open ground has, as a share of d: f / d + alpha. 0 over open ground, 1 + alpha where it is
/// shut.
OVERCAST_INLINE float tapMissing(float phi, float d, float alpha) {
  return 1.0f + alpha - phi / d;
}

/// The distance of a tap of `calibrated`, in voxels along a ray that leaves the volume `end` from its start, at `place` of the wide pattern
/// (0 to 255): places start up to 2.4 times nearer or further out than their mean. The last tap is where the ray leaves.
OVERCAST_INLINE float calibratedDistance(SkyTap tap, int place, float end) {
  float start = tap.distance * exp2(2.5f * ((float((165 * place) & 255) + 0.5f) / 256.0f - 0.5f));
  return min(start * pow(max(end, 8.0f * tap.distance) / start, tap.weight), max(end, 1.0f));
}

/// g of a tap along a direction whose cosine to the normal is `u`: 0 over open ground, about 1 where it is shut. On round tops, which have
/// more than open ground, down to -0.3.
OVERCAST_INLINE float shareMissing(float phi, float d, float u) {
  return max((u - phi / d) / (u + 0.05f), -0.3f);
}

/// v of two taps before what open ground has is taken off, as is told apart: -1 where the balls about them overlap by half or more.
OVERCAST_INLINE float gapBetween(float both, float d, float next) {
  return max(1.0f - both / max(next - d, 0.1f), -1.0f);
}

/// v of two taps that read `phi` and `nextPhi`.
OVERCAST_INLINE float gapMissing(float phi, float d, float nextPhi, float next, float u) {
  return gapBetween(phi + nextPhi, d, next) - gapBetween(u * (d + next), d, next);
}

/// tanh, for arguments of any size.
OVERCAST_INLINE float softStep(float z) {
  return 1.0f - 2.0f / (exp(2.0f * clamp(z, -20.0f, 20.0f)) + 1.0f);
}

/// What a step adds to the exponent where taps miss g and gaps v, the first four and the others.
OVERCAST_INLINE float stepExponent(SkyStep step, vec4 nearMissing, vec4 farMissing, vec4 nearGaps, vec4 farGaps, float u) {
  float open = step.shape.x + step.shape.y * (1.0f - u);
  float z = open + dot(step.nearWeights, nearMissing) + dot(step.farWeights, farMissing) + dot(step.nearGaps, nearGaps) +
            dot(step.farGaps, farGaps);
  return step.shape.z * (softStep(z) - softStep(open));
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

/// Of the places of the wide pattern, those that stand for all at a point: 0 to 63.
const int kPointPlaces = 64;
OVERCAST_INLINE int pointPlace(int n) {
  return 4 * n + 2;
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
