// One thread per pixel: its visibility (alpha of `raw`) averaged over the pattern of 4x4, together with how near things are (red, per
// pixel), or with OVERCAST_CORNERS that widened to the means of four pixels so many away. The first step of a wide pattern follows a guide
// (blue), but for OVERCAST_FEW: pixels with one sample each. OVERCAST_LAST: makes light of it. OVERCAST_REST: of what is left of the
// visibility at rest (green of `raw`; runtime/passes/shade/rest.h).
#version 460
#include "runtime/passes/screen/screen.glsl"

#include "runtime/passes/denoise/window.glsl"
#include "runtime/passes/shade/rest.h"

layout(push_constant) uniform Push {
  DenoisePush push;
};
#include "runtime/passes/screen/open_sky.glsl"
layout(set = 0, binding = 4) uniform sampler2D raw;

#ifdef OVERCAST_FEW
const vec4 kLimits = kFewSamples;
#else
const vec4 kLimits = kManySamples;
#endif

#ifdef OVERCAST_CORNERS
vec4 denoised(ivec2 pixel, ivec2 size, vec3 point, vec3 normal) {
  vec4 own = texelFetch(raw, pixel, 0);
  vec4 mean = own;
  float weights = 0.0f;
  for (int corner = 0; corner < 4; ++corner) {
    ivec2 other = pixel + OVERCAST_CORNERS * (2 * ivec2(corner & 1, corner >> 1) - 1);
    float weight = weightOf(push.relativeFromClip, other, size, point, normal, kLimits);
    if (weight > 0.0f) mean += 0.25f * weight * (texelFetch(raw, other, 0) - own);
    weights += 0.25f * weight;
  }
#ifdef OVERCAST_FEW
  // At an edge the pixel's own window lacks much of the pattern, and those further in do not.
  if (weights > 0.0f) mean = own + (mean - own) / weights;
#endif
  return mix(own, mean, wideShare(own.a, mean.a, own.r, OVERCAST_CORNERS, push.sky.w, kLimits));
}
#else
vec4 denoised(ivec2 pixel, ivec2 size, vec3 point, vec3 normal) {
  vec4 own = texelFetch(raw, pixel, 0);
  vec4 sum = vec4(0.0f);
  vec4 together = vec4(0.0f);  // with the guide
  float weights = 0.0f;
  for (int y = -kDenoiseReach; y <= kDenoiseReach; ++y) {
    for (int x = -kDenoiseReach; x <= kDenoiseReach; ++x) {
      ivec2 other = pixel + ivec2(x, y);
      float weight = other == pixel ? 1.0f : windowWeight(x, y) * weightOf(push.relativeFromClip, other, size, point, normal, kLimits);
      weights += weight;
      if (weight <= 0.0f) continue;
      vec4 its = texelFetch(raw, other, 0);
      sum += weight * its;
      together += weight * its.b * its;
    }
  }
  vec4 mean = sum / weights;
#if !defined(OVERCAST_LAST) && !defined(OVERCAST_FEW)
  vec4 covariance = together / weights - mean.b * mean;
  float more = own.b - mean.b;
  mean.g = clamp(mean.g + guidedShare(covariance.g, covariance.b) * more, 0.0f, 1.0f);
  mean.a = clamp(mean.a + guidedShare(covariance.a, covariance.b) * more, 0.0f, 1.0f);
#endif
  return mean;
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
