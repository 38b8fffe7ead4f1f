// Heightfield: distance of one layer of heights by a search for its closest point, or of two layers back to back, first-order and widened
// by their variance (DESIGN 5.1 no. 3; Evans 2006, section 9.8; formats/heightfield.h says what it means). Read by C++ and GLSL.
//
// Units: the longer side of a texel of the finest level. field: x, y: first texel of the front and the back layer in the fields buffer (y
// is kNoLayer when there is none: a sheet, all coarser levels behind it), z, w: texels along x and y without the gutter of one that
// surrounds them. parameters: x, y: size of a texel, z: of a sheet the least share of the vertical distance that a
// distance is, w: of a sheet the largest height either way.
#ifndef RUNTIME_PASSES_COMPOSITE_HEIGHTFIELD_H
#define RUNTIME_PASSES_COMPOSITE_HEIGHTFIELD_H

#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/fields.h"

OVERCAST_SHARED_BEGIN

/// The share of the distance that texels of the search are wide (kSheetBlur of formats/heightfield.h).
const float kSheetSearchBlur = 0.35f;
const int kLeastSheetSide = 2;  ///< texels along the shorter side of the coarsest level that is searched

/// Weights of a quadratic B-spline's three texels and their derivatives, t in [0, 1] within the middle one.
OVERCAST_INLINE vec3 splineWeights(float t) {
  OVERCAST_PRECISE vec3 weights = vec3(0.5f * (1.0f - t) * (1.0f - t), 0.5f + t * (1.0f - t), 0.5f * t * t);
  return weights;
}
OVERCAST_INLINE vec3 splineSlopes(float t) {
  OVERCAST_PRECISE vec3 slopes = vec3(t - 1.0f, 1.0f - 2.0f * t, t);
  return slopes;
}

/// The surface over a place: its height, its gradient, and 1 + squared slope + squared roughness.
struct HeightLook {
  float height;
  vec2 gradient;
  float steep;
};

/// The quadratic B-spline over the 3 x 3 texels about `place`, from the lowest corner of the rectangle.
OVERCAST_INLINE HeightLook heightLook(OVERCAST_FIELDS uint first, ivec2 size, vec2 texel, vec2 place) {
  OVERCAST_PRECISE vec2 at = place / texel;
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
  OVERCAST_PRECISE float steep = 1.0f + squared.x / (texel.x * texel.x) + squared.y / (texel.y * texel.y) + rough;
  HeightLook look;
  look.height = moments.x;
  look.gradient = rise / texel;
  look.steep = steep;
  return look;
}

/// Length of (across, up).
OVERCAST_INLINE float heightApart(vec2 across, float up) {
  OVERCAST_PRECISE float squared = across.x * across.x + across.y * across.y + up * up;
  return sqrt(squared);
}

/// A level of an object's texels.
struct HeightLevelPlace {
  uint first;
  ivec2 size;
  vec2 texel;
};

OVERCAST_INLINE HeightLevelPlace heightFinest(CompositeObject object) {
  HeightLevelPlace level;
  level.first = object.field.x;
  level.size = ivec2(int(object.field.z), int(object.field.w));
  level.texel = vec2(object.parameters);
  return level;
}

/// The next coarser level; the coarsest itself.
OVERCAST_INLINE HeightLevelPlace heightCoarser(HeightLevelPlace level) {
  if (min(level.size.x, level.size.y) <= kLeastSheetSide) return level;
  HeightLevelPlace next;
  next.first = level.first + uint((level.size.x + 2) * (level.size.y + 2));
  next.size = level.size / 2;
  next.texel = level.texel * 2.0f;
  return next;
}

