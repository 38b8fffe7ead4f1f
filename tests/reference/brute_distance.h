// Brute force: the distance from a point to a mesh by looking at every triangle, in double.
#pragma once

#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast::reference {

/// Distance from `p` to one triangle: to its plane where the point projects inside, to its nearest edge elsewhere; degenerate triangles
/// count as their edges.
double distanceToTriangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

/// Distance from `p` to the nearest triangle.
double distanceToMesh(const glm::dvec3& p, const Mesh& mesh);

}  // namespace overcast::reference
