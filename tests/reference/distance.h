// Truth for distances: every triangle against every point, in double. Shares no code with what it checks.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast::reference {

/// Distance from each point to the nearest of all triangles; degenerate triangles count as their segments. Infinite without triangles.
/// Relative error about 1e-15 of the distance plus 1e-16 of the coordinates. Parallel over points.
std::vector<double> distance(const Mesh& mesh, std::span<const glm::dvec3> points);

}  // namespace overcast::reference
