// The window of the denoise pass about a pixel (denoise.h), for shaders that include screen.glsl.
#include "runtime/passes/denoise/denoise.h"

// Weight on the surface of the pixel at `point` with `normal` of another, 0 where there is none. `point` is in the space that
// `fromClip` leads to.
float weightOf(mat4 fromClip, ivec2 other, ivec2 size, vec3 point, vec3 normal, vec4 limits) {
  if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, size))) return 0.0f;
  float depth = texelFetch(depthImage, other, 0).r;
  if (depth <= 0.0f) return 0.0f;
  vec3 way = pointOfPixel(fromClip, other, size, depth) - point;
  return surfaceWeight(way, normal, texelFetch(normalImage, other, 0).xyz, limits);
}

// Sum of the window's weights, of which the pixel's own is 1, where pixels have many samples.
float sharedWeight(mat4 fromClip, ivec2 pixel, ivec2 size, vec3 point, vec3 normal) {
  float sum = 1.0f;
  for (int y = -kDenoiseReach; y <= kDenoiseReach; ++y)
    for (int x = -kDenoiseReach; x <= kDenoiseReach; ++x)
      if (x != 0 || y != 0) sum += windowWeight(x, y) * weightOf(fromClip, pixel + ivec2(x, y), size, point, normal, kManySamples);
  return sum;
}
