// One thread per pixel: base colour times sky times sky visibility by the estimator of sky_visibility.glsl; with OVERCAST_TURNS a pixel's
// own share of visibility alone, of which the denoise pass makes light. OVERCAST_REST: what is left since the bake of apertures (rest.h).
#version 460
#include "runtime/passes/screen/screen.glsl"
#include "runtime/passes/shade/sky_visibility.glsl"

#ifdef OVERCAST_TRACED
#include "runtime/passes/denoise/window.glsl"
#endif

layout(push_constant) uniform Push {
  ShadePush push;
};
#include "runtime/passes/screen/open_sky.glsl"

#ifdef OVERCAST_REST
layout(set = 0, binding = 14) uniform sampler2D restImage;
#endif

// How many sets of the pattern a pixel takes.
int setsAt(ivec2 pixel, vec3 p, vec3 normal) {
#ifdef OVERCAST_TRACED
  return setsOfPixel(sharedWeight(push.voxelFromClip, pixel, imageSize(lightImage), p, normal));
#else
  return 1;
#endif
}

// What the estimator says at a pixel; of its own directions y: how near what they meet is (visibilityOfPlace), z: the guide of the denoise
// pass.
vec3 visibilityOfPixel(ivec2 pixel, int sets, vec3 p, vec3 normal) {
#ifdef OVERCAST_TRACED
  int place = widePatternPlace(pixel);
  RayStart rays = startOver(p, normal);
  vec2 sum = vec2(0.0f);
  for (int i = 0; i < sets; ++i) sum += visibilityOfPlace(rays, (place + i * kWidePatternSize / sets) & (kWidePatternSize - 1));
  return vec3(sum / float(sets), guideOf(p, rays.frame));
#elif defined(OVERCAST_TURNS)
  return vec3(visibilityOfPlace(p, normal, widePatternPlace(pixel)), 0.0f);
#else
  return vec3(visibility(p, normal, push.skew), 0.0f, 0.0f);
#endif
}

// x, y, z: visibilityOfPixel; w: visibility at rest, 1 where that is known at the vertices or nobody asks.
vec4 nowAndAtRest(ivec2 pixel, vec3 p, vec3 normal) {
#ifdef OVERCAST_REST
  float trust = texelFetch(restImage, pixel, 0).g;
  if (restIsUnchanged(trust)) return vec4(1.0f, 0.0f, 1.0f, 1.0f);
  int sets = setsAt(pixel, p, normal);
  vec4 seen = vec4(visibilityOfPixel(pixel, sets, p, normal), 1.0f);
  atRest = true;
  if (restIsLookedUp(trust)) seen.w = visibilityOfPixel(pixel, sets, p, normal).x;
  return seen;
#else
  return vec4(visibilityOfPixel(pixel, setsAt(pixel, p, normal), p, normal), 1.0f);
#endif
}

void main() {
#ifdef OVERCAST_TRACED
  ivec2 pixel = 8 * ivec2(gl_WorkGroupID) + pixelInTurn(int(gl_LocalInvocationIndex));
#else
  ivec2 pixel = ivec2(gl_GlobalInvocationID);
#endif
  vec3 p;
  if (!surfaceOfPixel(push.voxelFromClip, pixel, p)) return;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  vec4 seen = nowAndAtRest(pixel, p, normal);
#ifdef OVERCAST_TURNS
  vec3 beside = pointOfPixel(push.voxelFromClip, pixel + ivec2(1, 0), imageSize(lightImage), texelFetch(depthImage, pixel, 0).r);
  imageStore(lightImage, pixel, vec4(seen.y * distance(p, beside), seen.w, seen.z, seen.x));
#else
  float sky = shareLeft(seen.w, seen.x);
  writeLight(pixel, openSky(normal) * sky, sky);
#endif
}
