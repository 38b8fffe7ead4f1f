// Brute-force pyramid in double: 64 weights per voxel, borders repeated (DESIGN 5.3). Shares no code with the runtime.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

namespace overcast::reference {

/// Values at voxel centres (i + 0.5, j + 0.5, k + 0.5), x fastest.
struct Field {
  glm::ivec3 size{0};
  std::vector<double> values;
};

/// A field of `f` at its voxels' centres.
Field fieldOf(const glm::ivec3& size, const std::function<double(const glm::dvec3&)>& f);

/// The value of a voxel; beyond the border that of the nearest voxel.
double valueAt(const Field& field, const glm::ivec3& voxel);

/// Trilinear interpolation at a point in voxels from the field's corner, borders repeated.
double interpolate(const Field& field, const glm::dvec3& point);

/// The next level: size / 2 rounded up, [1 3 3 1] / 8 along every axis about the centre of the two voxels it replaces.
Field nextLevel(const Field& field);

/// `count` levels, the field itself first.
std::vector<Field> pyramid(const Field& field, int count);

}  // namespace overcast::reference
