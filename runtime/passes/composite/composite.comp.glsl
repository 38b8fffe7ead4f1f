// One workgroup per brick: phi = min over the brick's objects. Each thread owns a column of voxels, so that an object is read once for all.
// OVERCAST_BRUTE_FORCE: one workgroup per brick of the whole volume, every object for every voxel; the truth the culled variant must equal.
#version 460
#include "runtime/passes/composite/composite_bindings.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 5, r16f) uniform writeonly image3D volume;

void takeMinimum(uint index, vec3 lowest, inout float column[kBrickSide]) {
  CompositeObject object = objects[index];
  if (object.present == 0u) return;
  for (int z = 0; z < kBrickSide; ++z) {
    vec3 local = localSample(object, vec3(lowest.x, lowest.y, lowest.z + float(z)));
    column[z] = min(column[z], objectDistance(object, local));
  }
}

void main() {
#ifdef OVERCAST_BRUTE_FORCE
  uint brick = gl_WorkGroupID.x;
  uint count = kBrickOverflow;
#else
  uint brick = activeBricks[gl_WorkGroupID.x];
  uint count = counts[brick];
#endif
  ivec3 corner = brickPosition(brick);
  vec3 lowest = brickCorner(corner) + vec3(gl_LocalInvocationID) + 0.5f;
  float column[kBrickSide];
  for (int z = 0; z < kBrickSide; ++z) column[z] = kFarField;
  if (count == kBrickOverflow) {
    for (uint i = 0u; i < uint(push.bricks.w); ++i) takeMinimum(i, lowest, column);
  } else {
    for (uint n = 0u; n < count; ++n) takeMinimum(lists[brick * uint(kBrickCapacity) + n].x, lowest, column);
  }
  ivec3 voxel = corner * kBrickSide + ivec3(gl_LocalInvocationID);
  for (int z = 0; z < kBrickSide; ++z) imageStore(volume, voxel + ivec3(0, 0, z), vec4(max(column[z], -kFarField)));
}
