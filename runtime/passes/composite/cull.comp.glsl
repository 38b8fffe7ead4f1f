// One thread per brick: the list of the objects that can be the nearest somewhere in the brick (DESIGN 5.2), for each octant which of them
// can be the nearest there, and whether to composite the brick again. Every omission is justified by bounds alone, so that whatever is
// left has the same minimum to the last bit.
#version 460
#include "runtime/passes/composite/composite_bindings.glsl"

layout(local_size_x = 64) in;

uint brick;
uint first;  // of the brick's list
float best;  // no object of the final list can be above this everywhere

// Leaves out what the current bound rules out, in place; the new length.
uint compact(uint length) {
  uint kept = 0u;
  for (uint n = 0u; n < length; ++n) {
    uvec2 entry = lists[first + n];
    if (uintBitsToFloat(entry.y) > best) continue;
    lists[first + kept] = entry;
    ++kept;
  }
  return kept;
}

// Whether an object moved that is the nearest, or may be, somewhere in the brick.
bool listHoldsMoved(uint count) {
  if (count == kBrickOverflow) return true;
  uvec4 used = uvec4(0u);
  for (uint octant = 0u; octant < 8u; ++octant) used |= masks[8u * brick + octant];
  for (uint n = 0u; n < count; ++n)
    if ((used[n / 32u] >> (n % 32u) & 1u) != 0u && objects[lists[first + n].x].moved != 0u) return true;
  return false;
}

// The list's length, or kBrickOverflow.
uint buildList(vec3 centre) {
  uint length = 0u;
  best = 3.0e38f;
  for (uint i = 0u; i < uint(push.bricks.w); ++i) {
    CompositeObject object = objects[i];
    if (object.present == 0u) continue;
    vec3 local = localPoint(object, centre);
    vec3 closest = closestInBox(object, local);
    // A bound that needs no texture: no point is nearer than the box, give or take what its border holds.
    float atLeast = gapBeyondBox(object, local, closest) + object.boxMin.w;
    if (local != closest && atLeast - lowerMargin(object, atLeast, kBrickRadius) > best) continue;
    vec4 range = objectRange(object, local);
    best = min(best, farthestWithin(object, range, kBrickRadius));
    float lower = nearestWithin(object, range, kBrickRadius);
    if (lower > best) continue;
    if (length == uint(kBrickCapacity)) length = compact(length);
    if (length == uint(kBrickCapacity)) return kBrickOverflow;
    lists[first + length] = uvec2(i, floatBitsToUint(lower));
    ++length;
  }
  return compact(length);
}

// Which of the list's entries can be the nearest in the octant about `centre`.
uvec4 octantMask(vec3 centre, uint count) {
  best = 3.0e38f;
  for (uint n = 0u; n < count; ++n) {
    CompositeObject object = objects[lists[first + n].x];
    vec4 range = objectRange(object, localPoint(object, centre));
    best = min(best, farthestWithin(object, range, kOctantRadius));
    lists[first + n].y = floatBitsToUint(nearestWithin(object, range, kOctantRadius));
  }
  uvec4 mask = uvec4(0u);
  for (uint n = 0u; n < count; ++n)
    if (!(uintBitsToFloat(lists[first + n].y) > best)) mask[n / 32u] |= 1u << (n % 32u);
  return mask;
}

void main() {
  brick = gl_GlobalInvocationID.x;
  if (brick >= uint(push.bricks.x * push.bricks.y * push.bricks.z)) return;
  first = brick * uint(kBrickCapacity);
  bool again = push.everything != 0u || listHoldsMoved(counts[brick]);
  vec3 corner = brickCorner(brickPosition(brick));
  uint count = buildList(corner + 0.5f * float(kBrickSide));
  counts[brick] = count;
  if (count != kBrickOverflow)
    for (uint octant = 0u; octant < 8u; ++octant) {
      vec3 side = vec3(octant & 1u, octant >> 1 & 1u, octant >> 2);
      masks[8u * brick + octant] = octantMask(corner + float(kOctantSide) * (side + 0.5f), count);
    }
  if (again || listHoldsMoved(count)) activeBricks[atomicAdd(groups.x, 1u)] = brick;
}
