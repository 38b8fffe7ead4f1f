// One thread per pixel: base colour times sky times sky visibility by the estimator of sky_visibility.glsl; with OVERCAST_TRACED a pixel's
// own share of visibility alone, of which the denoise pass makes light. OVERCAST_REST: what is left since the bake of apertures (rest.h).
#version 460
#include "runtime/passes/screen/screen.glsl"
#include "runtime/passes/shade/sky_visibility.glsl"

layout(push_constant) uniform Push {
  ShadePush push;
};
#include "runtime/passes/screen/open_sky.glsl"

#ifdef OVERCAST_REST
layout(set = 0, binding = 14) uniform sampler2D restImage;
#endif

// What the estimator says at a pixel; y: of its own rays, how near what they meet is (visibilityOfPlace).
vec2 visibilityOfPixel(ivec2 pixel, vec3 p, vec3 normal) {
#ifdef OVERCAST_TRACED
  return visibilityOfPlace(p, normal, widePatternPlace(pixel));
#else
  return vec2(visibility(p, normal, push.skew), 0.0f);
#endif
}

// x, y: visibilityOfPixel; z: visibility at rest, 1 where that is known at the vertices or nobody asks.
vec3 nowAndAtRest(ivec2 pixel, vec3 p, vec3 normal) {
#ifdef OVERCAST_REST
  float trust = texelFetch(restImage, pixel, 0).g;
  if (restIsUnchanged(trust)) return vec3(1.0f, 0.0f, 1.0f);
  vec3 seen = vec3(visibilityOfPixel(pixel, p, normal), 1.0f);
  atRest = true;
  if (restIsLookedUp(trust)) seen.z = visibilityOfPixel(pixel, p, normal).x;
  return seen;
#else
  return vec3(visibilityOfPixel(pixel, p, normal), 1.0f);
#endif
}

void main() {
  ivec2 pixel;
  vec3 p;
  if (!surfaceOfThread(push.voxelFromClip, pixel, p)) return;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  vec3 seen = nowAndAtRest(pixel, p, normal);
#ifdef OVERCAST_TRACED
  vec3 beside = pointOfPixel(push.voxelFromClip, pixel + ivec2(1, 0), imageSize(lightImage), texelFetch(depthImage, pixel, 0).r);
  imageStore(lightImage, pixel, vec4(seen.y * distance(p, beside), seen.z, 0.0f, seen.x));
#else
  float sky = shareLeft(seen.z, seen.x);
  writeLight(pixel, openSky(normal) * sky, sky);
#endif
}
