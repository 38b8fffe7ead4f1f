#include "tests/reference/winding_number.h"

#include <array>
#include <cmath>
#include <numbers>

#include "tests/reference/lanes.h"

namespace overcast::reference {
namespace {

/// 1 below zero, 0 elsewhere: a number, because branches would keep the loop from vector instructions.
inline double below(double value) {
  return value < 0.0 ? 1.0 : 0.0;
}

using Corners = std::array<glm::dvec3, 3>;

/// tan(solid angle / 2) = |a b c| / (|a||b||c| + (a.b)|c| + (b.c)|a| + (c.a)|b|). The angles are summed as the argument of the product of
/// (denominator + i numerator), each less than half a turn, and full turns are counted where the product passes the negative real axis:
/// one atan2 per point instead of one per triangle.
OVERCAST_REFERENCE_CLONES
void halfAngles(const std::vector<Corners>& triangles, const PointBlock& points, Lanes& result) {
  Lanes re;
  Lanes im{};
  Lanes turns{};
  re.fill(1.0);
  for (const Corners& triangle : triangles) {
    const Corners t = triangle;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const double ax = t[0].x - points.x[l], ay = t[0].y - points.y[l], az = t[0].z - points.z[l];
      const double bx = t[1].x - points.x[l], by = t[1].y - points.y[l], bz = t[1].z - points.z[l];
      const double cx = t[2].x - points.x[l], cy = t[2].y - points.y[l], cz = t[2].z - points.z[l];
      const double a = std::sqrt(ax * ax + ay * ay + az * az);
      const double b = std::sqrt(bx * bx + by * by + bz * bz);
      const double c = std::sqrt(cx * cx + cy * cy + cz * cz);
      const double volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
      const double cosines =
          a * b * c + (ax * bx + ay * by + az * bz) * c + (bx * cx + by * cy + bz * cz) * a + (cx * ax + cy * ay + cz * az) * b;
      const double size = std::abs(cosines) + std::abs(volume);
      // A point on a corner has no angle there: multiply by 1.
      const double corner = size > 0.0 ? 0.0 : 1.0;
      const double scale = 1.0 / (size + corner);
      const double u = cosines * scale + corner;
      const double v = volume * scale;
      const double newRe = re[l] * u - im[l] * v;
      const double newIm = re[l] * v + im[l] * u;
      const double was = below(im[l]);
      const double is = below(newIm);
      turns[l] += below(-v) * (1.0 - was) * is - below(v) * was * (1.0 - is);
      const double norm = 1.0 / (std::abs(newRe) + std::abs(newIm));
      re[l] = newRe * norm;
      im[l] = newIm * norm;
    }
  }
  for (std::size_t l = 0; l < kLanes; ++l) result[l] = std::atan2(im[l], re[l]) + 2.0 * std::numbers::pi * turns[l];
}

}  // namespace

std::vector<double> windingNumber(const Mesh& mesh, std::span<const glm::dvec3> points) {
  std::vector<Corners> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) triangles.push_back({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
  auto w = forBlocks(points, [&](const PointBlock& block, Lanes& result) { halfAngles(triangles, block, result); });
  for (double& value : w) value /= 2.0 * std::numbers::pi;
  return w;
}

}  // namespace overcast::reference
