// Heightfield: first-order distance of one or two layers of heights, widened by their variance (DESIGN 5.1 no. 3; Evans 2006, section 9.8;
// formats/heightfield.h says what it means). Read by C++ and GLSL.
//
// Units: the longer side of a texel of the finest level. field: x, y: first texel of the front and the back layer in the fields buffer (y
// is kNoLayer when there is none), z, w: texels along x and y without the gutter of one that surrounds them. parameters: x, y: size of a
// texel.
#ifndef RUNTIME_PASSES_COMPOSITE_HEIGHTFIELD_H
#define RUNTIME_PASSES_COMPOSITE_HEIGHTFIELD_H

#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/fields.h"

OVERCAST_SHARED_BEGIN

const uint kNoLayer = 0xffffffffu;

/// Weights of a quadratic B-spline's three texels and their derivatives, t in [0, 1] within the middle one.
OVERCAST_INLINE vec3 splineWeights(float t) {
  OVERCAST_PRECISE vec3 weights = vec3(0.5f * (1.0f - t) * (1.0f - t), 0.5f + t * (1.0f - t), 0.5f * t * t);
  return weights;
}
OVERCAST_INLINE vec3 splineSlopes(float t) {
  OVERCAST_PRECISE vec3 slopes = vec3(t - 1.0f, 1.0f - 2.0f * t, t);
  return slopes;
}

/// z above the layer over `local` over sqrt(1 + squared slope).
OVERCAST_INLINE float heightLayerDistance(OVERCAST_FIELDS CompositeObject object, uint first, vec3 local) {
  vec2 texel = vec2(object.parameters);
  ivec2 size = ivec2(int(object.field.z), int(object.field.w));
  OVERCAST_PRECISE vec2 at = (vec2(local) - vec2(object.boxMin)) / texel;
  ivec2 cell = clamp(ivec2(floor(at)), ivec2(0), size - 1);
  OVERCAST_PRECISE vec2 t = at - vec2(cell);
  vec3 weightX = splineWeights(t.x);
  vec3 weightY = splineWeights(t.y);
  vec3 slopeX = splineSlopes(t.x);
  vec3 slopeY = splineSlopes(t.y);
  OVERCAST_PRECISE vec2 moments = vec2(0.0f);
  OVERCAST_PRECISE vec2 rise = vec2(0.0f);
  for (int j = 0; j < 3; ++j) {
    uint row = first + uint(cell.x + (cell.y + j) * (size.x + 2));
    vec2 a = fields[row];
    vec2 b = fields[row + 1u];
    vec2 c = fields[row + 2u];
    OVERCAST_PRECISE vec2 along = weightX.x * a + weightX.y * b + weightX.z * c;
    OVERCAST_PRECISE float across = slopeX.x * a.x + slopeX.y * b.x + slopeX.z * c.x;
    moments = moments + weightY[j] * along;
    rise = rise + vec2(weightY[j] * across, slopeY[j] * along.x);
  }
  OVERCAST_PRECISE vec2 squared = rise * rise;
  OVERCAST_PRECISE float rough = max(12.0f * moments.y - squared.x - squared.y, 0.0f) / (texel.x * texel.y);
  OVERCAST_PRECISE float slope2 = squared.x / (texel.x * texel.x) + squared.y / (texel.y * texel.y) + rough;
  OVERCAST_PRECISE float phi = (local.z - moments.x) / sqrt(1.0f + slope2);
  return phi;
}

/// Distance of a heightfield at a point of its box.
OVERCAST_INLINE float heightFieldDistance(OVERCAST_FIELDS CompositeObject object, vec3 local) {
  OVERCAST_PRECISE vec3 wall = max(local - vec3(object.boxMax), vec3(object.boxMin) - local);
  OVERCAST_PRECISE float phi = max(wall.x, max(wall.y, wall.z));
  phi = max(phi, heightLayerDistance(OVERCAST_FIELDS_HERE object, object.field.x, local));
  if (object.field.y == kNoLayer) return phi;
  OVERCAST_PRECISE float below = -heightLayerDistance(OVERCAST_FIELDS_HERE object, object.field.y, local);
  return max(phi, below);
}

OVERCAST_SHARED_END

#endif
