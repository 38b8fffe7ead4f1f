// Oriented box: the box of least volume around points (CGAL's optimal bounding box; Chang, Gorissen, Melchior 2011, "Fast oriented bounding
// box optimization on the rotation group SO(3)").
#pragma once

#include <optional>
#include <span>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace overcast {

/// Orthonormal right-handed axes of a box of nearly least volume around `points`; the same for the same points in the same order. Nothing
/// when the points are fewer than four, lie in a plane, or CGAL gives up. The points' extent is of the order of 1.
std::optional<glm::dmat3> orientedBoxAxes(std::span<const glm::dvec3> points);

}  // namespace overcast
