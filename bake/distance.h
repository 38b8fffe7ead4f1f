// Distance: the exact unsigned distance from grid points to the triangles of a mesh. Knows nothing of inside and outside (bake/sign.h).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "bake/progress.h"
#include "formats/mesh.h"

namespace overcast {

/// A regular grid of points origin + voxelSize * (i, j, k), 0 <= i < size.x and so on.
struct Grid {
  glm::ivec3 size{0};
  glm::dvec3 origin{0.0};
  double voxelSize = 0.0;
};

/// Samples in the grid.
std::uint64_t sampleCount(const Grid& grid);

/// Which instruction set computes. What the machine lacks is replaced by the next smaller one.
enum class Simd { automatic, portable, avx2, avx512 };

/// What a call cost, for benches. Counts are the same for any thread count.
struct DistanceCost {
  std::uint64_t packets = 0;    ///< blocks of 4x4x4 samples, each of which shares every decision
  std::uint64_t nodes = 0;      ///< inner nodes of the tree that packets visited
  std::uint64_t leaves = 0;     ///< leaves, each of up to 16 triangles
  std::uint64_t vertices = 0;   ///< vertices tested against the samples of a packet
  std::uint64_t triangles = 0;  ///< triangles tested against some of the samples of a packet
};

/// |phi| at every grid point, x fastest. Exact closest point on the triangles (degenerate ones count as their segment or point), relative
/// error a few float ulps of the grid's diagonal: the nearest triangle is found in single floats, its distance taken in double. `mesh` has
/// at least one triangle and finite positions. Runs on the calling TBB arena over fixed tiles: same bytes for any thread count, and for
/// AVX2 and AVX-512; the portable variant rounds differently, so that another triangle may win a tie within those few ulps. Stops early
/// with an empty vector when `progress` says so.
std::vector<float> unsignedDistance(const Mesh& mesh, const Grid& grid, const Progress& progress = {}, Simd simd = Simd::automatic,
                                    DistanceCost* cost = nullptr);

/// The same where |phi| is at most `bandVoxels` * grid.voxelSize, and exactly float(bandVoxels * grid.voxelSize) elsewhere, at a fraction
/// of the work. `bandVoxels` is positive.
std::vector<float> narrowBand(const Mesh& mesh, const Grid& grid, double bandVoxels, const Progress& progress = {},
                              Simd simd = Simd::automatic, DistanceCost* cost = nullptr);

/// The distance from each point (finite, anywhere) to the triangles of `mesh`, in double: for measuring errors. Relative error about 1e-12
/// of the larger of distance and mesh diagonal. Runs on the calling TBB arena; same bytes for any thread count.
std::vector<double> distanceAt(const Mesh& mesh, std::span<const glm::dvec3> points);

}  // namespace overcast
