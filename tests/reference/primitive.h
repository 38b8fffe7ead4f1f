// Distances to cuboids and ellipsoids under any affine map by brute force in double. Shares no code with what it checks.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace overcast::reference {

/// Signed distance to the image of the cube [-1, 1]^3 (a parallelepiped): the nearest of its 12 triangles.
double cuboidDistance(const glm::dvec3& point, const glm::dmat4& worldFromCube);

/// Signed distance to the image of the unit ball: the nearest of 64 x 128 points of the sphere, and from the nearest eight of them
/// downhill over ever finer grids, to a spacing of 1e-9.
double ellipsoidDistance(const glm::dvec3& point, const glm::dmat4& worldFromBall);

}  // namespace overcast::reference
