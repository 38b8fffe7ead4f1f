// Caps: areas, overlaps and cosine integrals of spherical caps in single floats (Oat and Sander 2006, section 8.4; DESIGN 5.5). Read by C++
// and GLSL.
//
// A cap is a unit axis and a radius, an angle in [0, pi/2]; d is the angle between two axes. Areas are solid angles. Nothing here depends
// on how well a device evaluates sines and arc tangents (Vulkan promises little): the polynomials are ours. tests/runtime/caps_test.cpp
// holds the errors stated here against numerical integration in long double; `./run caps` prints them.
#ifndef RUNTIME_PASSES_APERTURE_CAPS_H
#define RUNTIME_PASSES_APERTURE_CAPS_H

#include "runtime/shared_types.h"

OVERCAST_SHARED_BEGIN

const float kCapPi = 3.14159265f;
const float kCapRightAngle = 1.57079633f;
const float kCapTiny = 1.0e-30f;  ///< stands in for divisors of 0, whose dividends are 0 as well

/// sin x for x in [0, pi/2], relative error 1e-7 (Abramowitz and Stegun 4.3.97).
OVERCAST_INLINE float capSine(float x) {
  float w = x * x;
  return x * (1.0f + w * (-0.1666666664f + w * (0.0083333315f + w * (-0.0001984090f + w * (0.0000027526f - w * 0.0000000239f)))));
}

/// sin x for x in [-pi, pi], absolute error 3e-7.
OVERCAST_INLINE float capSineAround(float x) {
  float size = abs(x);
  float s = capSine(max(min(size, kCapPi - size), 0.0f));
  return x < 0.0f ? -s : s;
}

/// Angle in [0, pi] of the point (x, y), y >= 0; 0 for the origin. Relative error 2e-7 (Abramowitz and Stegun 4.4.49).
OVERCAST_INLINE float capAngle(float y, float x) {
  float size = abs(x);
  float t = min(size, y) / max(max(size, y), kCapTiny);
  float w = t * t;
  float high = 0.1065626393f + w * (-0.0752896400f + w * (0.0429096138f + w * (-0.0161657367f + w * 0.0028662257f)));
  float angle = t * (1.0f + w * (-0.3333314528f + w * (0.1999355085f + w * (-0.1420889944f + w * high))));
  angle = y > size ? kCapRightAngle - angle : angle;
  return x < 0.0f ? kCapPi - angle : angle;
}

/// Angle between two vectors of any length, precise for small angles too; 0 where one is zero.
OVERCAST_INLINE float capDistance(vec3 a, vec3 b) {
  return capAngle(length(cross(a, b)), dot(a, b));
}

/// 1 - cos r, relative error 1e-7.
OVERCAST_INLINE float capHeight(float r) {
  float s = capSine(0.5f * r);
  return 2.0f * s * s;
}

OVERCAST_INLINE float capArea(float r) {
  return 2.0f * kCapPi * capHeight(r);
}

/// Half angles, seen from the own axis, of the part of each border that lies in the other cap: x of the first's, y of the second's. A cap
/// within the other has pi and leaves that 0; of equal caps the second is within the first; disjoint caps have 0 both.
/// With the half-perimeter s of the triangle of sides r0, r1, d: tan(angle_i / 2) = sqrt(sin(s - r0) sin(s - r1) sin(s - d) / sin s)
/// / sin(s - the side opposite). The differences are formed from the inputs, the larger radius first against d, where they are exact.
OVERCAST_INLINE vec2 capHalfAngles(float r0, float r1, float d) {
  float wide = max(r0, r1);
  float small = min(r0, r1);
  float past = d - wide;
  float fromSmall = 0.5f * (past + small);
  float fromWide = 0.5f * (d + (wide - small));
  float overlap = 0.5f * (small - past);
  if (overlap <= 0.0f) return vec2(0.0f);
  if (fromSmall <= 0.0f) return r0 < r1 ? vec2(kCapPi, 0.0f) : vec2(0.0f, kCapPi);
  float perimeter = 0.5f * ((wide + small) + d);
  float sineWide = capSine(min(fromWide, kCapRightAngle));
  float sineSmall = capSine(fromSmall);
  float sinePerimeter = capSine(clamp(min(perimeter, kCapPi - perimeter), overlap, kCapRightAngle));
  float inner = sqrt(sineSmall * capSine(overlap) * (sineWide / sinePerimeter));
  float ofWide = 2.0f * capAngle(inner, sineWide);
  float ofSmall = 2.0f * capAngle(inner, sineSmall);
  return r0 < r1 ? vec2(ofSmall, ofWide) : vec2(ofWide, ofSmall);
}

