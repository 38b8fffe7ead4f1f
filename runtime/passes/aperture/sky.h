// Sky light from order-2 harmonics (formats/sky.h): through an aperture, over an open surface, and by a vertex's own transfer. Read by C++
// and GLSL.
//
// Written as a polynomial the sky's radiance is L(w) = a + g . w + w^T Q w, Q symmetric and without trace. Over a cap of axis c and radius
// r its integrals with a cosine n . w are in closed form; with z = cos r, divided by that of the cosine alone, pi sin^2 r (c . n), they are
//   1,   (1 - z)(2 + z) / (3 (1 + z)) g . n + z (g . c)(c . n),   (1 - z^2) / 2 c^T Q n + (5 z^2 - 1) / 4 (c^T Q c)(c . n),
// the last two over c . n. For n = c these are the cap's zonal coefficients, 1, (2/3) (1 + z + z^2) / (1 + z) and (1 + 3 z^2) / 4; for
// r = pi/2 too, the 1, 2/3 and 1/4 of irradiance (Ramamoorthi and Hanrahan 2001).
//
// Order 2 rings: beside what is small and bright a sky may come out below 0. Results are clamped there and nothing is taken off the peaks:
// windowing the coefficients would make every smooth sky wrong for the sake of those that are better given as a sun or a lamp.
#ifndef RUNTIME_PASSES_APERTURE_SKY_H
#define RUNTIME_PASSES_APERTURE_SKY_H

#include "runtime/passes/aperture/caps.h"

OVERCAST_SHARED_BEGIN

/// Harmonics of a sky.
struct SkyLight {
  vec4 coefficients[9];  ///< xyz: of Y_0 .. Y_8 (formats/aperture.h)
};

const float kSkyConstant = 0.282094792f;    ///< Y_0
const float kSkyLinear = 0.488602512f;      ///< of those linear in w
const float kSkyMixed = 1.092548431f;       ///< of xy, yz and xz
const float kSkyPolar = 0.315391565f;       ///< of 3 z^2 - 1
const float kSkyDifference = 0.546274215f;  ///< of x^2 - y^2

/// g . v.
OVERCAST_INLINE vec3 skyLinear(SkyLight sky, vec3 v) {
  vec4 sum = v.y * sky.coefficients[1] + v.z * sky.coefficients[2] + v.x * sky.coefficients[3];
  return kSkyLinear * vec3(sum);
}

/// u^T Q v.
OVERCAST_INLINE vec3 skyQuadratic(SkyLight sky, vec3 u, vec3 v) {
  vec4 mixed = (u.x * v.y + u.y * v.x) * sky.coefficients[4] + (u.y * v.z + u.z * v.y) * sky.coefficients[5] +
               (u.x * v.z + u.z * v.x) * sky.coefficients[7];
  vec4 polar = (2.0f * u.z * v.z - u.x * v.x - u.y * v.y) * sky.coefficients[6];
  vec4 difference = (u.x * v.x - u.y * v.y) * sky.coefficients[8];
  return 0.5f * kSkyMixed * vec3(mixed) + kSkyPolar * vec3(polar) + kSkyDifference * vec3(difference);
}

/// Radiance from unit direction `w`, not below 0.
OVERCAST_INLINE vec3 skyRadiance(SkyLight sky, vec3 w) {
  return max(kSkyConstant * vec3(sky.coefficients[0]) + skyLinear(sky, w) + skyQuadratic(sky, w, w), vec3(0.0f));
}

/// What an open surface of unit normal `n` receives, over pi: the mean radiance under the cosine.
OVERCAST_INLINE vec3 skyOverOpen(SkyLight sky, vec3 n) {
  vec3 sum = kSkyConstant * vec3(sky.coefficients[0]) + (2.0f / 3.0f) * skyLinear(sky, n) + 0.25f * skyQuadratic(sky, n, n);
  return max(sum, vec3(0.0f));
}

/// The direction whose cosine stands for that to the normal over an aperture (xyz axis, w radius). The normal, exactly, where the cap lies
/// above the horizon. A cap that dips below it stands for a shape that does not: there half way to the axis, which halves the error of
/// either over walls at any angle, and never lets the cosine vanish.
OVERCAST_INLINE vec3 skyNormal(vec3 normal, vec4 aperture) {
  vec3 axis = vec3(aperture);
  float below = capDistance(axis, normal) + aperture.w - kCapRightAngle;
  vec3 sum = normal + clamp(4.0f * below, 0.0f, 1.0f) * axis;
  float squared = dot(sum, sum);
  return squared > kCapTiny ? sum / sqrt(squared) : axis;
}

/// Mean radiance under the cosine of what an aperture (xyz axis, w radius) leaves of the sky: times the aperture's ambient visibility it is
/// what the surface receives, over pi.
OVERCAST_INLINE vec3 skyThrough(SkyLight sky, vec3 normal, vec4 aperture) {
  vec3 axis = vec3(aperture);
  vec3 n = skyNormal(normal, aperture);
  float z = 1.0f - capHeight(aperture.w);
  float along = max(dot(n, axis), 0.05f);
  vec3 linear = ((1.0f - z) * (2.0f + z) / (3.0f * (1.0f + z) * along)) * skyLinear(sky, n) + z * skyLinear(sky, axis);
  vec3 quadratic =
      (0.5f * (1.0f - z * z) / along) * skyQuadratic(sky, axis, n) + (0.25f * (5.0f * z * z - 1.0f)) * skyQuadratic(sky, axis, axis);
  return max(kSkyConstant * vec3(sky.coefficients[0]) + linear + quadratic, vec3(0.0f));
}

OVERCAST_SHARED_END

#endif