/// Distance of a sheet anywhere, never negative; no less than the distance to its box where that is known. One look at a level in each
/// turn: below the point, then the finer and the coarser of two levels for each step, then where the last one led. A loop, not a sequence:
/// the shader would hold each look several times.
OVERCAST_INLINE float sheetDistance(OVERCAST_FIELDS CompositeObject object, vec3 local) {
  vec2 corner = vec2(object.boxMin);
  vec2 reach = vec2(object.boxMax) - corner;
  OVERCAST_PRECISE vec2 above = vec2(local) - corner;
  vec2 place = clamp(above, vec2(0.0f), reach);
  HeightLevelPlace level = heightFinest(object);
  float cell = max(level.texel.x, level.texel.y);
  HeightLook fine;
  fine.height = 0.0f;
  fine.gradient = vec2(0.0f);
  fine.steep = 1.0f;
  float height = 0.0f;
  float best = 0.0f;
  float left = 0.0f;
  int turns = 4 * int(object.present);
  for (int turn = 0; turn < turns; ++turn) {
    bool first = turn == 0;
    bool last = turn == turns - 1;
    bool finer = !last && (turn & 1) == 1;
    if (first || last || finer) level = heightFinest(object);
    if (finer) {
      left = log2(max(kSheetSearchBlur * best / cell, 1.0f));
      while (left >= 1.0f && min(level.size.x, level.size.y) > kLeastSheetSide) {
        level = heightCoarser(level);
        left -= 1.0f;
      }
    } else if (!first && !last) {
      level = heightCoarser(level);
    }
    HeightLook look = heightLook(OVERCAST_FIELDS_HERE level.first, level.size, level.texel, place);
    if (first || last) {
      if (first) height = look.height;
      float straight = heightApart(above - place, local.z - look.height);
      best = first ? straight : min(best, straight);
    } else if (finer) {
      fine = look;
    } else {
      // The closest point over the rectangle of the tangent plane.
      OVERCAST_PRECISE vec2 gradient = fine.gradient + left * (look.gradient - fine.gradient);
      OVERCAST_PRECISE float steep = fine.steep + left * (look.steep - fine.steep);
      OVERCAST_PRECISE float tilt = 1.0f + dot(gradient, gradient);
      OVERCAST_PRECISE float behind = local.z - height - dot(gradient, above - place);
      OVERCAST_PRECISE vec2 foot = above + gradient * (behind / tilt);
      foot = clamp(foot, vec2(0.0f), reach);
      OVERCAST_PRECISE float up = local.z - height - dot(gradient, foot - place);
      best = min(best, heightApart(above - foot, up * sqrt(tilt / steep)));
      place = foot;
    }
  }
  return best;
}

/// x, y: a lower and an upper bound of sheetDistance (sheetRange in formats/heightfield.h); z: an upper bound that grows by at most 1.
OVERCAST_INLINE vec3 sheetBounds(OVERCAST_FIELDS CompositeObject object, vec3 local) {
  vec2 corner = vec2(object.boxMin);
  OVERCAST_PRECISE vec2 above = vec2(local) - corner;
  vec2 place = clamp(above, vec2(0.0f), vec2(object.boxMax) - corner);
  OVERCAST_PRECISE vec2 across = above - place;
  ivec2 size = ivec2(int(object.field.z), int(object.field.w));
  float height = heightLook(OVERCAST_FIELDS_HERE object.field.x, size, vec2(object.parameters), place).height;
  float straight = heightApart(across, local.z - height);
  float farthest = max(abs(local.z - object.parameters.w), abs(local.z + object.parameters.w));
  return vec3(object.parameters.z * straight, straight, heightApart(across, farthest));
}

/// z above the layer over `local` over sqrt(1 + squared slope).
OVERCAST_INLINE float heightLayerDistance(OVERCAST_FIELDS CompositeObject object, uint first, vec3 local) {
  ivec2 size = ivec2(int(object.field.z), int(object.field.w));
  OVERCAST_PRECISE vec2 place = vec2(local) - vec2(object.boxMin);
  HeightLook look = heightLook(OVERCAST_FIELDS_HERE first, size, vec2(object.parameters), place);
  OVERCAST_PRECISE float phi = (local.z - look.height) / sqrt(look.steep);
  return phi;
}

/// Distance of a pair at a point of its box.
OVERCAST_INLINE float heightFieldDistance(OVERCAST_FIELDS CompositeObject object, vec3 local) {
  OVERCAST_PRECISE vec3 wall = max(local - vec3(object.boxMax), vec3(object.boxMin) - local);
  OVERCAST_PRECISE float phi = max(wall.x, max(wall.y, wall.z));
  phi = max(phi, heightLayerDistance(OVERCAST_FIELDS_HERE object, object.field.x, local));
  OVERCAST_PRECISE float below = -heightLayerDistance(OVERCAST_FIELDS_HERE object, object.field.y, local);
  return max(phi, below);
}

OVERCAST_SHARED_END

#endif
