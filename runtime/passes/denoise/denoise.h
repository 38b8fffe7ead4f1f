// Denoise: the mean over the pixels of a 4x4 pattern, along the surface. Read by C++ and GLSL.
//
// A pass whose samples differ from pixel to pixel in a pattern that repeats every four pixels gets all sixteen sets in each pixel, without
// noise and without a history: every window of 5x5 pixels with half weights on its border holds each place of the pattern with weight 1.
// Neighbours count as far as they lie in the pixel's plane and face as it does (a bilateral filter, Tomasi and Manduchi 1998).
//
// Samples are noisy, and their mean over a window washes out what changes within a few pixels, contact shadows say. So a pass that has a
// noise-free guess of where it does gives that as a guide, and a pixel gets as much more than the mean of its window as its guide has more,
// by the regression of samples on guides there (guidedShare).
//
// Widened twice, 256 sets in a pattern of 16x16 pixels: what that makes of the four pixels two away to the left or right and two up or
// down covers each set of 8x8 pixels once, and the same of that, four away, each of all. Where what hides the sky stands near, light
// changes within fewer pixels than that, and so it may where a step changes more than rays err: what was before remains.
#ifndef RUNTIME_PASSES_DENOISE_DENOISE_H
#define RUNTIME_PASSES_DENOISE_DENOISE_H

#include "runtime/passes/screen/screen.h"

OVERCAST_SHARED_BEGIN

const int kPatternSide = 4;
const int kPatternSize = 16;
const int kDenoiseReach = 2;  ///< pixels to either side
const int kWidePatternSize = 256;

/// Limits of what a pixel takes from others: the rise per unit of way and the cosine between normals from which they count nothing, how
/// much four pixels two away of one ray each may err, and how much farther than its square root times a window's reach things must be for
/// the wider one.
const vec4 kManySamples = vec4(0.2f, 0.8f, 1.28f, 3.0f);
/// The same where a pixel has one sample, and misses each of the pattern that is left out: what bends counts, what has an edge does not.
const vec4 kFewSamples = vec4(0.5f, 0.5f, 1.6f, 1.2f);

struct DenoisePush {
  mat4 relativeFromClip;  //  0: positions relative to the eye from clip space, before the division by w
  vec4 sky;               // 64: rgb: linear radiance of the sky; w: rays of a pixel, where the pattern is wide
};

/// Place of a pixel in the pattern, 0 to 15: a Bayer matrix, so that near pixels have far numbers.
OVERCAST_INLINE int patternPlace(ivec2 pixel) {
  int x = pixel.x & 3, y = pixel.y & 3;
  int mixed = x ^ y;
  return ((mixed & 1) << 3) | ((y & 1) << 2) | (mixed & 2) | (y >> 1);
}

/// The pixel of a group's 8x8 that thread `index` of the group takes, so that threads next to each other, which wait for each other, have
/// sets that differ little: the four pixels of a place, and those of the next place.
OVERCAST_INLINE ivec2 pixelInTurn(int index) {
  int place = index >> 2;
  int y = ((place & 1) << 1) | ((place >> 2) & 1);
  int x = ((place & 2) | (place >> 3)) ^ y;
  return ivec2(x + 4 * (index & 1), y + 2 * (index & 2));
}

/// Place of a pixel in the pattern of 16x16, 0 to 255, likewise.
OVERCAST_INLINE int widePatternPlace(ivec2 pixel) {
  int mixed = pixel.x ^ pixel.y;
  int block = ((mixed & 4) << 1) | (pixel.y & 4) | ((mixed & 8) >> 2) | ((pixel.y & 8) >> 3);
  return (patternPlace(pixel) << 4) | block;
}

/// How much of its visibility a pixel takes from four windows `reach` pixels to each side, 0 to 1, where it has `own`, their mean is
/// `wider` and those of its `rays` that meet something do so 1 / `nearness` pixels away (the harmonic mean).
OVERCAST_INLINE float wideShare(float own, float wider, float nearness, int reach, float rays, vec4 limits) {
  float squared = float(reach * reach);
  float dim = clamp(8.0f * own, 0.2f, 1.0f);  // light that is weak changes by less
  float far = clamp((1.0f - own) / max(limits.w * squared * dim * nearness, 1.0e-6f) - 1.0f, 0.0f, 1.0f);
  float noise = limits.z / squared * sqrt(sqrt(max(wider * (1.0f - wider), 0.0f) / (rays * rays * rays))) + 1.0e-4f;
  return far * clamp(2.0f - abs(wider - own) / noise, 0.0f, 1.0f);
}

/// Weight of a neighbour by where it is in the window.
OVERCAST_INLINE float windowWeight(int x, int y) {
  return (abs(x) == kDenoiseReach ? 0.5f : 1.0f) * (abs(y) == kDenoiseReach ? 0.5f : 1.0f);
}

/// Weight of a neighbour on the surface: `way` leads to it, unit normals. 1 in the pixel's plane, 0 from either of the first two
/// `limits` on.
OVERCAST_INLINE float surfaceWeight(vec3 way, vec3 normal, vec3 itsNormal, vec4 limits) {
  float rise = abs(dot(way, normal));
  float level = clamp(1.0f - rise * rise / (limits.x * limits.x * dot(way, way) + 1.0e-30f), 0.0f, 1.0f);
  return level * clamp((dot(normal, itsNormal) - limits.y) / (1.0f - limits.y), 0.0f, 1.0f);
}

/// How much of what the guide has more at a pixel than in the mean of its window the pixel has more, too, [0, 1]: the regression of what is
/// averaged on the guide over the window (the guided filter: He, Sun and Tang 2013, equation 5), which tends to none where the guide varies
/// less than the samples are noisy.
OVERCAST_INLINE float guidedShare(float covariance, float variance) {
  return clamp(covariance / (variance + 1.0e-3f), 0.0f, 1.0f);
}

const int kMostSets = 8;

/// How many sets of samples a pixel takes whose window weighs `weight` on its surface, 1 to 16, so that at outlines and on thin or curved
/// things, where few neighbours share theirs, there are about as many as on level ground.
OVERCAST_INLINE int setsOfPixel(float weight) {
  return clamp(int(floor(float(kPatternSize) / weight + 0.5f)), 1, kMostSets);
}

OVERCAST_SHARED_END

#endif
