#include "bake/kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include "formats/result.h"

namespace overcast {
namespace {

/// normal . x + margin <= offset, normal of unit length.
struct HalfSpace {
  glm::dvec3 normal;
  double offset;
};

/// Half-spaces behind the faces, in units of `scale` about `origin`.
std::vector<HalfSpace> halfSpaces(const Mesh& mesh, const glm::dvec3& origin, double scale) {
  constexpr double kLowest = 1e-10;
  std::vector<HalfSpace> planes;
  planes.reserve(mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = (mesh.positions[t.x] - origin) / scale;
    const glm::dvec3 ab = (mesh.positions[t.y] - origin) / scale - a, ac = (mesh.positions[t.z] - origin) / scale - a;
    const glm::dvec3 n = glm::cross(ab, ac);
    const double area = glm::length(n), longest = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(ac - ab, ac - ab)});
    if (!(area > kLowest * longest)) continue;
    planes.push_back({n / area, glm::dot(n / area, a)});
  }
  return planes;
}

glm::dvec4 row(const HalfSpace& plane) {
  return {plane.normal, 1.0};
}

/// The point (centre, margin) where four half-spaces are tight, and the multipliers that prove it best among them.
struct Vertex {
  std::array<HalfSpace, 4> tight;
  std::array<double, 4> multiplier;

  glm::dmat4 rows() const { return {row(tight[0]), row(tight[1]), row(tight[2]), row(tight[3])}; }
  glm::dvec4 point() const {
    return glm::inverse(glm::transpose(rows())) * glm::dvec4(tight[0].offset, tight[1].offset, tight[2].offset, tight[3].offset);
  }
};

/// A regular tetrahedron that holds the unit ball three times over.
Vertex firstVertex() {
  const double r = std::sqrt(1.0 / 3.0);
  const auto face = [&](double x, double y, double z) { return HalfSpace{glm::dvec3(x, y, z) * r, 3.0}; };
  return {{face(1, 1, 1), face(1, -1, -1), face(-1, 1, -1), face(-1, -1, 1)}, {0.25, 0.25, 0.25, 0.25}};
}

/// Puts `entering` in the place of the half-space whose multiplier reaches zero first. False when rounding leaves none to go.
bool exchange(Vertex& vertex, const HalfSpace& entering) {
  const glm::dvec4 share = glm::inverse(vertex.rows()) * row(entering);
  int leaving = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 4; ++i) {
    constexpr double kNothing = 1e-12;
    if (!(share[i] > kNothing)) continue;
    const double ratio = vertex.multiplier[static_cast<std::size_t>(i)] / share[i];
    if (ratio < least || (ratio == least && share[i] > share[leaving])) {
      least = ratio;
      leaving = i;
    }
  }
  if (leaving < 0) return false;
  for (int i = 0; i < 4; ++i) {
    double& multiplier = vertex.multiplier[static_cast<std::size_t>(i)];
    multiplier = std::max(multiplier - least * share[i], 0.0);
  }
  vertex.tight[static_cast<std::size_t>(leaving)] = entering;
  vertex.multiplier[static_cast<std::size_t>(leaving)] = least;
  return true;
}

double marginAt(const std::vector<HalfSpace>& planes, const glm::dvec3& point, std::size_t& worst) {
  double margin = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const double behind = planes[i].offset - glm::dot(planes[i].normal, point);
    if (behind < margin) {
      margin = behind;
      worst = i;
    }
  }
  return margin;
}

}  // namespace

Kernel findKernel(const Mesh& mesh) {
  OVERCAST_REQUIRE(!mesh.triangles.empty(), "a mesh of {} triangles", mesh.triangles.size());
  const Box box = bounds(mesh);
  const glm::dvec3 origin = centre(box);
  const double scale = std::max(0.5 * diagonal(box), std::numeric_limits<double>::min());
  const std::vector<HalfSpace> planes = halfSpaces(mesh, origin, scale);
  Kernel kernel{origin, -0.5 * diagonal(box), 0};
  if (planes.empty()) return kernel;

  // Every point tried has the margin of its own worst face: the best of them is kept, so that rounding can only end the search early.
  constexpr int kMostSteps = 2000;
  constexpr double kTolerance = 1e-13;
  Vertex vertex = firstVertex();
  double best = -std::numeric_limits<double>::infinity();
  for (; kernel.steps < kMostSteps; ++kernel.steps) {
    const glm::dvec4 point = vertex.point();
    std::size_t worst = 0;
    const double margin = marginAt(planes, glm::dvec3(point), worst);
    if (margin > best) {
      best = margin;
      kernel.centre = origin + scale * glm::dvec3(point);
    }
    if (!(point.w - margin > kTolerance) || !exchange(vertex, planes[worst])) break;
  }
  kernel.margin = best * scale;
  return kernel;
}

double starMargin(const Mesh& mesh, const glm::dvec3& point) {
  const double scale = std::max(0.5 * diagonal(bounds(mesh)), std::numeric_limits<double>::min());
  std::size_t worst = 0;
  return scale * marginAt(halfSpaces(mesh, point, scale), glm::dvec3(0.0), worst);
}

}  // namespace overcast
