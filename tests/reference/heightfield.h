// Truth for heightfields: the surface that texels define and its first-order distance, by sums over all texels in double. Shares no code
// with what it checks.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "formats/heightfield.h"

namespace overcast::reference {

/// Mean and variance over the texels of the finest level that a coarser one's texel (i, j) covers.
glm::dvec2 momentsBelow(const HeightField& field, const HeightLevels& layer, int level, int i, int j);

/// The height (x), its two derivatives by texel (y, z) and the variance (w) of a layer's level at `at`, texels from its corner: the
/// sum over all texels of value times quadratic B-spline; beyond the sides heights go on straight and variances stay. Stored units.
glm::dvec4 surface(const HeightField& field, const HeightLevels& layer, const glm::dvec2& at, int level = 0);

/// The distance that formats/heightfield.h defines, finest level.
double heightFieldDistance(const HeightField& field, const glm::dvec3& point);

}  // namespace overcast::reference
