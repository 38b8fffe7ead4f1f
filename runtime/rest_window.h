// RestWindow: the part of the global volume that an object alone fills.
#pragma once

#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/global_grid.h"

namespace overcast {

/// The part of `grid`, on the same voxels, outside of which the distance from `object` (whose record is for `grid`) is more than two
/// voxels: rays meet nothing there. Its sides are 32, 64, 128, ... voxels, all the same, but none is longer than the grid's: there are few
/// sizes, and `grid` itself is one.
GlobalGrid windowAbout(const GlobalGrid& grid, const shared::CompositeObject& object);

}  // namespace overcast
