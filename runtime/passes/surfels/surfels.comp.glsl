// One thread per pixel: sky visibility and one bounce of light from all discs.
#version 460
#include "runtime/passes/screen/screen.glsl"
#include "runtime/passes/surfels/surfels.h"

layout(push_constant) uniform Push {
  SurfelPush push;
};
#define OVERCAST_SURFEL_GATHER 3
#include "runtime/passes/surfels/surfel_walk.glsl"

void main() {
  ivec2 pixel;
  vec3 point;
  if (!surfaceOfThread(push.relativeFromClip, pixel, point)) return;
  Gathered sum = gather(point, texelFetch(normalImage, pixel, 0).xyz, -1);
  float sky = surfelVisibility(sum.first, sum.second);
  writeLight(pixel, push.sky.rgb * sky + max(sum.light, vec3(0.0f)), sky);
}
