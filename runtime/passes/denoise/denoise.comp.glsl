// One thread per pixel: its visibility (alpha of `raw`) averaged over the pattern of 4x4, together with how near things are (red, per
// pixel), or with OVERCAST_CORNERS that widened to the means of four pixels so many away. OVERCAST_LAST: makes light of it. OVERCAST_REST:
// of what is left of the visibility at rest (green of `raw`; runtime/passes/shade/rest.h).
#version 460
#include "runtime/passes/denoise/denoise.h"
#include "runtime/passes/screen/screen.glsl"
#include "runtime/passes/shade/rest.h"

layout(push_constant) uniform Push {
  DenoisePush push;
};
#include "runtime/passes/screen/open_sky.glsl"
layout(set = 0, binding = 4) uniform sampler2D raw;

// Weight on the surface of the pixel at `point` with `normal` of another, 0 where there is none.
float weightOf(ivec2 other, ivec2 size, vec3 point, vec3 normal) {
  if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, size))) return 0.0f;
  float depth = texelFetch(depthImage, other, 0).r;
  if (depth <= 0.0f) return 0.0f;
  vec3 way = pointOfPixel(push.relativeFromClip, other, size, depth) - point;
  return surfaceWeight(way, normal, texelFetch(normalImage, other, 0).xyz);
}

#ifdef OVERCAST_CORNERS
vec4 denoised(ivec2 pixel, ivec2 size, vec3 point, vec3 normal) {
  vec4 own = texelFetch(raw, pixel, 0);
  vec4 mean = own;
  for (int corner = 0; corner < 4; ++corner) {
    ivec2 other = pixel + OVERCAST_CORNERS * (2 * ivec2(corner & 1, corner >> 1) - 1);
    float weight = weightOf(other, size, point, normal);
    if (weight > 0.0f) mean += 0.25f * weight * (texelFetch(raw, other, 0) - own);
  }
  return mix(own, mean, wideShare(own.a, mean.a, own.r, OVERCAST_CORNERS));
}
#else
vec4 denoised(ivec2 pixel, ivec2 size, vec3 point, vec3 normal) {
  vec4 sum = vec4(0.0f);
  float weights = 0.0f;
  for (int y = -kDenoiseReach; y <= kDenoiseReach; ++y) {
    for (int x = -kDenoiseReach; x <= kDenoiseReach; ++x) {
      ivec2 other = pixel + ivec2(x, y);
      float weight = other == pixel ? 1.0f : windowWeight(x, y) * weightOf(other, size, point, normal);
      if (weight > 0.0f) sum += weight * texelFetch(raw, other, 0);
      weights += weight;
    }
  }
  return sum / weights;
}
#endif

void main() {
  ivec2 pixel;
  vec3 point;
  if (!surfaceOfThread(push.relativeFromClip, pixel, point)) return;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  vec4 made = denoised(pixel, imageSize(lightImage), point, normal);
#ifndef OVERCAST_LAST
  imageStore(lightImage, pixel, made);
#else
#ifdef OVERCAST_REST
  float sky = shareLeft(made.g, made.a);
#else
  float sky = made.a;
#endif
  writeLight(pixel, openSky(normal) * sky, sky);
#endif
}
