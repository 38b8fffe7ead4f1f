// One thread per pixel: OVERCAST_RAYS rays through the global volume, those of its place in the pattern of denoise.h.
#version 460
#include "runtime/passes/denoise/denoise.h"
#include "runtime/passes/rays/rays.h"
#include "runtime/passes/screen/screen.glsl"

layout(push_constant) uniform Push {
  RaysPush push;
};
#include "runtime/passes/screen/volume.glsl"

float clearRay(vec3 from, vec3 direction) {
  float reach = reachInVolume(from, direction, volumeSize());
  float t = 0.0f;
  for (int i = 0; i < kRaySteps && t < reach; ++i) {
    float phi = volumeAt(from + t * direction);
    if (phi < rayHit(t)) return 0.0f;
    t += max(phi, kRayShortest);
  }
  return t < reach ? 0.0f : 1.0f;
}

void main() {
  ivec2 pixel;
  vec3 point;
  if (!surfaceOfThread(push.voxelFromClip, pixel, point)) return;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  mat3 frame = frameAbout(normal);
  vec3 from = point + kRayStart * normal;
  int place = patternPlace(pixel);
  float sky = 0.0f;
  for (int ray = 0; ray < OVERCAST_RAYS; ++ray) sky += clearRay(from, frame * rayDirection(ray, OVERCAST_RAYS, place));
  sky /= float(OVERCAST_RAYS);
  writeLight(pixel, push.sky.rgb * sky, sky);
}
