// Radius: distance of a star shape from its radius over directions (DESIGN 5.1 no. 4; Evans 2006, section 9.8; sampleRadius in
// formats/radius.h says how the closest point is searched and what is known for sure). Read by C++ and GLSL.
//
// Units: the largest radius of the finest level; the origin is the centre. parameters: x: smallest radius of the level, y: radius of the
// core, z: largest radius of the level, w: least share of |v| that a distance is. field: x: first element of the level in the fields
// buffer, two for each texel: (radius, slope x), (slope y, slope z); laid out as RadiusLevel::texel, all coarser levels behind it; y:
// texels along a face.
#ifndef RUNTIME_PASSES_COMPOSITE_RADIUS_H
#define RUNTIME_PASSES_COMPOSITE_RADIUS_H

#include "formats/shared/cube_map.h"
#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/fields.h"

OVERCAST_SHARED_BEGIN

/// The share of the distance that texels of the search are wide (kRadiusBlur of formats/radius.h).
const float kRadiusSearchBlur = 0.25f;

/// Radius and slope (per radian) of a level in a direction.
struct RadiusLook {
  float mean;
  vec3 slope;
};

/// Bilinear interpolation in the level whose texels start at `first`.
OVERCAST_INLINE RadiusLook radiusLook(OVERCAST_FIELDS uint first, int side, vec3 direction) {
  uint face = cubeFace(direction);
  OVERCAST_PRECISE vec2 at = (cubeCoordinates(face, direction) * 0.5f + 0.5f) * float(side - 1);
  ivec2 cell = clamp(ivec2(at), ivec2(0), ivec2(side - 2));
  OVERCAST_PRECISE vec2 t = at - vec2(cell);
  uint row = first + 2u * uint(cell.x + side * (cell.y + side * int(face)));
  uint next = row + 2u * uint(side);
  OVERCAST_PRECISE vec2 lowA = fields[row] * (1.0f - t.x) + fields[row + 2u] * t.x;
  OVERCAST_PRECISE vec2 lowB = fields[row + 1u] * (1.0f - t.x) + fields[row + 3u] * t.x;
  OVERCAST_PRECISE vec2 highA = fields[next] * (1.0f - t.x) + fields[next + 2u] * t.x;
  OVERCAST_PRECISE vec2 highB = fields[next + 1u] * (1.0f - t.x) + fields[next + 3u] * t.x;
  OVERCAST_PRECISE vec2 a = lowA * (1.0f - t.y) + highA * t.y;
  OVERCAST_PRECISE vec2 b = lowB * (1.0f - t.y) + highB * t.y;
  RadiusLook look;
  look.mean = a.x;
  look.slope = vec3(a.y, b.x, b.y);
  return look;
}

/// The point at least as far out as the core that stands for `local`; its distance from the centre is max(|local|, core).
OVERCAST_INLINE vec3 radiusOutside(vec3 local, float rho, float s) {
  return rho > 0.0f ? local * (s / rho) : vec3(s, 0.0f, 0.0f);
}

/// A value at distance s from the centre within what solids between the two spheres allow, drawn out to the centre.
OVERCAST_INLINE float radiusSettled(CompositeObject object, float rho, float s, float value) {
  float smallest = object.parameters.x;
  OVERCAST_PRECISE float phi = min(max(value, max(-smallest - s, s - object.parameters.z)), s - smallest);
  OVERCAST_PRECISE float blended = (phi + smallest) * min(rho / object.parameters.y, 1.0f) - smallest;
  return blended;
}

/// Distance of a radius field anywhere; no less than the distance to its box where that is known. One look at a level in each turn: towards
/// the point, at the finer and at the coarser of two blurred levels, then where the step led. A loop, not a sequence: the shader
/// would hold each look several times.
OVERCAST_INLINE float radiusDistance(OVERCAST_FIELDS CompositeObject object, vec3 local) {
  float rho = sqrt(dot(local, local));
  float s = max(rho, object.parameters.y);
  vec3 p = radiusOutside(local, rho, s);
  vec3 direction = p / s;
  uint start = object.field.x;
  int side = int(object.field.y);
  float texel = 1.5707963f / float(side - 1);
  RadiusLook fine;
  fine.mean = 0.0f;
  fine.slope = vec3(0.0f);
  float v = 0.0f;
  float best = 0.0f;
  float left = 0.0f;
  int turns = 4 * int(object.present);
  for (int turn = 0; turn < turns; ++turn) {
    bool first = turn == 0;
    bool last = turn == turns - 1;
    bool finer = !last && (turn & 1) == 1;
    if (first || last || finer) {
      start = object.field.x;
      side = int(object.field.y);
    }
    if (finer) {
      left = log2(max(kRadiusSearchBlur * best / (s * texel), 1.0f));
      while (left >= 1.0f && side > 2) {
        start += 12u * uint(side * side);
        side /= 2;
        left -= 1.0f;
      }
    } else if (!first && !last && side > 2) {
      start += 12u * uint(side * side);
      side /= 2;
    }
    RadiusLook look = radiusLook(OVERCAST_FIELDS_HERE start, side, direction);
    if (first) {
      v = s - look.mean;
      best = abs(v);
    } else if (last) {
      OVERCAST_PRECISE vec3 apart = p - look.mean * direction;
      best = min(best, sqrt(dot(apart, apart)));
    } else if (finer) {
      fine = look;
    } else {
      OVERCAST_PRECISE float mean = fine.mean + left * (look.mean - fine.mean);
      OVERCAST_PRECISE vec3 slope = fine.slope + left * (look.slope - fine.slope);
      OVERCAST_PRECISE float steep = 1.0f + dot(slope, slope) / (mean * s);
      best = best / sqrt(steep);
      // Newton's step of |p - r d|^2 over directions.
      OVERCAST_PRECISE vec3 g = slope - direction * dot(slope, direction);
      OVERCAST_PRECISE vec3 moved = direction + g * ((s - mean) / (mean * s + dot(g, g)));
      direction = moved / sqrt(dot(moved, moved));
    }
  }
  best = max(best, object.parameters.w * abs(v));
  return radiusSettled(object, rho, s, v < 0.0f ? -best : best);
}

/// x, y: a lower and an upper bound of radiusDistance (radiusRange in formats/radius.h); z: an upper bound that grows by at most 1.
OVERCAST_INLINE vec3 radiusBounds(OVERCAST_FIELDS CompositeObject object, vec3 local) {
  float rho = sqrt(dot(local, local));
  float s = max(rho, object.parameters.y);
  vec3 p = radiusOutside(local, rho, s);
  OVERCAST_PRECISE float v = s - radiusLook(OVERCAST_FIELDS_HERE object.field.x, int(object.field.y), p).mean;
  OVERCAST_PRECISE float least = object.parameters.w * v;
  float low = radiusSettled(object, rho, s, v > 0.0f ? least : v);
  float high = radiusSettled(object, rho, s, v > 0.0f ? v : least);
  return vec3(low, high, rho - object.parameters.x);
}

OVERCAST_SHARED_END

#endif
