// One thread per pixel: nine cones through the global volume.
#version 460
#include "runtime/passes/cone_tracing/cone_tracing.h"
#include "runtime/passes/screen/screen.glsl"

layout(push_constant) uniform Push {
  ConeTracingPush push;
};
#include "runtime/passes/screen/volume.glsl"

float clearCone(vec3 from, vec3 axis, float height) {
  float clear = 1.0f;
  float t = kTracedConeFirst;
  for (int i = 0; i < kTracedConeSteps && clear > 0.0f; ++i) {
    clear = min(clear, tracedConeClear(volumeAt(from + t * axis), t, height));
    t *= push.sky.w;
  }
  return clear;
}

void main() {
  ivec2 pixel;
  vec3 point;
  if (!surfaceOfThread(push.voxelFromClip, pixel, point)) return;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  mat3 frame = frameAbout(normal);
  vec3 from = point + kTracedConeLift * normal;
  float sky = 0.0f;
  for (int cone = 0; cone < kTracedCones; ++cone) {
    vec3 axis = tracedConeAxis(cone);
    sky += tracedConeWeight(cone) * clearCone(from, frame * axis, axis.z);
  }
  writeLight(pixel, push.sky.rgb * sky, sky);
}
