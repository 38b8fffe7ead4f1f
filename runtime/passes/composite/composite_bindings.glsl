// What the cull and the composite shader share: the objects, and an object's distance at a point.
#include "runtime/passes/composite/composite.h"

layout(push_constant) uniform Push {
  CompositePush push;
};
layout(set = 0, binding = 0, std430) readonly buffer Objects {
  CompositeObject objects[];
};
layout(set = 0, binding = 1, std430) buffer Counts {
  uint counts[];
};  // objects in each brick's list, or kBrickOverflow
layout(set = 0, binding = 2, std430) buffer Lists {
  uvec2 lists[];
};  // kBrickCapacity each: object, bits of its lower bound
layout(set = 0, binding = 3, std430) buffer Active {
  uvec4 groups;
  uint activeBricks[];
};  // groups: an indirect dispatch
layout(set = 0, binding = 4) uniform sampler3D atlas;

// Signed distance of the object at p (global voxels from the centre of the volume), in global voxels.
float objectDistance(CompositeObject object, vec3 local) {
  vec3 closest = closestSample(object, local);
  precise float phi = textureLod(atlas, (vec3(object.firstTexel) + closest) * vec3(push.atlasTexel), 0.0f).r * object.axisScale.w;
  return extendedDistance(phi, gapBeyondBox(object, local, closest));
}

ivec3 brickPosition(uint brick) {
  uint row = brick / uint(push.bricks.x);
  return ivec3(brick % uint(push.bricks.x), row % uint(push.bricks.y), row / uint(push.bricks.y));
}

// Corner of a brick in global voxels from the centre of the volume.
vec3 brickCorner(ivec3 brick) {
  return float(kBrickSide) * (vec3(brick) - 0.5f * vec3(push.bricks));
}
