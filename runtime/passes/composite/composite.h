// Composite: phi = min over objects into the global volume (DESIGN 5.1, 5.2; Evans 2006, 9.8). Read by C++ and GLSL.
//
// Units: the global volume holds signed distances in global voxels (negative inside), so that half floats are best near surfaces whatever
// the scale of the scene. Points p are in global voxels from the centre of the volume. Each kind of object has units of its own (a volume's
// are its voxels); its record says how they become global voxels. How a kind evaluates its distance is in <kind>.h beside this file.
#ifndef RUNTIME_PASSES_COMPOSITE_COMPOSITE_H
#define RUNTIME_PASSES_COMPOSITE_COMPOSITE_H

#include "runtime/shared_types.h"

OVERCAST_SHARED_BEGIN

const int kBrickSide = 8;                 ///< voxels along the side of a brick
const int kOctantSide = 4;                ///< of one of the 8 octants of a brick
const int kBrickCapacity = 128;           ///< objects a brick's list can hold: the bits of one uvec4
const uint kBrickOverflow = 0xffffffffu;  ///< count of a brick whose list did not fit: it evaluates every object
const float kFarField = 65504.0f;         ///< distance, in voxels, where there is no object; the largest half float

const uint kNoLayer = 0xffffffffu;  ///< field.y of a heightfield without a back layer

/// Half diagonals, in voxels, of the voxel centres of a brick and of an octant about its centre: 3.5 and 1.5 sqrt(3), rounded up.
const float kBrickRadius = 6.0621783f;
const float kOctantRadius = 2.5980765f;

/// Allowance of the culling margin for hardware that rounds a filtered value to a half float, twice: at the brick's centre and at the
/// voxel.
const float kRelativeSlack = 0.001953125f;

/// Kinds of objects. Of all but primitives the distance is known within the box and continued beyond it.
const uint kKindVolume = 0u;       ///< parameters: xyz: centre of the first sample in the atlas, texels. Units: voxels; boxMin is 0
const uint kKindCuboid = 1u;       ///< parameters: xyz: half extents. Units: global voxels, or local ones where the transform shears
const uint kKindEllipsoid = 2u;    ///< parameters: xyz: half extents, z the smallest. Units: global voxels
const uint kKindRadius = 3u;       ///< see radius.h
const uint kKindHeightField = 4u;  ///< parameters: xy: size of a texel; field: see heightfield.h. Units: the longer side of a finest texel
const uint kKindVolume8 = 5u;      ///< as kKindVolume, in the atlas of 8 bits

/// One object as the GPU sees it. Local coordinates are in the kind's units.
struct CompositeObject {
  vec4 rowX;        //   0: local coordinate x = dot(rowX.xyz, p) + rowX.w
  vec4 rowY;        //  16
  vec4 rowZ;        //  32
  vec4 axisScale;   //  48: global voxels per unit: xyz of gaps beyond the box along its axes, w of stored distances (sigma_min)
  vec4 boxMin;      //  64: xyz: lowest corner of the box, local; w: lowest distance on its border in global voxels, at most 0
  vec4 boxMax;      //  80: xyz: highest corner; w: lipschitz bound of the distance's lower bound, global voxel per global voxel
  vec4 parameters;  //  96: by kind
  vec4 more;        // 112: x: of a kind known within its box alone: no distance in it is above this, global voxels
  uvec4 field;      // 128: by kind: where its texels are in the fields buffer (x: index of the first) and how many
  float slack;      // 144: bound of the error of two evaluations (filtering, rounding), global voxels
  uint kind;        // 148
  uint present;     // 152: 0: takes no part
  uint moved;       // 156: differs from the last composited frame
};

struct CompositePush {
  ivec4 bricks;     //  0: xyz: bricks along the sides of the volume, w: number of objects
  vec4 atlasTexel;  // 16: xyz: 1 / extent of the atlas of floats
  vec4 texel8;      // 32: xyz: 1 / extent of the atlas of 8 bits
  uint everything;  // 48: 1: composite all bricks whatever moved
};

/// Local coordinates of the point p.
OVERCAST_INLINE vec3 localPoint(CompositeObject object, vec3 p) {
  OVERCAST_PRECISE vec3 local =
      vec3(dot(vec3(object.rowX), p) + object.rowX.w, dot(vec3(object.rowY), p) + object.rowY.w, dot(vec3(object.rowZ), p) + object.rowZ.w);
  return local;
}

