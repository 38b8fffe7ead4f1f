// Radius fields of shapes in closed form, without a baker.
#pragma once

#include <algorithm>

#include <glm/geometric.hpp>

#include "formats/radius.h"
#include "tests/reference/radius.h"

namespace overcast::test {

/// The radii at the texels themselves at every level, variance as given.
inline RadiusField fieldOf(const reference::RadiusFunction& radius, int side, const glm::dvec3& centre = glm::dvec3(0.0),
                           float variance = 0.0f) {
  RadiusField field;
  field.centre = centre;
  for (; side >= 2; side /= 2) {
    RadiusLevel& level = field.levels.emplace_back();
    level.side = side;
    for (unsigned face = 0; face < 6; ++face)
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) {
          const double r = radius(glm::normalize(texelDirection(side, face, i, j)));
          level.texel.push_back({static_cast<float>(r), variance, {}});
        }
  }
  derive(field);
  return field;
}

}  // namespace overcast::test
