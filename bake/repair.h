// Repair: makes a mesh as good as it safely can be before distances are taken, and says what it found and did (CGAL polygon soups).
#pragma once

#include <cstdint>

#include "formats/mesh.h"

namespace overcast {

/// What was found in a mesh and what was done about it. Counts of the welded mesh unless said otherwise.
struct MeshDiagnosis {
  std::uint64_t verticesMerged = 0;       ///< exact duplicates of a position, merged
  std::uint64_t degenerateTriangles = 0;  ///< without area: nothing to the sign, kept for the distance
  std::uint64_t duplicateTriangles = 0;   ///< the same again, or second sides of double-sided components; left out
  std::uint64_t boundaryEdges = 0;        ///< edges whose incident triangles do not cancel (net orientation not zero)
  std::uint64_t nonManifoldEdges = 0;     ///< edges with more than two triangles
  std::uint64_t inconsistentEdges = 0;    ///< manifold edges that both triangles run along in the same direction, before reorientation
  std::uint64_t components = 0;           ///< connected by shared edges
  std::uint64_t reorientedTriangles = 0;  ///< flipped to agree with their neighbours
  std::uint64_t turnedOutward = 0;        ///< flipped because nothing else said which side is out (bake/outside.h)
  bool closed = false;                    ///< every edge cancels after repair: the winding number is an integer
  bool insideOut = false;                 ///< negative volume as given
};

/// A mesh ready for distance and sign: exactly equal positions welded, no triangle twice in the same orientation (opposite pairs stay:
/// they cancel in the winding number, as the wall between two glued solids should; but a component of
/// such pairs alone is a surface modelled with two sides and keeps one of them), orientation consistent within each manifold patch that
/// was inconsistent: outward where the patch is closed, else the side that most of its area faced. Consistent patches are left as they are:
/// a cavity keeps its meaning. Vertices and triangles come in canonical order (bake/canonical.h), so that nothing depends on the input's;
/// normals are dropped and parts are one run.
struct RepairedMesh {
  Mesh mesh;
  MeshDiagnosis found;
};

RepairedMesh repair(const Mesh& mesh);

/// Counts boundaryEdges again and says whether the mesh is closed: for those who turn triangles afterwards.
void countBoundary(const Mesh& mesh, MeshDiagnosis& found);

}  // namespace overcast
