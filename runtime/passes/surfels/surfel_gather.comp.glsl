// One thread per placed node, as a receiver. OVERCAST_SURFEL_GATHER: 1: its accessibility, 2: the light it gets from others.
#version 460
#include "runtime/passes/surfels/surfels.h"

layout(local_size_x = 64) in;
layout(push_constant) uniform Push {
  SurfelPush push;
};
#include "runtime/passes/surfels/surfel_walk.glsl"

void main() {
  int self = int(gl_GlobalInvocationID.x);
  if (self >= push.counts.x) return;
  Gathered sum = gather(placed[self].place.xyz, placed[self].normal.xyz, self);
#if OVERCAST_SURFEL_GATHER == 1
  lights[self].a = clamp(1.0f - sum.first, 0.0f, 1.0f);
#else
  lights[self].r = sum.light.r;
  lights[self].g = sum.light.g;
  lights[self].b = sum.light.b;
#endif
}
