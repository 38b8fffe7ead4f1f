// Peers: other ways to the same distance volumes, for the bench to compare with.
#pragma once

#include <cstdint>
#include <vector>

#include "bake/distance.h"
#include "formats/mesh.h"

namespace overcast::bench {

/// Embree point queries, one per sample, the radius started with the neighbour's distance plus one voxel; single floats.
std::vector<float> embreeDistance(const Mesh& mesh, const Grid& grid);

/// OpenVDB meshToVolume with a band of `bandVoxels` on both sides; absolute values, the band elsewhere.
std::vector<float> openvdbBand(const Mesh& mesh, const Grid& grid, double bandVoxels);

/// The same with a band of 3, extended over the whole box by fast sweeping (tools::maskSdf).
std::vector<float> openvdbSweep(const Mesh& mesh, const Grid& grid);

/// Samples that are negative in OpenVDB's level set of a band of 3, the rest of which its flood fill decides: 1 inside.
std::vector<std::uint8_t> openvdbInside(const Mesh& mesh, const Grid& grid);

/// The point of the mesh nearest to a sample.
struct NearestPoint {
  std::uint32_t triangle = 0;
  glm::dvec3 point{0.0};
};

/// Of every sample, by Embree point queries in single floats.
std::vector<NearestPoint> embreeNearest(const Mesh& mesh, const Grid& grid);

}  // namespace overcast::bench
