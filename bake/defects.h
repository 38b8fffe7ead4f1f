// Defects: what is wrong with a mesh and what became of it, by name.
#pragma once

#include <string>
#include <vector>

#include "bake/scene_bake.h"

namespace overcast {

/// One thing that was found. `name` is one of open, inconsistent, unoriented, inside-out, non-manifold, self-intersecting, duplicates,
/// degenerate, interior-walls, components, soup, thin, sheets, undecided; `text` says how much of it there is and what was done, in one
/// line without the mesh's name.
struct Defect {
  std::string name;
  std::string text;
};

/// Everything found in a mesh that was baked; empty for a clean one. A terrain is an open sheet by design: of it nothing is said that
/// follows from that (open, undecided, thin, self-intersecting, interior-walls).
std::vector<Defect> defectsOf(const MeshBake& mesh);

}  // namespace overcast