/// Area between the border of a cap of height h = 1 - cos r, over +-angle of it, and the great circle through the ends of that arc: the
/// sector less its triangle, 2 (h angle - atan(h sin cos / (1 - h sin^2))). For small angles, where both are nearly the same, from
/// 2 (atan(c t) - c atan t), c = cos r, t = tan(angle), by its series.
OVERCAST_INLINE float capSegment(float h, float angle) {
  float sine = capSine(0.5f * angle);
  float cosine = capSine(kCapRightAngle - 0.5f * angle);
  float s = 2.0f * sine * cosine;
  float c = 1.0f - 2.0f * sine * sine;
  if (angle < 0.1f) {
    float t = s / c;
    float w = t * t;
    float k = (1.0f - h) * (1.0f - h);
    float rest = 1.0f / 3.0f - w * ((1.0f + k) / 5.0f - w * ((1.0f + k + k * k) / 7.0f));
    return 2.0f * (1.0f - h) * h * (2.0f - h) * t * w * rest;
  }
  float triangle = capAngle(abs(h * s * c), 1.0f - h * s * s);
  return 2.0f * (h * angle - (c < 0.0f ? -triangle : triangle));
}

/// Half the spherical excess of the two triangles of sides r0, r1, d: what two sectors that cover them have in excess of their union.
OVERCAST_INLINE float capExcess(float r0, float d, float angle0) {
  float sine = capSine(0.5f * angle0);
  float cosine = capSine(kCapRightAngle - 0.5f * angle0);
  float sines = capSine(0.5f * r0) * capSine(0.5f * d);
  float cosines = capSine(kCapRightAngle - 0.5f * r0) * capSine(max(kCapRightAngle - 0.5f * d, 0.0f));
  return 2.0f * capAngle(sines * 2.0f * sine * cosine, cosines + sines * (1.0f - 2.0f * sine * sine));
}

/// Area of the intersection: both sectors less their triangles, 2 (h0 angle0 + h1 angle1 - excess). Where the wider cap's angle is small
/// these nearly cancel: there the two segments that the common chord, a great circle, cuts off. Error at most 1e-5 of the smaller cap.
OVERCAST_INLINE float capIntersection(float r0, float r1, float d) {
  vec2 angles = capHalfAngles(r0, r1, d);
  float h0 = capHeight(r0);
  float h1 = capHeight(r1);
  float whole = 2.0f * kCapPi * min(h0, h1);
  if (max(angles.x, angles.y) >= kCapPi) return whole;
  float area = 0.0f;
  if (min(angles.x, angles.y) < 0.1f) {
    area = capSegment(h0, angles.x) + capSegment(h1, angles.y);
  } else {
    area = 2.0f * (h0 * angles.x + h1 * angles.y - capExcess(r0, d, angles.x));
  }
  return clamp(area, 0.0f, whole);
}

/// The paper's approximation, as its listing 1 has it: off by up to 0.16 of the smaller cap.
OVERCAST_INLINE float capIntersectionSmoothstep(float r0, float r1, float d) {
  float area = 0.0f;
  float small = min(r0, r1);
  if (d <= max(r0, r1) - small) {
    area = 6.283185308f - 6.283185308f * cos(small);
  } else if (d < r0 + r1) {
    float difference = abs(r0 - r1);
    area = smoothstep(0.0f, 1.0f, 1.0f - clamp((d - difference) / (r0 + r1 - difference), 0.0f, 1.0f));
    area *= 6.283185308f - 6.283185308f * cos(small);
  }
  return area;
}

/// Ours, off by at most 0.014 of the smaller cap. With x = 1 where the smaller cap just fits into the other and 0 where they part, the
/// share of the smaller cap is x + x (1 - x) (q (x - 1/2) - c): q is how far it swings about the diagonal, c how far it sags because the
/// wider cap's border is curved. Both follow from how the radii compare (m/M) and how large the wider one is (M^2), fitted to the exact
/// area over all caps. The area of the smaller cap is a polynomial within 8e-5, without the cancellation of 1 - cos.
OVERCAST_INLINE float capIntersectionFast(float r0, float r1, float d) {
  float small = min(r0, r1);
  float wide = max(r0, r1);
  float inverse = 1.0f / max(small * wide, kCapTiny);
  float x = clamp((0.5f * inverse) * wide * (small + (wide - d)), 0.0f, 1.0f);
  float square = small * small;
  float ratio = square * inverse;
  float wide2 = wide * wide;
  float q = 1.30175f - ratio * ratio * (0.73983f + 0.07427f * wide2 * wide2);
  float c = ratio * (0.43958f - 0.16646f * wide2);
  float share = x + x * (1.0f - x) * (q * (x - 0.5f) - c);
  return share * kCapPi * square * (1.0f + square * (-0.0833036147f + square * 0.00265636133f));
}

