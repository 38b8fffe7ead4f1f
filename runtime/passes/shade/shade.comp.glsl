// One thread per pixel: base colour times sky times sky visibility by the estimator of sky_visibility.glsl; with OVERCAST_TRACED a pixel's
// own share of visibility alone, of which the denoise pass makes light.
#version 460
#include "runtime/passes/screen/screen.glsl"
#include "runtime/passes/shade/sky_visibility.glsl"

layout(push_constant) uniform Push {
  ShadePush push;
};
#include "runtime/passes/screen/open_sky.glsl"

void main() {
  ivec2 pixel;
  vec3 p;
  if (!surfaceOfThread(push.voxelFromClip, pixel, p)) return;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
#ifdef OVERCAST_TRACED
  vec2 sky = visibilityOfPlace(p, normal, widePatternPlace(pixel));
  vec3 beside = pointOfPixel(push.voxelFromClip, pixel + ivec2(1, 0), imageSize(lightImage), texelFetch(depthImage, pixel, 0).r);
  imageStore(lightImage, pixel, vec4(sky.y * distance(p, beside), 0.0f, 0.0f, sky.x));
#else
  float sky = visibility(p, normal, push.skew);
  writeLight(pixel, openSky(normal) * sky, sky);
#endif
}
