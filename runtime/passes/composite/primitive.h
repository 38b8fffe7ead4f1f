// Primitive: exact distances of cuboids and ellipsoids (DESIGN 5.1 no. 1). Read by C++ and GLSL.
#ifndef RUNTIME_PASSES_COMPOSITE_PRIMITIVE_H
#define RUNTIME_PASSES_COMPOSITE_PRIMITIVE_H

#include "runtime/passes/composite/composite.h"

OVERCAST_SHARED_BEGIN

/// Newton steps of ellipsoidDistance at most; tests/runtime/primitive_test.cpp measures what they leave.
const int kEllipsoidSteps = 10;
/// Bound of the error of ellipsoidDistance relative to the largest half extent plus the distance, where the smallest half extent is at
/// least a thousandth of the largest (measured: 4e-7); thinner ones lose in proportion.
const float kEllipsoidError = 1.0e-6f;

/// Distance to the cuboid [-half, half]; exact.
OVERCAST_INLINE float cuboidDistance(vec3 point, vec3 halfExtents) {
  OVERCAST_PRECISE vec3 beyond = abs(point) - halfExtents;
  vec3 outside = max(beyond, vec3(0.0f));
  OVERCAST_PRECISE float squared = outside.x * outside.x + outside.y * outside.y + outside.z * outside.z;
  OVERCAST_PRECISE float phi = sqrt(squared) + min(max(beyond.x, max(beyond.y, beyond.z)), 0.0f);
  return phi;
}

/// Distance to the ellipsoid with these half extents, the last of them the smallest. In units of it, with u the point and rho the half
/// extents, the closest point is rho_i^2 u_i / d_i, d_i = t + rho_i^2 - 1, where t > 0 is the root of |w| = 1, w_i = rho_i u_i / d_i
/// (Eberly, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid", section 4). Newton's iteration on 1 / |w|, which is
/// concave in t, climbs from below the root and never passes it; nor does the iteration for the first two axes alone, whose root is lower,
/// but which does not creep where d_z is tiny. Where it stops early the Lagrange dual (t - 1)^2 |u / d|^2 + (t - 1) (|w|^2 - 1), a lower
/// bound of the squared distance for every t > 0, is off by the square of what is missing.
OVERCAST_INLINE float ellipsoidDistance(vec3 point, vec3 halfExtents) {
  float smallest = halfExtents.z;
  OVERCAST_PRECISE vec3 rho = halfExtents / smallest;
  // A point on a plane of symmetry may have its closest point off it; slightly off the plane the root exists.
  OVERCAST_PRECISE vec3 u = max(abs(point) / smallest, vec3(1.0e-7f));
  OVERCAST_PRECISE vec3 offset = (rho - vec3(1.0f)) * (rho + vec3(1.0f));
  OVERCAST_PRECISE vec3 start = rho * u - offset;
  OVERCAST_PRECISE float t = max(start.x, max(start.y, start.z));
  OVERCAST_PRECISE vec3 d = offset + vec3(t);
  OVERCAST_PRECISE vec3 w = rho * u / d;
  OVERCAST_PRECISE float two = w.x * w.x + w.y * w.y;
  OVERCAST_PRECISE float all = two + w.z * w.z;
  // Most points are there after three or four; from there on a step changes nothing.
  bool moved = true;
  for (int step = 0; step < kEllipsoidSteps && moved; ++step) {
    float last = t;
    OVERCAST_PRECISE float slope = w.x * w.x / d.x + w.y * w.y / d.y;
    OVERCAST_PRECISE float byTwo = t + (sqrt(two) - 1.0f) * two / slope;
    OVERCAST_PRECISE float byAll = t + (sqrt(all) - 1.0f) * all / (slope + w.z * w.z / d.z);
    t = max(t, max(byTwo, byAll));
    d = offset + vec3(t);
    w = rho * u / d;
    two = w.x * w.x + w.y * w.y;
    all = two + w.z * w.z;
    moved = t > last;
  }
  OVERCAST_PRECISE vec3 g = u / d;
  OVERCAST_PRECISE float s = t - 1.0f;
  OVERCAST_PRECISE float dual = s * (s * (g.x * g.x + g.y * g.y + g.z * g.z) + (all - 1.0f));
  OVERCAST_PRECISE float magnitude = smallest * sqrt(max(dual, 0.0f));
  return s < 0.0f ? -magnitude : magnitude;
}

OVERCAST_SHARED_END

#endif
