// One thread per brick: the list of the objects that can be the nearest somewhere in the brick (DESIGN 5.2), and whether to composite the
// brick again. Every omission is justified by bounds alone, so any subset this leaves gives the same minimum to the last bit.
#version 460
#include "runtime/passes/composite/composite_bindings.glsl"

layout(local_size_x = 64) in;

uint first;  // of this brick's list
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

bool listHoldsMoved(uint count) {
  if (count == kBrickOverflow) return true;
  for (uint n = 0u; n < count; ++n)
    if (objects[lists[first + n].x].moved != 0u) return true;
  return false;
}

// The list's length, or kBrickOverflow.
uint buildList(vec3 centre) {
  uint length = 0u;
  best = 3.0e38f;
  for (uint i = 0u; i < uint(push.bricks.w); ++i) {
    CompositeObject object = objects[i];
    if (object.present == 0u) continue;
    vec3 local = localSample(object, centre);
    // A bound that needs no texture: no point is nearer than the box, give or take what its border holds.
    float atLeast = gapBeyondBox(object, local, closestSample(object, local)) + object.firstTexel.w;
    bool beyond = local != closestSample(object, local);
    if (beyond && atLeast - cullMargin(object, atLeast) > best) continue;
    float value = objectDistance(object, local);
    float margin = cullMargin(object, value);
    best = min(best, value + margin);
    float lower = value - margin;
    if (lower > best) continue;
    if (length == uint(kBrickCapacity)) length = compact(length);
    if (length == uint(kBrickCapacity)) return kBrickOverflow;
    lists[first + length] = uvec2(i, floatBitsToUint(lower));
    ++length;
  }
  return compact(length);
}

void main() {
  uint brick = gl_GlobalInvocationID.x;
  if (brick >= uint(push.bricks.x * push.bricks.y * push.bricks.z)) return;
  first = brick * uint(kBrickCapacity);
  bool again = push.everything != 0u || listHoldsMoved(counts[brick]);
  uint count = buildList(brickCorner(brickPosition(brick)) + 0.5f * float(kBrickSide));
  counts[brick] = count;
  if (again || listHoldsMoved(count)) activeBricks[atomicAdd(groups.x, 1u)] = brick;
}
