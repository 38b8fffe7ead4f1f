// Canonical: one order for all meshes that differ only in how their vertices, triangles and corners are listed. Private to bake.
#pragma once

#include <cstdint>

#include "formats/mesh.h"

namespace overcast {

/// The triangles of `mesh` with every position in use once (0 and -0 are equal), positions sorted by x, y, z, each triangle turned so that
/// its indices are the smallest of its three rotations, triangles sorted: whatever is computed from it does not depend on the order of the
/// input. Orientation is kept, and so are triangles that are there more than once. Normals are dropped and parts are one run. `merged`
/// becomes the number of positions in use that were equal to another. Runs on the calling TBB arena.
Mesh canonicalOrder(const Mesh& mesh, std::uint64_t& merged);
Mesh canonicalOrder(const Mesh& mesh);

}  // namespace overcast
