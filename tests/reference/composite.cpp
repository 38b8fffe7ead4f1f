#include "tests/reference/composite.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace overcast::reference {
namespace {

/// One coordinate of an interpolation: cell and weight of its upper end.
struct Lerp {
  int cell = 0;
  double weight = 0.0;
};

Lerp lerpAt(double u, int samples) {
  const int cell = std::min(std::max(static_cast<int>(std::floor(u)), 0), samples - 2);
  return {cell, u - cell};
}

double interpolated(const Volume& volume, const glm::dvec3& u) {
  const Lerp x = lerpAt(u.x, volume.size.x), y = lerpAt(u.y, volume.size.y), z = lerpAt(u.z, volume.size.z);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner % 2, j = corner / 2 % 2, k = corner / 4;
    const double weight = (i ? x.weight : 1.0 - x.weight) * (j ? y.weight : 1.0 - y.weight) * (k ? z.weight : 1.0 - z.weight);
    const std::size_t index =
        static_cast<std::size_t>(x.cell + i) +
        static_cast<std::size_t>(volume.size.x) *
            (static_cast<std::size_t>(y.cell + j) + static_cast<std::size_t>(volume.size.y) * static_cast<std::size_t>(z.cell + k));
    sum += weight * static_cast<double>(volume.distance[index]);
  }
  return sum;
}

/// Number of eigenvalues of the symmetric matrix below x: sign changes of the leading minors of (A - x I), Sylvester's inertia.
int eigenvaluesBelow(const long double a[3][3], long double x) {
  const long double b = a[0][0] - x, c = a[1][1] - x, d = a[2][2] - x;
  const long double m1 = b;
  const long double m2 = b * c - a[0][1] * a[0][1];
  const long double m3 =
      b * (c * d - a[1][2] * a[1][2]) - a[0][1] * (a[0][1] * d - a[1][2] * a[0][2]) + a[0][2] * (a[0][1] * a[1][2] - c * a[0][2]);
  return (m1 < 0) + ((m1 < 0) != (m2 < 0)) + ((m2 < 0) != (m3 < 0));
}

bool keepsCuboids(const glm::dmat3& m) {
  const double xy = glm::dot(m[0], m[1]), yz = glm::dot(m[1], m[2]), zx = glm::dot(m[2], m[0]);
  const double x = glm::length(m[0]), y = glm::length(m[1]), z = glm::length(m[2]);
  return std::abs(xy) < 1e-9 * x * y && std::abs(yz) < 1e-9 * y * z && std::abs(zx) < 1e-9 * z * x;
}

}  // namespace

double smallestSingularValue(const glm::dmat3& matrix) {
  long double gram[3][3];
  long double trace = 0.0L;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      gram[i][j] = 0.0L;
      for (int k = 0; k < 3; ++k) gram[i][j] += static_cast<long double>(matrix[i][k]) * static_cast<long double>(matrix[j][k]);
      if (i == j) trace += gram[i][j];
    }
  long double low = 0.0L, high = trace;
  for (int step = 0; step < 200; ++step) {
    const long double middle = 0.5L * (low + high);
    (eigenvaluesBelow(gram, middle) > 0 ? high : low) = middle;
  }
  return static_cast<double>(std::sqrt(low));
}

PlacedVolume place(const Volume& volume, const glm::dmat4& worldFromLocal) {
  const glm::dmat3 linear(worldFromLocal);
  return {&volume, worldFromLocal, glm::inverse(worldFromLocal), smallestSingularValue(linear), keepsCuboids(linear)};
}

double objectDistance(const PlacedVolume& object, const glm::dvec3& point) {
  const Volume& volume = *object.volume;
  const glm::dvec3 local(object.localFromWorld * glm::dvec4(point, 1.0));
  const glm::dvec3 low = volume.origin, high = volume.origin + volume.voxelSize * glm::dvec3(volume.size - 1);
  glm::dvec3 q = local;
  for (int axis = 0; axis < 3; ++axis) q[axis] = std::min(std::max(local[axis], low[axis]), high[axis]);
  const double phi = object.sigmaMin * interpolated(volume, (q - low) / volume.voxelSize);
  const glm::dvec3 beyond = local - q;
  const double gap = object.keepsCuboids ? glm::length(glm::dmat3(object.worldFromLocal) * beyond) : object.sigmaMin * glm::length(beyond);
  if (gap == 0.0) return phi;
  if (phi < 0.0) return gap + phi;
  const double reach = std::max(std::abs(beyond.x), std::max(std::abs(beyond.y), std::abs(beyond.z)));
  const glm::dvec3 inwards = q - beyond * (volume.voxelSize / reach);
  const double inner = object.sigmaMin * interpolated(volume, (inwards - low) / volume.voxelSize);
  const double walked = gap * volume.voxelSize / reach;
  const double slope = std::min(std::max((phi - inner) / walked, 0.0), 1.0);
  return std::sqrt(gap * gap + phi * phi + 2.0 * gap * phi * slope);
}

double compositeDistance(const std::vector<PlacedVolume>& objects, const glm::dvec3& point, double farAway) {
  double nearest = farAway;
  for (const PlacedVolume& object : objects) nearest = std::min(nearest, objectDistance(object, point));
  return nearest;
}

}  // namespace overcast::reference
