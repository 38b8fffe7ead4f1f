// Sign: which grid points are inside a mesh. Knows nothing of magnitudes (bake/distance.h).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bake/distance.h"
#include "bake/progress.h"
#include "formats/mesh.h"

namespace overcast {

/// Inside or outside for every grid point, and how it was decided.
struct SignField {
  std::vector<std::uint8_t> inside;  ///< 1 inside, 0 outside; x fastest
  std::string method;                ///< "signed-crossings" for closed meshes, "winding-number" for meshes with boundary
  double ambiguous = 0.0;  ///< share of grid points with 0.2 < |w| < 0.8, where the winding number decides nothing; 0 for closed meshes
};

/// Inside by the non-zero rule: |w| > 1/2 with w the generalised winding number (Jacobson et al. 2013). For closed meshes w is an integer
/// and comes from signed row crossings with exact predicates (simulation of simplicity); with boundary edges the solid angle of the
/// boundary is added (MEASURED 7: the antipodal method). Holds on self-intersecting, overlapping and inside-out closed meshes. `mesh` is
/// welded and consistently oriented where that is possible (bake/repair.h). Same bytes for any thread count.
SignField signField(const Mesh& mesh, const Grid& grid, const Progress& progress = {});

}  // namespace overcast
