// Triangle: the exact squared distance from a point to one triangle, in double. Private to bake.
#pragma once

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace overcast {

/// Squared distance from `p` to the segment from `a` along `ab`; a point when `ab` is zero.
inline double squaredDistanceToSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& ab) {
  const glm::dvec3 ap = p - a;
  const double length2 = glm::dot(ab, ab);
  const double t = length2 > 0.0 ? std::clamp(glm::dot(ap, ab) / length2, 0.0, 1.0) : 0.0;
  const glm::dvec3 d = ap - t * ab;
  return glm::dot(d, d);
}

/// Squared distance from `p` to the triangle a, b, c. Every candidate is the distance to a point that lies on the triangle, so that slivers
/// and degenerate triangles, whose normal is noise, can never come out nearer than they are.
inline double squaredDistanceToTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const glm::dvec3 ap = p - a;
  const double bb = glm::dot(ab, ab);
  const double bc = glm::dot(ab, ac);
  const double cc = glm::dot(ac, ac);
  const double pb = glm::dot(ap, ab);
  const double pc = glm::dot(ap, ac);
  const double determinant = bb * cc - bc * bc;
  const double s = cc * pb - bc * pc;
  const double t = bb * pc - bc * pb;
  const bool above = s >= 0.0 && t >= 0.0 && s + t <= determinant && determinant > 0.0;
  double best = std::min({squaredDistanceToSegment(p, a, ab), squaredDistanceToSegment(p, a, ac), squaredDistanceToSegment(p, b, c - b)});
  if (above) {
    const glm::dvec3 d = ap - (s / determinant) * ab - (t / determinant) * ac;
    best = std::min(best, glm::dot(d, d));
  }
  return best;
}

}  // namespace overcast
