// Sign methods: the ways others tell inside from outside, for the sign table. None shares code with bake/sign.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/distance.h"
#include "formats/mesh.h"

namespace overcast::bench {

/// One entry per sample of the grid, x fastest: 1 inside.
using Inside = std::vector<std::uint8_t>;

/// Rows along x: how many triangles were crossed, odd is inside.
Inside parityInside(const Mesh& mesh, const Grid& grid);

/// Rows along x: entries less exits, not zero is inside.
Inside crossingsInside(const Mesh& mesh, const Grid& grid);

/// The side of the nearest point's angle-weighted pseudonormal (Baerentzen and Aanaes 2005); equal positions are one vertex. The nearest
/// point comes from Embree.
Inside pseudonormalInside(const Mesh& mesh, const Grid& grid);

/// Fast winding number (Barill et al. 2018): dipoles with their first moment from twice a node's radius on, exact triangles nearer; inside
/// where its magnitude exceeds a half.
Inside fastWindingInside(const Mesh& mesh, const Grid& grid);

}  // namespace overcast::bench
