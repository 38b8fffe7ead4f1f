// Caps: what spherical caps have in common, by numerical integration. A cap is a unit axis and a radius in [0, pi/2], angles in radians.
#pragma once

#include <glm/vec3.hpp>

namespace overcast::reference {

/// Solid angle of a cap.
long double capArea(long double radius);

/// Solid angle of the intersection of two caps whose axes are d apart: circles about the smaller one's axis, tanh-sinh over their radius.
/// Relative to the smaller cap within 1e-12.
long double capIntersection(long double r0, long double r1, long double d);

/// What lies in two caps and above the horizon of `normal`.
struct CapMoments {
  double area = 0.0;       ///< of the intersection of both caps, below the horizon too
  glm::dvec3 moment{0.0};  ///< integral of the direction over the same
  double cosine = 0.0;     ///< integral of max(0, normal . direction) over it
};

/// Midpoints of steps x steps cells of equal area in the smaller cap.
CapMoments capMoments(const glm::dvec3& normal, const glm::dvec3& axis0, double r0, const glm::dvec3& axis1, double r1, int steps);

}  // namespace overcast::reference
