// The grid of the global volume: where its voxels are in the world.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast {

/// Cubic voxels; voxel (i, j, k) has its centre at origin + voxelSize * (i + 0.5, j + 0.5, k + 0.5). Sides are multiples of 8.
/// Voxel coordinates count from the corner: a voxel's centre is at (i + 0.5, ...).
struct GlobalGrid {
  glm::dvec3 origin{0.0};  ///< world-space corner
  double voxelSize = 1.0;  ///< metres
  glm::ivec3 size{8};
};

/// `resolution` voxels (a multiple of 8) along the longest side of `bounds` after `padding` voxels are added at each end, the other sides
/// as many as they need, rounded up to a multiple of 8; centred on the box. An empty or pointlike box gives a cube of 1 m about its centre
/// (the origin when empty).
GlobalGrid globalGrid(const Box& bounds, int resolution, int padding = 4);

/// Voxel coordinates from world space.
glm::dmat4 voxelFromWorld(const GlobalGrid& grid);

/// World-space centre of the volume: where the runtime puts its origin, so that single floats keep their detail far from the world's.
glm::dvec3 centre(const GlobalGrid& grid);

}  // namespace overcast
