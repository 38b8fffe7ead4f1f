// Mesh bisect: triangles cut in two, their neighbours too where they must be, so that no cracks open.
#pragma once

#include <cstdint>
#include <vector>

#include "formats/mesh.h"

namespace overcast {

struct Bisected {
  Mesh mesh;
  std::vector<std::uint32_t> from;  ///< per triangle of the mesh: the one it is a piece of
};

/// `mesh` with every triangle that `marked` (one for each, 0 or not) names cut in two across the middle of its longest edge, as are, by
/// further cuts, those that share a cut edge, also where creases or seams give its ends other vertices (longest-edge bisection, Rivara
/// 1984, "Algorithms for refining triangular grids suitable for adaptive and multigrid techniques"). The surface stays what it is; vertices
/// of the input stay at the front in their order, those in the middles of edges follow, with the mean of positions and texture coordinates
/// and the unit mean of normals. Parts keep their order. What was baked for the mesh (visibility, maps, levels) is dropped. Triangles
/// without area stay whole.
Bisected bisected(const Mesh& mesh, const std::vector<char>& marked);

}  // namespace overcast