/// The point of the object's box that is closest to `local`.
OVERCAST_INLINE vec3 closestInBox(CompositeObject object, vec3 local) {
  return clamp(local, vec3(object.boxMin), vec3(object.boxMax));
}

/// Distance from the box in global voxels: exact where the transform keeps the box's axes orthogonal, else a lower bound.
OVERCAST_INLINE float gapBeyondBox(CompositeObject object, vec3 local, vec3 closest) {
  OVERCAST_PRECISE vec3 gap = (local - closest) * vec3(object.axisScale);
  OVERCAST_PRECISE float squared = dot(gap, gap);
  return sqrt(squared);
}

/// From the box towards a point beyond it: along the direction in which `local` sees `closest`, one unit along its longest component.
OVERCAST_INLINE vec3 outwardStep(vec3 local, vec3 closest) {
  OVERCAST_PRECISE vec3 beyond = local - closest;
  float longest = max(abs(beyond.x), max(abs(beyond.y), abs(beyond.z)));
  OVERCAST_PRECISE vec3 direction = beyond / longest;
  return direction;
}

/// Derivative of the distance along a step that brings it from `inner` to `phi` (global voxels), the step as it is in global voxels.
OVERCAST_INLINE float slopeAlong(CompositeObject object, vec3 direction, float inner, float phi) {
  OVERCAST_PRECISE vec3 step = direction * vec3(object.axisScale);
  OVERCAST_PRECISE float squared = dot(step, step);
  OVERCAST_PRECISE float slope = (phi - inner) / sqrt(squared);
  return slope;
}

/// Signed distance from a point `gap` beyond the box whose closest point of the box has the distance `phi`, all in global voxels, when phi
/// grows by `slope` towards the point. The surface lies at phi from the box along its gradient: by the law of cosines
/// sqrt(gap^2 + phi^2 + 2 gap phi slope). Between the bounds of DESIGN 5.1, which slopes of 0 (the lower) and 1 (gap + phi) give.
/// Continuous at the box and at phi = 0.
OVERCAST_INLINE float extendedDistance(float phi, float gap, float slope) {
  OVERCAST_PRECISE float squared = gap * gap + phi * phi + 2.0f * gap * phi * clamp(slope, 0.0f, 1.0f);
  OVERCAST_PRECISE float inside = gap + phi;
  return gap > 0.0f ? (phi < 0.0f ? inside : sqrt(squared)) : phi;
}

/// Whether the object's distance is known everywhere, not only within its box.
OVERCAST_INLINE bool exactEverywhere(CompositeObject object) {
  return object.kind == kKindCuboid || object.kind == kKindEllipsoid;
}

/// Whether the object's distance is the result of a search for its closest point (radius.h, heightfield.h): known everywhere, and between
/// bounds whose growth is known, which for its own growth is not.
OVERCAST_INLINE bool isSearched(CompositeObject object) {
  return object.kind == kKindRadius || (object.kind == kKindHeightField && object.field.y == kNoLayer);
}

/// What `lower`, a lower bound of the object's distance at the centre, has to lose to be one everywhere within `radius` voxels: the
/// Lipschitz bound over the radius and what two evaluations may be off. A search finds nothing nearer than there is: where all points are
/// outside, it is never further off than they are apart.
OVERCAST_INLINE float lowerMargin(CompositeObject object, float lower, float radius) {
  float reach = isSearched(object) && lower > radius ? radius : object.boxMax.w * radius;
  return reach + object.slack + kRelativeSlack * (abs(lower) + reach);
}

/// What `upper` has to gain to be an upper bound everywhere within `radius` voxels. Beyond the box gap + phi grows by 1 along the gap and
/// at a right angle to it by the slope of phi. Keep object i only if lower_i - margin_i <= min over j of (upper_j + margin_j).
OVERCAST_INLINE float upperMargin(CompositeObject object, float upper, float radius) {
  float slope = object.boxMax.w;
  float reach = (exactEverywhere(object) || isSearched(object) ? slope : sqrt(1.0f + slope * slope)) * radius;
  return reach + object.slack + kRelativeSlack * (abs(upper) + reach);
}

/// Of an object known within its box alone: a lower bound everywhere within `radius` voxels of a point `gap` voxels beyond the box, which
/// must be more than `radius`. It does not depend on how steep the distance is within.
OVERCAST_INLINE float leastBeyondBox(CompositeObject object, float gap, float radius) {
  return gap + object.boxMin.w - radius - object.slack - kRelativeSlack * (gap + abs(object.boxMin.w) + radius);
}

OVERCAST_SHARED_END

#endif
