#include "tests/reference/pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace overcast::reference {

Field fieldOf(const glm::ivec3& size, const std::function<double(const glm::dvec3&)>& f) {
  Field field{size, {}};
  for (int k = 0; k < size.z; ++k)
    for (int j = 0; j < size.y; ++j)
      for (int i = 0; i < size.x; ++i) field.values.push_back(f({i + 0.5, j + 0.5, k + 0.5}));
  return field;
}

double valueAt(const Field& field, const glm::ivec3& voxel) {
  const auto inside = [&](int axis) { return static_cast<std::size_t>(std::clamp(voxel[axis], 0, field.size[axis] - 1)); };
  return field
      .values[inside(0) + static_cast<std::size_t>(field.size.x) * (inside(1) + static_cast<std::size_t>(field.size.y) * inside(2))];
}

double interpolate(const Field& field, const glm::dvec3& point) {
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    glm::ivec3 voxel;
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double u = point[axis] - 0.5;
      const int upper = (corner >> axis) & 1;
      voxel[axis] = static_cast<int>(std::floor(u)) + upper;
      weight *= upper ? u - std::floor(u) : 1.0 - (u - std::floor(u));
    }
    sum += weight * valueAt(field, voxel);
  }
  return sum;
}

Field nextLevel(const Field& field) {
  const double weights[4] = {0.125, 0.375, 0.375, 0.125};
  Field next{(field.size + 1) / 2, {}};
  for (int k = 0; k < next.size.z; ++k)
    for (int j = 0; j < next.size.y; ++j)
      for (int i = 0; i < next.size.x; ++i) {
        double sum = 0.0;
        for (int c = 0; c < 4; ++c)
          for (int b = 0; b < 4; ++b)
            for (int a = 0; a < 4; ++a)
              sum += weights[a] * weights[b] * weights[c] * valueAt(field, {2 * i - 1 + a, 2 * j - 1 + b, 2 * k - 1 + c});
        next.values.push_back(sum);
      }
  return next;
}

std::vector<Field> pyramid(const Field& field, int count) {
  std::vector<Field> levels{field};
  while (static_cast<int>(levels.size()) < count) levels.push_back(nextLevel(levels.back()));
  return levels;
}

}  // namespace overcast::reference
