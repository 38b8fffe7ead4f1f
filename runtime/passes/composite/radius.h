// Radius: first-order distance of a star shape from its radius over directions (DESIGN 5.1 no. 4; Evans 2006, section 9.8;
// formats/radius.h says what is cut off where and why). Read by C++ and GLSL.
//
// Units: the largest radius of the finest level; the origin is the centre. parameters: x: smallest radius of the level, y: radius of the
// core, z: largest radius of the level. field: x: first texel of the level in the fields buffer (x: radius, y: falloff), laid out as
// RadiusLevel::texel, y: texels along a face.
#ifndef RUNTIME_PASSES_COMPOSITE_RADIUS_H
#define RUNTIME_PASSES_COMPOSITE_RADIUS_H

#include "formats/shared/cube_map.h"
#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/fields.h"

OVERCAST_SHARED_BEGIN

/// Distance of a radius field at a point of its box.
OVERCAST_INLINE float radiusDistance(OVERCAST_FIELDS CompositeObject object, vec3 local) {
  uint face = cubeFace(local);
  int side = int(object.field.y);
  OVERCAST_PRECISE vec2 at = (cubeCoordinates(face, local) * 0.5f + 0.5f) * float(side - 1);
  ivec2 cell = clamp(ivec2(at), ivec2(0), ivec2(side - 2));
  OVERCAST_PRECISE vec2 t = at - vec2(cell);
  uint row = object.field.x + uint(cell.x + side * (cell.y + side * int(face)));
  uint next = row + uint(side);
  OVERCAST_PRECISE vec2 low = fields[row] * (1.0f - t.x) + fields[row + 1u] * t.x;
  OVERCAST_PRECISE vec2 high = fields[next] * (1.0f - t.x) + fields[next + 1u] * t.x;
  OVERCAST_PRECISE vec2 here = low * (1.0f - t.y) + high * t.y;

  float smallest = object.parameters.x;
  float core = object.parameters.y;
  OVERCAST_PRECISE float squared = local.x * local.x + local.y * local.y + local.z * local.z;
  float rho = sqrt(squared);
  float s = max(rho, core);
  OVERCAST_PRECISE float first = (s - here.x) * here.y;
  OVERCAST_PRECISE float phi = min(max(first, max(-smallest - s, s - object.parameters.z)), s - smallest);
  OVERCAST_PRECISE float blended = (phi + smallest) * min(rho / core, 1.0f) - smallest;
  return blended;
}

/// Cosine of the angle between the gap beyond the box and the direction from the centre, as they are in global voxels.
OVERCAST_INLINE float radiusSlope(CompositeObject object, vec3 local, vec3 closest) {
  OVERCAST_PRECISE vec3 gap = (local - closest) * vec3(object.axisScale);
  OVERCAST_PRECISE vec3 outward = closest * vec3(object.axisScale);
  OVERCAST_PRECISE float cosine = dot(gap, outward) / sqrt(dot(gap, gap) * dot(outward, outward));
  return cosine;
}

OVERCAST_SHARED_END

#endif
