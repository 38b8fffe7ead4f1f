// One thread per voxel of one level: the mean of eight trilinear fetches of the level below.
#version 460
#include "runtime/passes/pyramid/pyramid.h"

layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;
layout(push_constant) uniform Push {
  PyramidPush push;
};
layout(set = 0, binding = 0) uniform sampler3D below;
layout(set = 0, binding = 1, r16f) uniform writeonly image3D level;

void main() {
  ivec3 voxel = ivec3(gl_GlobalInvocationID);
  if (any(greaterThanEqual(voxel, ivec3(push.size)))) return;
  float sum = 0.0f;
  for (int corner = 0; corner < 8; ++corner) sum += textureLod(below, pyramidFetch(voxel, corner, vec3(push.texel)), 0.0f).r;
  imageStore(level, voxel, vec4(0.125f * sum));
}
