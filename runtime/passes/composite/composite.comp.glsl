// One workgroup per brick: phi = min over the brick's objects. Eight neighbouring threads stay in one octant, where the same objects count,
// and each thread owns a column of voxels, so that an object is read once for all.
// OVERCAST_BRUTE_FORCE: one workgroup per brick of the whole volume, every object for every voxel; the truth the culled variant must equal.
#version 460
#include "runtime/passes/composite/composite_bindings.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 5, r16f) uniform writeonly image3D volume;

// Takes the lowest entry out of a mask that is not empty.
uint takeEntry(inout uvec4 mask) {
  uint word = mask.x != 0u ? 0u : mask.y != 0u ? 1u : mask.z != 0u ? 2u : 3u;
  uint bits = mask[word];
  mask[word] = bits & (bits - 1u);
  return 32u * word + uint(findLSB(bits));
}

// A thread's voxels: two rows apart in y, all four in z.
const int kThreadVoxels = 8;
vec3 threadVoxel(int n) {
  return vec3(0.0f, float(2 * (n & 1)), float(n >> 1));
}

void main() {
#ifdef OVERCAST_BRUTE_FORCE
  uint brick = gl_WorkGroupID.x;
  uint count = kBrickOverflow;
#else
  uint brick = activeBricks[gl_WorkGroupID.x];
  uint count = counts[brick];
#endif
  uint t = gl_LocalInvocationIndex;
  uint octant = t >> 3;
  uvec3 side = uvec3(octant & 1u, octant >> 1 & 1u, octant >> 2);
  uvec3 voxel = side * uint(kOctantSide) + uvec3(t & 3u, t >> 2 & 1u, 0u);
  ivec3 corner = brickPosition(brick);
  vec3 lowest = brickCorner(corner) + vec3(voxel) + 0.5f;
  bool every = count == kBrickOverflow;
  if (every) count = uint(push.bricks.w);

  float nearest[kThreadVoxels];
  for (int n = 0; n < kThreadVoxels; ++n) nearest[n] = kFarField;
  uvec4 mask = every ? uvec4(0u) : masks[8u * brick + octant];
  uint next = 0u;
  // Tested at its end: on devices that run a loop's body under a mask until all threads have left, a test at its start costs one more
  // turn.
  bool more = count > 0u;
  if (more) {
    do {
      uint index = next++;
      more = next < count;
      if (!every) {
        index = lists[brick * uint(kBrickCapacity) + takeEntry(mask)].x;
        more = mask != uvec4(0u);
      }
      CompositeObject object = objects[index];
      if (object.present == 0u) continue;
      for (int n = 0; n < kThreadVoxels; ++n) {
        vec3 local = localPoint(object, lowest + threadVoxel(n));
        nearest[n] = min(nearest[n], objectDistance(object, local));
      }
    } while (more);
  }
  ivec3 at = corner * kBrickSide + ivec3(voxel);
  for (int n = 0; n < kThreadVoxels; ++n) imageStore(volume, at + ivec3(threadVoxel(n)), vec4(max(nearest[n], -kFarField)));
}
