// Shapes: the closed meshes that the project makes itself. All are centred on the origin, counter-clockwise seen from outside, in metres.
// Coordinates are snapped to micrometres, so that the last bits of a math library never reach a file.
#pragma once

#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
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
/// Ascends along x: `steps` steps, each `run` deep and `rise` high, `width` along z, solid down to the floor.
Mesh makeStairs(int steps, double run, double rise, double width);
/// A box with a rectangular hole through it along z, from `holeMin` to `holeMax` in x and y, within the box.
Mesh makeFrame(const glm::dvec3& extent, const glm::dvec2& holeMin, const glm::dvec2& holeMax);
/// A leaf along z from the origin (its only point off centre): pointed, `width` at its widest, folded along its middle by `fold` (the
/// height of its edges above the middle), `thickness` thick.
Mesh makeLeaf(double length, double width, double fold, double thickness);

/// Several closed meshes as one.
Mesh merged(const std::vector<Mesh>& meshes, const char* name);
/// The mesh moved to where a pose puts it.
Mesh transformed(Mesh mesh, const glm::dvec3& translation, const glm::dquat& rotation);

/// A box of squares of about `cell` (its sides only lengthwise), so that its vertices can tell what they see.
Mesh makeSlab(const glm::dvec3& extent, double cell);
/// A standing figure without a face: a swaying body of many folds, twisted about the y axis, `height` tall.
Mesh makeStatue(double height, int segments, int rings);

/// Nearest multiple of 1e-6.
double snapped(double value);
glm::dvec3 snapped(const glm::dvec3& value);

/// The lowest y of the mesh once it is turned by `rotation` about its origin.
double lowestPoint(const Mesh& mesh, const glm::dquat& rotation);

/// Scales the mesh so that its longest side is `longestSide`, and centres its box on the origin.
void fitToSize(Mesh& mesh, double longestSide);

}  // namespace overcast
