// Vertex normals for meshes that have none.
#pragma once

#include "formats/mesh.h"

namespace overcast {

/// Edges where the faces turn by more than this are creases: 60 degrees.
inline constexpr double kCreaseCosine = 0.5;

/// The mesh with one unit normal per vertex: the sum of the face normals around it, each weighted by the face's angle there (Thuermer and
/// Wuethrich 1998). Vertices at the same position count as one (so STL soups come out smooth), except across edges where the face
/// normals differ by more than 60 degrees: there a vertex is split. The vertices of the input stay at the front in their order, split
/// ones follow; triangles and parts keep their order. Vertices without any face of positive area get +Y.
Mesh withNormals(Mesh mesh);

/// The mesh with every normal that is not of unit length (to 1e-4) made so; +Y where it is zero.
void mendNormals(Mesh& mesh);

}  // namespace overcast
