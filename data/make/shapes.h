// Shapes: the closed meshes that the project makes itself. All are centred on the origin, counter-clockwise seen from outside, in metres.
// Coordinates are snapped to micrometres, so that the last bits of a math library never reach a file.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast {

Mesh makeBox(const glm::dvec3& extent);
/// Subdivided icosahedron: 20 * 4^subdivisions triangles.
Mesh makeIcosphere(double radius, int subdivisions);
/// Round the y axis: `radius` from the axis to the middle of the tube.
Mesh makeTorus(double radius, double tubeRadius, int segments, int tubeSegments);
/// Apex up, base down; centred at half its height.
Mesh makeCone(double radius, double height, int segments);
Mesh makeCylinder(double radius, double height, int segments);
/// The (p, q) torus knot about the z axis; fits in a sphere of about `radius`.
Mesh makeTorusKnot(double radius, double tubeRadius, int p, int q, int segments, int tubeSegments);
/// A star with `arms` arms round the y axis, the first along x, and one to each pole (Gielis' superformula in both angles); `radius` to the
/// tip of an arm.
Mesh makeStar(double radius, int arms, int segments, int rings);

/// Nearest multiple of 1e-6.
double snapped(double value);
glm::dvec3 snapped(const glm::dvec3& value);

/// The lowest y of the mesh once it is turned by `rotation` about its origin.
double lowestPoint(const Mesh& mesh, const glm::dquat& rotation);

/// Scales the mesh so that its longest side is `longestSide`, and centres its box on the origin.
void fitToSize(Mesh& mesh, double longestSide);

}  // namespace overcast
