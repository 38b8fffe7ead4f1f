// Outside: turns the pieces of a mesh so that they face what can be reached from far away. For meshes whose own orientation decides
// nothing.
#pragma once

#include <cstdint>

#include "bake/repair.h"

namespace overcast {

/// For open meshes of which the winding number leaves more than a hundredth of the space undecided (0.2 < |w| < 0.8), and for soups, most
/// of whose edges are boundary: floods a grid from its border through all samples further from the surface than most of a voxel, so that
/// gaps below about a voxel and a half hold; 64 samples along the longest side first, then 32 and 16 for wider gaps. Every piece of
/// consistent orientation whose triangles have the flooded space on one side and space that was not reached on the other is turned outward,
/// by the vote of their area. Kept only where less than half as much of the space is undecided, or against the flood, as before: so a
/// sheet, which encloses nothing, and a mesh whose orientation was right stay as they are. Returns how many triangles were turned;
/// `repaired.found` counts them, and its boundary is counted again. The mesh is centred at the origin. Same result for any thread count.
std::uint64_t orientByOutside(RepairedMesh& repaired);

}  // namespace overcast
