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

// Distance at a point of the object's box, in the kind's units. One line per kind.
float boxedDistance(CompositeObject object, vec3 local) {
  if (object.kind == kKindRadius) return radiusDistance(OVERCAST_FIELDS_HERE object, local);
  if (object.kind == kKindHeightField) return heightFieldDistance(OVERCAST_FIELDS_HERE object, local);
  if (object.kind == kKindVolume8) return volume8Distance(object, local);
  return volumeDistance(object, local);
}

float exactDistance(CompositeObject object, vec3 local) {
  precise float exact = primitiveDistance(object, local) * object.axisScale.w;
  return exact;
}

// Signed distance in global voxels of the object whose local coordinates are `local` (beyond its box too).
float objectDistance(CompositeObject object, vec3 local) {
  if (exactEverywhere(object)) return exactDistance(object, local);
  vec3 closest = closestInBox(object, local);
  precise float phi = boxedDistance(object, closest) * object.axisScale.w;
  float gap = gapBeyondBox(object, local, closest);
  float slope = 0.0f;
  if ((isVolume(object) || object.kind == kKindHeightField) && gap > 0.0f && phi > 0.0f) {
    vec3 direction = outwardStep(local, closest);
    precise float inner = boxedDistance(object, closest - direction) * object.axisScale.w;
    slope = slopeAlong(object, direction, inner, phi);
  }
  if (object.kind == kKindRadius && gap > 0.0f) slope = radiusSlope(object, local, closest);
  return extendedDistance(phi, gap, slope);
}

// A lower and an upper bound of objectDistance, whose growth is bounded (lowerMargin, upperMargin).
vec2 objectRange(CompositeObject object, vec3 local) {
  if (exactEverywhere(object)) return vec2(exactDistance(object, local));
  vec3 closest = closestInBox(object, local);
  precise float phi = boxedDistance(object, closest) * object.axisScale.w;
  float gap = gapBeyondBox(object, local, closest);
  return vec2(extendedDistance(phi, gap, 0.0f), gap + phi);
}

ivec3 brickPosition(uint brick) {
  uint row = brick / uint(push.bricks.x);
  return ivec3(brick % uint(push.bricks.x), row % uint(push.bricks.y), row / uint(push.bricks.y));
}

// Corner of a brick in global voxels from the centre of the volume.
vec3 brickCorner(ivec3 brick) {
  return float(kBrickSide) * (vec3(brick) - 0.5f * vec3(push.bricks));
}
