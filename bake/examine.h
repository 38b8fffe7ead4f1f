// Examine: what is wrong with the surface of a mesh that its edges do not tell (bake/repair.h): where it passes through itself, where it is
// thin, and which of it lies inside. Bounded work however large the mesh is.
#pragma once

#include <cstdint>

#include "bake/repair.h"

namespace overcast {

struct SurfaceReport {
  std::uint64_t edges = 0;          ///< of the mesh
  std::uint64_t edgesChecked = 0;   ///< of these, all up to 200,000, else that many evenly through the list
  std::uint64_t edgesPiercing = 0;  ///< of those checked: they pass through a triangle that shares no vertex with them
  double thin = 0.0;                ///< what was looked for, local units
  double thinShare = 0.0;           ///< of the area: the surface's other side lies less than `thin` behind it
  double innerShare = 0.0;          ///< of the area: interior walls, both of whose sides are inside
};

/// Looks at a repaired mesh about the origin that has a triangle: edges by rays, thickness at 2,048 and both sides at 1,024 points of the
/// surface. `innerShare` stays 0 for a mesh of one component without piercing edges. Single floats: edges that touch within 1e-3
/// of their length from an end do not count, nor do triangles that overlap in one plane. Runs on the calling TBB arena; same result for any
/// thread count.
SurfaceReport examineSurface(const RepairedMesh& repaired, double thin);

}  // namespace overcast
