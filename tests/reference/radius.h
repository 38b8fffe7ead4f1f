// Radii of shapes in closed form and of meshes by brute force, and the first-order distance of a star shape (DESIGN 5.1), in double. Shares
// no code with formats, bake and runtime.
#pragma once

#include <functional>

#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast::reference {

/// Distance of the surface from the origin along a unit vector.
using RadiusFunction = std::function<double(const glm::dvec3&)>;

/// A sphere about `centre`; the origin is inside.
RadiusFunction sphereRadius(const glm::dvec3& centre, double radius);
RadiusFunction ellipsoidRadius(const glm::dvec3& halfExtents);
RadiusFunction cuboidRadius(const glm::dvec3& halfExtents);
/// A sphere with smooth bumps, like an asteroid: radius between 0.6 and 1.4, slopes below 2.
RadiusFunction bumpyRadius();

/// Distance of the outermost crossing of the ray from `origin` along the unit vector with any triangle; 0 when there is none.
double outermostCrossing(const Mesh& mesh, const glm::dvec3& origin, const glm::dvec3& direction);

/// (|p| - r) / sqrt(1 + |grad_s r|^2 / r^2), the gradient by central differences of step 1e-5.
double firstOrderDistance(const RadiusFunction& radius, const glm::dvec3& point);

/// Largest smallest distance behind the planes of all faces, over all points: by trying every four planes. For meshes of a few dozen faces.
double largestMargin(const Mesh& mesh);

/// The mesh with every vertex moved along its direction to the radius there.
Mesh withRadius(Mesh mesh, const RadiusFunction& radius);

}  // namespace overcast::reference
