// Truth for the sign: the generalised winding number, every triangle for every point, in double. Shares no code with what it checks.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast::reference {

/// w of each point: the sum of the signed solid angles of all triangles over 4 pi (Jacobson et al. 2013, equation 6; solid angles by van
/// Oosterom and Strackee 1983). 1 inside a closed mesh whose normals point outward, 0 outside, k within k overlapping ones; between for
/// open meshes. Error about 1e-11 for a million triangles, except on the surface itself, where w is not defined. Parallel over points.
std::vector<double> windingNumber(const Mesh& mesh, std::span<const glm::dvec3> points);

}  // namespace overcast::reference
