#include "bake/distance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>

#include <glm/common.hpp>

#include "bake/bvh.h"
#include "bake/distance_kernel.h"

namespace overcast {
namespace {

constexpr int kTile = 4;  // blocks along the side of a tile, which one thread fills

const DistanceKernel& kernelFor(Simd simd) {
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
  if (avx512 && (simd == Simd::automatic || simd == Simd::avx512)) return kAvx512Kernel;
  if (avx2 && simd != Simd::portable) return kAvx2Kernel;
  return kPortableKernel;
}

/// Everything that the tiles of one call share.
struct Job {
  const Grid& grid;
  const DistanceKernel& kernel;
  KernelScene scene;
  glm::ivec3 blocks;   // of the grid
  glm::ivec3 lattice;  // corners of the blocks
  std::vector<Witness> witnesses;
  std::vector<float>& distance;
};

std::size_t indexIn(const glm::ivec3& size, int x, int y, int z) {
  return static_cast<std::size_t>(x) +
         static_cast<std::size_t>(size.x) * (static_cast<std::size_t>(y) + static_cast<std::size_t>(size.y) * static_cast<std::size_t>(z));
}

void findWitnesses(Job& job) {
  job.witnesses.resize(static_cast<std::size_t>(job.lattice.x) * static_cast<std::size_t>(job.lattice.y) *
                       static_cast<std::size_t>(job.lattice.z));
  tbb::parallel_for(0, job.lattice.y * job.lattice.z, [&](int row) {
    const int y = row % job.lattice.y;
    const int z = row / job.lattice.y;
    job.kernel.witnessRow(job.scene, static_cast<float>(kBlock * y), static_cast<float>(kBlock * z), job.lattice.x,
                          &job.witnesses[indexIn(job.lattice, 0, y, z)]);
  });
}

void fillBlock(Job& job, const glm::ivec3& block, KernelCounters& counters) {
  const int first[3] = {kBlock * block.x, kBlock * block.y, kBlock * block.z};
  const Witness* around[8];
  for (int i = 0; i < 8; ++i)
    around[i] = &job.witnesses[indexIn(job.lattice, block.x + (i & 1), block.y + (i >> 1 & 1), block.z + (i >> 2))];
  alignas(64) float samples[kBlockSamples];
  job.kernel.block(job.scene, first, around, samples, counters);
  const glm::ivec3 end = glm::min(glm::ivec3(kBlock), job.grid.size - kBlock * block);
  for (int z = 0; z < end.z; ++z) {
    for (int y = 0; y < end.y; ++y) {
      std::copy_n(samples + kBlock * (y + kBlock * z), end.x, &job.distance[indexIn(job.grid.size, first[0], first[1] + y, first[2] + z)]);
    }
  }
}

}  // namespace

std::uint64_t sampleCount(const Grid& grid) {
  return static_cast<std::uint64_t>(grid.size.x) * static_cast<std::uint64_t>(grid.size.y) * static_cast<std::uint64_t>(grid.size.z);
}

std::vector<float> unsignedDistance(const Mesh& mesh, const Grid& grid, const Progress& progress, Simd simd) {
  OVERCAST_REQUIRE(!mesh.triangles.empty(), "distance to a mesh without triangles");
  const Tree tree = buildTree(mesh, grid);
  std::vector<float> distance(sampleCount(grid));
  const glm::ivec3 blocks = (grid.size + (kBlock - 1)) / kBlock;
  Job job{grid,
          kernelFor(simd),
          {tree.nodes.data(),
           tree.leaves.data(),
           tree.triangles.data(),
           tree.order.data(),
           &mesh.positions[0].x,
           &mesh.triangles[0].x,
           tree.positionError,
           {grid.origin.x, grid.origin.y, grid.origin.z},
           grid.voxelSize},
          blocks,
          blocks + 1,
          {},
          distance};
  findWitnesses(job);
  const glm::ivec3 tiles = (blocks + (kTile - 1)) / kTile;
  const int tileCount = tiles.x * tiles.y * tiles.z;
  std::atomic<int> done = 0;
  std::atomic<bool> stopped = false;
  tbb::parallel_for(0, tileCount, [&](int tile) {
    if (stopped) return;
    const glm::ivec3 low = kTile * glm::ivec3(tile % tiles.x, tile / tiles.x % tiles.y, tile / (tiles.x * tiles.y));
    const glm::ivec3 high = glm::min(low + kTile, blocks);
    KernelCounters counters;
    for (int z = low.z; z < high.z; ++z) {
      for (int y = low.y; y < high.y; ++y) {
        for (int x = low.x; x < high.x; ++x) fillBlock(job, {x, y, z}, counters);
      }
    }
    if (progress && !progress(static_cast<double>(++done) / tileCount)) stopped = true;
  });
  if (stopped) return {};
  return distance;
}

}  // namespace overcast
