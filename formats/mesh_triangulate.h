// Polygons into triangles. Internal to formats.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace overcast {

/// Appends the n - 2 triangles of a polygon with n >= 3 corners, in the polygon's orientation: a fan when the polygon is convex, ear
/// clipping on its projection along the Newell normal otherwise (Eberly 2002, "Triangulation by ear clipping"). Where no ear is left, in a
/// degenerate or self-intersecting polygon, the least bad corner is cut off, so that the work stays within n^2 steps for any
/// input. Polygons with more than kMaxEarClippingCorners corners are fanned. Every index must be below positions.size().
void triangulate(std::span<const glm::dvec3> positions, std::span<const std::uint32_t> polygon, std::vector<glm::uvec3>& triangles);

inline constexpr std::size_t kMaxEarClippingCorners = 4096;

}  // namespace overcast
