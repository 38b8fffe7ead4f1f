// Shapes whose signed distance is known in closed form, meshes of them, and ways to spoil a mesh. For tests only.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast::reference {

// Signed distances, negative inside, all about the origin.
double sphereDistance(const glm::dvec3& point, double radius);
double boxDistance(const glm::dvec3& point, const glm::dvec3& halfExtent);
double torusDistance(const glm::dvec3& point, double majorRadius, double minorRadius);  ///< axis y

// Closed, manifold meshes about the origin, normals outward.

/// An icosahedron split `subdivisions` times, vertices on the sphere: 20 * 4^n triangles. The surface lies at most radius * (1 - cos of
/// half an edge's angle) inside the sphere: see icosphereSag.
Mesh icosphere(double radius, int subdivisions);
double icosphereSag(double radius, int subdivisions);  ///< upper bound of the depth of the mesh below the sphere
Mesh boxMesh(const glm::dvec3& halfExtent);            ///< 8 vertices, 12 triangles
/// Two triangles per cell of majorSteps x minorSteps, vertices on the torus, axis y.
Mesh torusMesh(double majorRadius, double minorRadius, int majorSteps, int minorSteps);

/// `triangles` unconnected triangles with corners anywhere in the cube of half side `extent`.
Mesh triangleSoup(std::uint64_t seed, int triangles, double extent);

// Ways to spoil a mesh; each gives a new one. `share` of the triangles in [0, 1], chosen by the seed.
Mesh withHoles(const Mesh& mesh, double share, std::uint64_t seed);
Mesh withFlips(const Mesh& mesh, double share, std::uint64_t seed);       ///< orientation reversed
Mesh withDuplicates(const Mesh& mesh, double share, std::uint64_t seed);  ///< the same triangle once more, appended
Mesh insideOut(const Mesh& mesh);                                         ///< every triangle reversed
Mesh unwelded(const Mesh& mesh);                                          ///< three vertices of its own for every triangle, as in STL

/// The same surface listed otherwise: vertices and triangles in another order, corners rotated within triangles.
Mesh shuffled(const Mesh& mesh, std::uint64_t seed);

Mesh moved(const Mesh& mesh, const glm::dvec3& offset);
Mesh scaled(const Mesh& mesh, double factor);
Mesh joined(const Mesh& first, const Mesh& second);  ///< both in one mesh, untouched where they overlap

/// Points evenly at random in the box; the same on every machine.
std::vector<glm::dvec3> randomPoints(const Box& box, std::size_t count, std::uint64_t seed);

}  // namespace overcast::reference