/// Unit vector to about the centre of the intersection. On the great circle through both axes the intersection reaches from the wider
/// cap's border to the smaller one's; its middle is the centre for equal caps and where one holds the other, and 3/10 of the way too far
/// out where the wider border is straight.
OVERCAST_INLINE vec3 capCentroid(vec3 axis0, float r0, vec3 axis1, float r1, float d) {
  bool first = r0 < r1;
  float small = min(r0, r1);
  float wide = max(r0, r1);
  float middle = clamp(0.5f * (d - (wide - small)), 0.0f, small);
  float way = middle * (1.0f - 0.3f * (small - middle) * (wide - small) / max(small * wide, kCapTiny));
  float rest = capSineAround(d - way);
  vec3 sum = first ? rest * axis0 + capSine(way) * axis1 : rest * axis1 + capSine(way) * axis0;
  float squared = dot(sum, sum);
  return squared > 0.0f ? sum / sqrt(squared) : (first ? axis0 : axis1);
}

/// Length (x) and integral of the cosine (y) over the angles in [-reach, reach] that lie within `width` of `middle`, which is in [0, pi].
OVERCAST_INLINE vec2 capArcs(float reach, float middle, float width) {
  float low = max(-reach, middle - width);
  float high = max(min(reach, middle + width), low);
  float around = max(middle + width - 2.0f * kCapPi, -reach);
  float cosines = capSineAround(high) - capSineAround(low) + (capSineAround(around) + capSineAround(reach));
  return vec2(high - low + (around + reach), cosines);
}

/// Tangent at `axis` towards `to`, as long as the sine of their angle.
OVERCAST_INLINE vec3 capTangent(vec3 axis, vec3 to) {
  return to - dot(axis, to) * axis;
}

/// What the border of a cap contributes to the cosine integral: over the part of it within +-`above` of the direction to the normal and
/// within `width` of `middle`. n . (1/2 times the integral of w x dw) (Lambert's formula for a circular arc).
OVERCAST_INLINE float capBorder(vec3 normal, vec3 axis, float r, float above, float middle, float width) {
  vec2 arcs = capArcs(above, middle, width);
  float sine = capSine(r);
  float up = dot(normal, axis);
  return 0.5f * sine * (sine * up * arcs.x - (1.0f - capHeight(r)) * sqrt(max(1.0f - up * up, 0.0f)) * arcs.y);
}

/// Integral of max(0, normal . w) over a cap; closed form, also across the horizon. pi for the hemisphere about the normal.
OVERCAST_INLINE float capCosine(vec3 normal, vec3 axis, float r) {
  vec2 horizon = capHalfAngles(r, kCapRightAngle, capDistance(axis, normal));
  return max(capBorder(normal, axis, r, horizon.x, 0.0f, kCapPi) + horizon.y, 0.0f);
}

/// Below this radius a cap is one direction to the cosine: the error, the square of it, is then smaller than what cancels in the borders.
const float kCapPoint = 0.004f;

/// Integral of max(0, normal . w) over the intersection of two caps; closed form: its border is made of arcs of both caps and of the
/// horizon. `area` is that of the intersection, d the distance of the axes. Error at most 5e-4 of the smaller cap.
OVERCAST_INLINE float capIntersectionCosine(vec3 normal, vec3 axis0, float r0, vec3 axis1, float r1, float d, float area) {
  if (area <= 0.0f) return 0.0f;
  if (min(r0, r1) < kCapPoint) return area * max(dot(normal, capCentroid(axis0, r0, axis1, r1, d)), 0.0f);
  vec2 both = capHalfAngles(r0, r1, d);
  vec2 horizon0 = capHalfAngles(r0, kCapRightAngle, capDistance(axis0, normal));
  vec2 horizon1 = capHalfAngles(r1, kCapRightAngle, capDistance(axis1, normal));
  vec3 between = axis1 - axis0;
  float middle0 = capDistance(capTangent(axis0, normal), capTangent(axis0, between));
  float middle1 = capDistance(capTangent(axis1, normal), capTangent(axis1, -between));
  float middle = capDistance(capTangent(normal, axis0), capTangent(normal, axis1));
  float sum = capBorder(normal, axis0, r0, horizon0.x, middle0, both.x) + capBorder(normal, axis1, r1, horizon1.x, middle1, both.y);
  return clamp(sum + 0.5f * capArcs(horizon0.y, middle, horizon1.y).x, 0.0f, area);
}

OVERCAST_SHARED_END

#endif
