// Surface samples: points spread evenly over a mesh. Private to bake.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "bake/distance.h"
#include "formats/mesh.h"

namespace overcast {

struct SurfaceSamples {
  std::vector<glm::dvec3> points;
  std::vector<glm::dvec3> normals;  ///< unit, of the triangle
  std::vector<std::uint32_t> triangle;
};

/// About `count` points, one for every share of the area in the order of the triangles, somewhere in its triangle. Triangles that are
/// marked in `skip` (one entry each, or none) count for nothing. None at all on a mesh without area.
SurfaceSamples sampleSurface(const Mesh& mesh, std::size_t count, std::span<const std::uint8_t> skip = {});

/// A grid of 64 cells along the longest side about the mesh, for the lattice that windingAt works on.
Grid latticeGrid(const Mesh& mesh);

}  // namespace overcast
