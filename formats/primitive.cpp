#include "formats/primitive.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace overcast {

namespace {

double cuboidDistance(const glm::dvec3& point, const glm::dvec3& half) {
  const glm::dvec3 beyond = glm::abs(point) - half;
  const glm::dvec3 outside = glm::max(beyond, glm::dvec3(0.0));
  return std::hypot(outside.x, outside.y, outside.z) + std::min(std::max({beyond.x, beyond.y, beyond.z}), 0.0);
}

/// In units of the smallest half extent, with u the point and rho the half extents, the closest point is x_i = rho_i^2 u_i / d_i with
/// d_i = t + rho_i^2 - 1, and t > 0 the root of |w| = 1, w_i = rho_i u_i / d_i. 1 / |w| is concave in t, so Newton's iteration on it climbs
/// from any t below the root and never passes it. The distance is |t - 1| |u / d|, which cancels nothing at the surface.
double ellipsoidDistance(const glm::dvec3& point, const glm::dvec3& half) {
  // A point on a plane of symmetry may have its closest point off it; this much off the plane the root exists and is the limit.
  constexpr double kOffPlane = 1e-100;
  constexpr int kMostSteps = 200;  // four to eight do; points within rounding of the focal ellipse take some fifty
  const double smallest = std::min({half.x, half.y, half.z});
  const glm::dvec3 rho = half / smallest;
  const glm::dvec3 u = glm::max(glm::abs(point) / smallest, glm::dvec3(kOffPlane));
  const glm::dvec3 offset = (rho - 1.0) * (rho + 1.0);
  const glm::dvec3 start = rho * u - offset;
  double t = std::max({start.x, start.y, start.z});
  glm::dvec3 d = offset + t;
  for (int step = 0; step < kMostSteps; ++step) {
    const glm::dvec3 w = rho * u / d;
    const double squared = glm::dot(w, w);
    const double next = t + (std::sqrt(squared) - 1.0) * squared / glm::dot(w, w / d);
    if (!(next > t)) break;
    t = next;
    d = offset + t;
  }
  return smallest * (t - 1.0) * glm::length(u / d);
}

}  // namespace

const char* name(PrimitiveShape shape) {
  return shape == PrimitiveShape::cuboid ? "cuboid" : "ellipsoid";
}

bool isWhole(const Primitive& primitive) {
  const glm::dvec3& h = primitive.halfExtents;
  const double smallest = std::min({h.x, h.y, h.z}), largest = std::max({h.x, h.y, h.z});
  const glm::dvec3 c = glm::abs(primitive.centre);
  // Comparisons are false for what is not a number.
  return h.x > 0.0 && h.y > 0.0 && h.z > 0.0 && smallest >= kSmallestHalfExtent && largest <= kLargestHalfExtent &&
         smallest >= kThinnestPrimitive * largest && c.x <= kLargestHalfExtent && c.y <= kLargestHalfExtent && c.z <= kLargestHalfExtent &&
         std::abs(glm::length(primitive.rotation) - 1.0) <= 1e-9 &&
         (primitive.shape == PrimitiveShape::cuboid || primitive.shape == PrimitiveShape::ellipsoid);
}

Box bounds(const Primitive& primitive) {
  const glm::dmat3 axes = glm::mat3_cast(primitive.rotation);
  glm::dvec3 reach(0.0);
  for (int r = 0; r < 3; ++r) {
    const glm::dvec3 row = glm::abs(glm::dvec3(axes[0][r], axes[1][r], axes[2][r])) * primitive.halfExtents;
    reach[r] = primitive.shape == PrimitiveShape::cuboid ? row.x + row.y + row.z : glm::length(row);
  }
  return {primitive.centre - reach, primitive.centre + reach};
}

double samplePrimitive(const Primitive& primitive, const glm::dvec3& point) {
  const glm::dvec3 own = glm::conjugate(primitive.rotation) * (point - primitive.centre);
  return primitive.shape == PrimitiveShape::cuboid ? cuboidDistance(own, primitive.halfExtents)
                                                   : ellipsoidDistance(own, primitive.halfExtents);
}

double lipschitzBound(const Primitive&) {
  return 1.0;
}

}  // namespace overcast
