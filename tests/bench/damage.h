// Damage: closed meshes, and what becomes of them in the hands of others. What was inside before is known.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "formats/mesh.h"

namespace overcast::bench {

/// A closed sphere of 20,480 triangles with bumps and hollows, star-shaped.
Mesh pebble();

inline constexpr double kNoLid = std::numeric_limits<double>::infinity();

/// One way to be difficult. A point is inside when the winding number of `closed` is not zero there and its x is below `lid`. Points nearer
/// to `closed` than `moved` may be on either side: that far the damage moved the surface.
struct Damage {
  std::string name;
  Mesh mesh;            ///< as a user would bring it
  Mesh closed;          ///< as it was meant
  double lid = kNoLid;  ///< along the rows that some methods count crossings on
  double moved = 0.0;
};

/// The columns of the sign table, in its order, made of a closed mesh whose normals point outward and that is not self-intersecting;
/// lengths follow `voxel`. The same for the same mesh, voxel and seed.
std::vector<Damage> damages(const Mesh& closed, double voxel, std::uint64_t seed);

}  // namespace overcast::bench
