#include "tests/reference/distance.h"

#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "tests/reference/lanes.h"

namespace overcast::reference {
namespace {

/// What does not depend on the point. A point projects into the triangle where it lies on the inner side of all three edges.
struct Facet {
  glm::dvec3 a, ab, ac, bc;
  glm::dvec3 normal;                     ///< unit
  glm::dvec3 innerAb, innerBc, innerCa;  ///< in the plane, across each edge, towards the inside
  double perAb, perAc, perBc;            ///< 1 / squared length; 0 for an edge without length
  double inside;                         ///< 0; infinite for a triangle without area, which nothing projects into
};

double inverseOrZero(double value) {
  return value > 0.0 ? 1.0 / value : 0.0;
}

Facet facetOf(const Mesh& mesh, const glm::uvec3& triangle) {
  Facet f{};
  f.a = mesh.positions[triangle.x];
  f.ab = mesh.positions[triangle.y] - f.a;
  f.ac = mesh.positions[triangle.z] - f.a;
  f.bc = mesh.positions[triangle.z] - mesh.positions[triangle.y];
  f.perAb = inverseOrZero(glm::dot(f.ab, f.ab));
  f.perAc = inverseOrZero(glm::dot(f.ac, f.ac));
  f.perBc = inverseOrZero(glm::dot(f.bc, f.bc));
  const double longest = std::max({glm::dot(f.ab, f.ab), glm::dot(f.ac, f.ac), glm::dot(f.bc, f.bc)});
  const glm::dvec3 normal = glm::cross(f.ab, f.ac);
  const double area = glm::length(normal);
  // Below this the normal is rounding error, and the triangle differs from its edges by less than the error of the coordinates.
  const bool flat = !(area > 1e-14 * longest);
  f.inside = flat ? std::numeric_limits<double>::infinity() : 0.0;
  f.normal = flat ? glm::dvec3(0.0) : normal / area;
  f.innerAb = glm::cross(f.normal, f.ab);
  f.innerBc = glm::cross(f.normal, f.bc);
  f.innerCa = glm::cross(f.normal, -f.ac);
  return f;
}

inline double dot3(double ax, double ay, double az, const glm::dvec3& b) {
  return ax * b.x + ay * b.y + az * b.z;
}

/// Squared distance to the segment from the origin of (x, y, z) along `edge`.
inline double toSegment(double x, double y, double z, const glm::dvec3& edge, double perLength) {
  const double along = dot3(x, y, z, edge) * perLength;
  const double low = along > 0.0 ? along : 0.0;
  const double t = low < 1.0 ? low : 1.0;
  const double dx = x - t * edge.x;
  const double dy = y - t * edge.y;
  const double dz = z - t * edge.z;
  return dx * dx + dy * dy + dz * dz;
}

OVERCAST_REFERENCE_CLONES
void nearest(const std::vector<Facet>& facets, const PointBlock& points, Lanes& result) {
  Lanes best;
  best.fill(std::numeric_limits<double>::infinity());
  for (const Facet& facet : facets) {
    const Facet f = facet;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double x = points.x[l] - f.a.x;
      const double y = points.y[l] - f.a.y;
      const double z = points.z[l] - f.a.z;
      const double bx = x - f.ab.x;
      const double by = y - f.ab.y;
      const double bz = z - f.ab.z;
      const double ab = toSegment(x, y, z, f.ab, f.perAb);
      const double ac = toSegment(x, y, z, f.ac, f.perAc);
      const double bc = toSegment(bx, by, bz, f.bc, f.perBc);
      const double height = dot3(x, y, z, f.normal);
      const double acrossAb = dot3(x, y, z, f.innerAb);
      const double acrossCa = dot3(x, y, z, f.innerCa);
      const double acrossBc = dot3(bx, by, bz, f.innerBc);
      const double inner = acrossAb < acrossCa ? acrossAb : acrossCa;
      const double innermost = inner < acrossBc ? inner : acrossBc;
      const double rim = ab < ac ? ab : ac;
      const double edge = rim < bc ? rim : bc;
      const double here = innermost >= f.inside ? height * height : edge;
      best[l] = here < best[l] ? here : best[l];
    }
  }
  for (std::size_t l = 0; l < kLanes; ++l) result[l] = std::sqrt(best[l]);
}

}  // namespace

std::vector<double> distance(const Mesh& mesh, std::span<const glm::dvec3> points) {
  std::vector<Facet> facets;
  facets.reserve(mesh.triangles.size());
  for (const glm::uvec3& triangle : mesh.triangles) facets.push_back(facetOf(mesh, triangle));
  return forBlocks(points, [&](const PointBlock& block, Lanes& result) { nearest(facets, block, result); });
}

}  // namespace overcast::reference
