// What the cull and the composite shader share: the objects, and an object's distance at a point.
#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/fields.h"
#include "runtime/passes/composite/primitive.h"

layout(push_constant) uniform Push {
  CompositePush push;
};
layout(set = 0, binding = 0, std430) readonly buffer Objects {
  CompositeObject objects[];
};
// Objects in each brick's list, or kBrickOverflow.
layout(set = 0, binding = 1, std430) buffer Counts {
  uint counts[];
};
// kBrickCapacity for each brick: the object, and bits of a lower bound while the list is built.
layout(set = 0, binding = 2, std430) buffer Lists {
  uvec2 lists[];
};
// groups: an indirect dispatch; then the bricks to composite.
layout(set = 0, binding = 3, std430) buffer Active {
  uvec4 groups;
  uint activeBricks[];
};
layout(set = 0, binding = 4) uniform sampler3D atlas;
layout(set = 0, binding = 8) uniform sampler3D atlas8;
// 8 for each brick, one for each octant (x lowest): which entries of the list can be the nearest in it.
layout(set = 0, binding = 6, std430) buffer Masks {
  uvec4 masks[];
};

// fields.h; formulas that read it are included below this.
layout(set = 0, binding = 7, std430) readonly buffer Fields {
  vec2 fields[];
};
#include "runtime/passes/composite/heightfield.h"
#include "runtime/passes/composite/radius.h"

float volumeDistance(CompositeObject object, vec3 local) {
  return textureLod(atlas, (vec3(object.parameters) + local) * vec3(push.atlasTexel), 0.0f).r;
}

float volume8Distance(CompositeObject object, vec3 local) {
  return textureLod(atlas8, (vec3(object.parameters) + local) * vec3(push.texel8), 0.0f).r;
}

// OVERCAST_KINDS has a bit for each kind that the scene holds. The code of the others is not there: devices that run both sides of every
// branch under a mask would pay for it.
bool isKind(CompositeObject object, uint kind) {
  return (uint(OVERCAST_KINDS) >> kind & 1u) != 0u && object.kind == kind;
}

// Distance at a point of the object's box, in the kind's units. One line per kind.
float boxedDistance(CompositeObject object, vec3 local) {
  float distance = 0.0f;
  if (isKind(object, kKindHeightField)) distance = heightFieldDistance(OVERCAST_FIELDS_HERE object, local);
  if (isKind(object, kKindVolume)) distance = volumeDistance(object, local);
  if (isKind(object, kKindVolume8)) distance = volume8Distance(object, local);
  return distance;
}

// Of a primitive, at any point.
float exactDistance(CompositeObject object, vec3 local) {
  vec3 halfExtents = vec3(object.parameters);
  float exact = 0.0f;
  if (isKind(object, kKindCuboid)) exact = cuboidDistance(local, halfExtents);
  if (isKind(object, kKindEllipsoid)) exact = ellipsoidDistance(local, halfExtents);
  precise float scaled = exact * object.axisScale.w;
  return scaled;
}

bool isExact(CompositeObject object) {
  return isKind(object, kKindCuboid) || isKind(object, kKindEllipsoid);
}

bool isSearchedHere(CompositeObject object) {
  return isKind(object, kKindRadius) || (isKind(object, kKindHeightField) && isSearched(object));
}

// Beyond the box: whether the slope at its border is a difference of distances.
bool hasDifferenceSlope(CompositeObject object) {
  return isKind(object, kKindVolume) || isKind(object, kKindVolume8) || isKind(object, kKindHeightField);
}

// Of an object that is searched. Beyond its box it is no nearer than that.
float searchedDistance(CompositeObject object, vec3 local) {
  float found = 0.0f;
  if (isKind(object, kKindRadius)) found = radiusDistance(OVERCAST_FIELDS_HERE object, local);
  if (isKind(object, kKindHeightField)) found = sheetDistance(OVERCAST_FIELDS_HERE object, local);
  precise float phi = found * object.axisScale.w;
  vec3 closest = closestInBox(object, local);
  return local == closest ? phi : max(phi, gapBeyondBox(object, local, closest));
}

// Signed distance in global voxels of the object whose local coordinates are `local` (beyond its box too). A second look for the slope
// is a second turn of one loop: devices that run both sides of every branch take it only where some thread of a group needs it.
float objectDistance(CompositeObject object, vec3 local) {
  if (isExact(object)) return exactDistance(object, local);
  if (isSearchedHere(object)) return searchedDistance(object, local);
  vec3 closest = closestInBox(object, local);
  vec3 direction = outwardStep(local, closest);
  float gap = gapBeyondBox(object, local, closest);
  float phi = 0.0f;
  float slope = 0.0f;
  vec3 at = closest;
  bool wanted;
  int look = 0;
  do {
    precise float found = boxedDistance(object, at) * object.axisScale.w;
    if (look == 0) {
      phi = found;
    } else {
      slope = slopeAlong(object, direction, found, phi);
    }
    wanted = look == 0 && hasDifferenceSlope(object) && gap > 0.0f && phi > 0.0f;
    at = closest - direction;
    ++look;
  } while (wanted);
  return extendedDistance(phi, gap, slope);
}

// A lower and an upper bound of objectDistance, whose growth is bounded (lowerMargin, upperMargin), an upper bound that grows by at most
// 1 (kFarField where there is none), and how far beyond the box the point is (0 where that bounds nothing).
vec4 objectRange(CompositeObject object, vec3 local) {
  if (isExact(object)) return vec4(vec2(exactDistance(object, local)), kFarField, 0.0f);
  vec3 closest = closestInBox(object, local);
  float gap = gapBeyondBox(object, local, closest);
  if (isSearchedHere(object)) {
    vec3 found = vec3(0.0f);
    if (isKind(object, kKindRadius)) found = radiusBounds(OVERCAST_FIELDS_HERE object, local);
    if (isKind(object, kKindHeightField)) found = sheetBounds(OVERCAST_FIELDS_HERE object, local);
    precise vec3 bounds = found * object.axisScale.w;
    return vec4(local == closest ? bounds : max(bounds, vec3(gap)), 0.0f);
  }
  precise float phi = boxedDistance(object, closest) * object.axisScale.w;
  return vec4(extendedDistance(phi, gap, 0.0f), gap + phi, gap + object.more.x, gap);
}

// No point within `radius` of the one with this range is further away.
float farthestWithin(CompositeObject object, vec4 range, float radius) {
  float loose = range.z + radius + object.slack + kRelativeSlack * (abs(range.z) + radius);
  return min(range.y + upperMargin(object, range.y, radius), loose);
}

// None is nearer.
float nearestWithin(CompositeObject object, vec4 range, float radius) {
  float lower = range.x - lowerMargin(object, range.x, radius);
  return range.w > radius ? max(lower, leastBeyondBox(object, range.w, radius)) : lower;
}

ivec3 brickPosition(uint brick) {
  uint row = brick / uint(push.bricks.x);
  return ivec3(brick % uint(push.bricks.x), row % uint(push.bricks.y), row / uint(push.bricks.y));
}

// Corner of a brick in global voxels from the centre of the volume.
vec3 brickCorner(ivec3 brick) {
  return float(kBrickSide) * (vec3(brick) - 0.5f * vec3(push.bricks));
}
