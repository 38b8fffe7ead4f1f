// One thread per pixel: OVERCAST_RAYS rays through the global volume, those of its place in the pattern of denoise.h.
#version 460
#include "runtime/passes/denoise/denoise.h"
#include "runtime/passes/rays/rays.h"
#include "runtime/passes/screen/screen.glsl"

layout(push_constant) uniform Push {
  RaysPush push;
};
#include "runtime/passes/screen/volume.glsl"

float fieldAt(vec3 p) {
  return volumeAt(p);
}
#include "runtime/passes/rays/start.glsl"

// `start`: heightOfStart; `rise`: what the ray rises per voxel above the surface.
float clearRay(vec3 from, vec3 direction, vec2 start, float rise) {
  float reach = reachInVolume(from, direction, volumeSize());
  float t = kRayFirst;
  float before = start.y;
  for (int i = 0; i < kRaySteps && t < reach; ++i) {
    float phi = volumeAt(from + t * direction);
    if (rayHits(t, start.x + t * rise, phi, before)) return 0.0f;
    before = phi;
    t += max(phi, kRayShortest);
  }
  return t < reach ? 0.0f : 1.0f;
}

void main() {
  ivec2 pixel = 8 * ivec2(gl_WorkGroupID) + pixelInTurn(int(gl_LocalInvocationIndex));
  vec3 point;
  if (!surfaceOfPixel(push.voxelFromClip, pixel, point)) return;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  mat3 frame = frameAbout(normal);
  vec2 start = heightOfStart(point, normal);
  vec3 from = point + start.x * normal;
  int place = patternPlace(pixel);
  float sky = 0.0f;
  for (int ray = 0; ray < OVERCAST_RAYS; ++ray) {
    vec3 direction = rayDirection(ray, OVERCAST_RAYS, place);
    sky += clearRay(from, frame * direction, start, direction.z);
  }
  sky /= float(OVERCAST_RAYS);
  writeLight(pixel, push.sky.rgb * sky, sky);
}
