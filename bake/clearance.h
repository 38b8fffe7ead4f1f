// Clearance: from where a vertex looks when its normal leads into one of its own triangles, as at the foot of ravine walls.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "bake/visibility.h"
#include "formats/mesh.h"

namespace overcast {

/// Moves origins[i] where rays from it (traceVisibility: kRayOffset further along the normal) would start behind, or nearly on, a triangle
/// around it: to a point in front of all of them, at most kMostLift times as far from the vertex as rays usually start. Others stay, and
/// those that have no such point, and those whose normals point in, against most of the area around them. A vertex of a mesh that hides
/// nothing from one direction, as terrain seen from above, always has one. `triangles`: those of the mesh over points, vertices[i] a vertex
/// at point i; `origins`: of the points, within kRayOffset of the mesh's diagonal of their vertices.
void clearOfTriangles(const Mesh& mesh, std::span<const glm::uvec3> triangles, std::span<const std::uint32_t> vertices,
                      std::span<SurfacePoint> origins);

inline constexpr double kMostLift = 8.0;

}  // namespace overcast
