// One thread per pixel: its visibility (alpha of `raw`) averaged over the pattern, and the sky's light.
#version 460
#include "runtime/passes/denoise/denoise.h"
#include "runtime/passes/screen/screen.glsl"

layout(push_constant) uniform Push {
  DenoisePush push;
};
#include "runtime/passes/screen/open_sky.glsl"
layout(set = 0, binding = 4) uniform sampler2D raw;

void main() {
  ivec2 pixel;
  vec3 point;
  if (!surfaceOfThread(push.relativeFromClip, pixel, point)) return;
  ivec2 size = imageSize(lightImage);
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  float sum = 0.0f;
  float weights = 0.0f;
  for (int y = -kDenoiseReach; y <= kDenoiseReach; ++y) {
    for (int x = -kDenoiseReach; x <= kDenoiseReach; ++x) {
      ivec2 other = pixel + ivec2(x, y);
      if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, size))) continue;
      float depth = texelFetch(depthImage, other, 0).r;
      if (depth <= 0.0f) continue;
      vec3 way = pointOfPixel(push.relativeFromClip, other, size, depth) - point;
      float weight = windowWeight(x, y);
      if (other != pixel) weight *= surfaceWeight(way, normal, texelFetch(normalImage, other, 0).xyz);
      sum += weight * texelFetch(raw, other, 0).a;
      weights += weight;
    }
  }
  float sky = sum / weights;
  writeLight(pixel, openSky(normal) * sky, sky);
}
