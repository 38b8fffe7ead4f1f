// One thread per pixel: base colour times sky times sky visibility. OVERCAST_SKY: the sky is not uniform; the estimator is that of
// sky_visibility.glsl.
#version 460
#include "runtime/passes/aperture/sky.h"
#include "runtime/passes/screen/screen.glsl"
#include "runtime/passes/shade/sky_visibility.glsl"

layout(push_constant) uniform Push {
  ShadePush push;
};
#ifdef OVERCAST_SKY
layout(set = 0, binding = 13, std430) readonly buffer Sky {
  SkyLight skyLight;
};
#endif

// What an open surface receives of the sky, over pi.
vec3 openSky(vec3 normal) {
#ifdef OVERCAST_SKY
  return skyOverOpen(skyLight, normalize(normal));
#else
  return push.sky.rgb;
#endif
}

void main() {
  ivec2 pixel;
  vec3 p;
  if (!surfaceOfThread(push.voxelFromClip, pixel, p)) return;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  float sky = visibility(p, normal, push.skew);
  writeLight(pixel, openSky(normal) * sky, sky);
}
