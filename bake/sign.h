// Sign: which grid points are inside a mesh. Knows nothing of magnitudes (bake/distance.h).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bake/distance.h"
#include "bake/progress.h"
#include "formats/mesh.h"

namespace overcast {

inline constexpr const char* kSignedCrossings = "signed-crossings";  ///< SignField::method of closed meshes
inline constexpr const char* kWindingNumber = "winding-number";      ///< and of meshes with boundary

/// Inside or outside for every grid point, and how it was decided.
struct SignField {
  std::vector<std::uint8_t> inside;  ///< 1 inside, 0 outside; x fastest
  std::string method;                ///< kSignedCrossings or kWindingNumber
  double ambiguous = 0.0;  ///< share of grid points with 0.2 < |w| < 0.8, where the winding number decides nothing; 0 for closed meshes
};

/// Inside by the non-zero rule: |w| > 1/2 with w the generalised winding number (Jacobson et al. 2013). For closed meshes w is an integer
/// and comes from signed crossings of the grid's rows with exact predicates (simulation of simplicity). A mesh with boundary edges is
/// closed by a fill surface first; w is the crossings of both less the fill's own winding number, which is smooth away from the boundary
/// and comes from a tree (bake/winding.h). Holds on self-intersecting, overlapping and inside-out closed meshes; exact up to rounding
/// vertices by 2^-24 of a voxel (grids of 32; 2^-19 for 1024) and, where there is a boundary, to about 1e-3 in w. `mesh` is welded
/// and consistently oriented where that is possible (bake/repair.h) and lies within 2^27 voxels of the grid. Same bytes for any thread
/// count. Stops early with an empty `inside` when `progress` says so.
SignField signField(const Mesh& mesh, const Grid& grid, const Progress& progress = {});

/// The winding number of `mesh` at points within the grid's box, for measuring: from a tree over the mesh's own triangles, another way
/// than signField takes (no rows, no fill, no crossings). Error about 1e-3. Runs on the calling TBB arena; same bytes for any thread count.
std::vector<double> windingAt(const Mesh& mesh, const Grid& grid, std::span<const glm::dvec3> points);

}  // namespace overcast
