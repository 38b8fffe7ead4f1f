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

void main() {
#ifdef OVERCAST_BRUTE_FORCE
  uint brick = gl_WorkGroupID.x;
  uint count = kBrickOverflow;
#else
  uint brick = activeBricks[gl_WorkGroupID.x];
  uint count = counts[brick];
#endif
  uint t = gl_LocalInvocationIndex;
  uvec2 quadrant = uvec2(t >> 3 & 1u, t >> 4 & 1u);
  uvec2 within = uvec2(t & 3u, (t >> 2 & 1u) + 2u * (t >> 5));
  ivec3 corner = brickPosition(brick);
  bool every = count == kBrickOverflow;
  if (every) count = uint(push.bricks.w);

  for (uint storey = 0u; storey < 2u; ++storey) {
    uvec3 voxel = uvec3(quadrant * uint(kOctantSide) + within, storey * uint(kOctantSide));
    vec3 lowest = brickCorner(corner) + vec3(voxel) + 0.5f;
    float column[kOctantSide];
    for (int z = 0; z < kOctantSide; ++z) column[z] = kFarField;
    uvec4 mask = every ? uvec4(0u) : masks[8u * brick + quadrant.x + 2u * quadrant.y + 4u * storey];
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
        for (int z = 0; z < kOctantSide; ++z) {
          vec3 local = localPoint(object, vec3(lowest.x, lowest.y, lowest.z + float(z)));
          column[z] = min(column[z], objectDistance(object, local));
        }
      } while (more);
    }
    ivec3 at = corner * kBrickSide + ivec3(voxel);
    for (int z = 0; z < kOctantSide; ++z) imageStore(volume, at + ivec3(0, 0, z), vec4(max(column[z], -kFarField)));
  }
}
