// One thread per point: its sky visibility by the estimator of sky_visibility.glsl, and how far the nearest surface is a voxel above it.
#version 460
#include "runtime/passes/screen/screen.h"
#include "runtime/passes/shade/sky_visibility.glsl"

layout(local_size_x = 64) in;
layout(push_constant) uniform Push {
  SkyPointsPush push;
};
layout(set = 0, binding = 0, std430) readonly buffer Points {
  SkyPoint points[];
};
layout(set = 0, binding = 1, std430) writeonly buffer Seen {
  vec2 seen[];
};

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= uint(push.count.x)) return;
  vec3 p = points[i].place.xyz;
  vec3 normal = points[i].normal.xyz;
  seen[i] = vec2(visibility(p, normal, push.skew), field(0, p + normal));
}
