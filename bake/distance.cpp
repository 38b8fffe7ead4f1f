#include "bake/distance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

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

std::size_t volume(const glm::ivec3& size) {
  return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
}

std::size_t indexIn(const glm::ivec3& size, const glm::ivec3& at) {
  return static_cast<std::size_t>(at.x) +
         static_cast<std::size_t>(size.x) *
             (static_cast<std::size_t>(at.y) + static_cast<std::size_t>(size.y) * static_cast<std::size_t>(at.z));
}

/// The i-th cell of a box of `size` cells, x fastest.
glm::ivec3 cellOf(const glm::ivec3& size, int i) {
  return {i % size.x, i / size.x % size.y, i / (size.x * size.y)};
}

/// Everything that the tiles of one call share.
struct Job {
  const Grid& grid;
  const DistanceKernel& kernel;
  KernelScene scene;
  glm::ivec3 blocks;                 // of the grid
  glm::ivec3 lattice;                // corners of the blocks
  std::vector<std::uint8_t> active;  // per block: whether it is computed
  std::vector<Witness> witnesses;    // per lattice point
  std::vector<float> distance;
};

Job makeJob(const Mesh& mesh, const Grid& grid, const Tree& tree, double band, Simd simd) {
  const glm::ivec3 blocks = (grid.size + (kBlock - 1)) / kBlock;
  return {grid,
          kernelFor(simd),
          {tree.nodes.data(),
           tree.leaves.get(),
           tree.triangles.get(),
           tree.order.data(),
           &mesh.positions[0].x,
           &mesh.triangles[0].x,
           tree.positionError,
           {grid.origin.x, grid.origin.y, grid.origin.z},
           grid.voxelSize,
           band},
          blocks,
          blocks + 1,
          std::vector<std::uint8_t>(volume(blocks), 1),
          std::vector<Witness>(volume(blocks + 1)),
          {}};
}

/// The mesh vertices nearest to the corners of active blocks.
void findWitnesses(Job& job) {
  tbb::parallel_for(0, job.lattice.y * job.lattice.z, [&](int row) {
    const glm::ivec3 start(0, row % job.lattice.y, row / job.lattice.y);
    std::vector<std::uint8_t> wanted(static_cast<std::size_t>(job.lattice.x));
    for (int around = 0; around < 4; ++around) {
      const glm::ivec3 beside = start - glm::ivec3(0, around & 1, around >> 1);
      if (beside.y < 0 || beside.z < 0 || beside.y >= job.blocks.y || beside.z >= job.blocks.z) continue;
      const std::uint8_t* active = &job.active[indexIn(job.blocks, beside)];
      for (std::size_t x = 0; x < static_cast<std::size_t>(job.blocks.x); ++x) {
        wanted[x] |= active[x];
        wanted[x + 1] |= active[x];
      }
    }
    job.kernel.witnessRow(job.scene, static_cast<float>(kBlock * start.y), static_cast<float>(kBlock * start.z), job.lattice.x,
                          wanted.data(), &job.witnesses[indexIn(job.lattice, start)]);
  });
}

void fillBlock(Job& job, const glm::ivec3& block, DistanceCost& cost) {
  const glm::ivec3 start = kBlock * block;
  const int first[3] = {start.x, start.y, start.z};
  const Witness* around[8];
  for (int i = 0; i < 8; ++i) around[i] = &job.witnesses[indexIn(job.lattice, block + glm::ivec3(i & 1, i >> 1 & 1, i >> 2))];
  alignas(64) float samples[kBlockSamples];
  job.kernel.block(job.scene, first, around, samples, cost);
  ++cost.packets;
  const glm::ivec3 end = glm::min(glm::ivec3(kBlock), job.grid.size - start);
  for (int z = 0; z < end.z; ++z) {
    for (int y = 0; y < end.y; ++y) {
      std::copy_n(samples + kBlock * (y + kBlock * z), end.x, &job.distance[indexIn(job.grid.size, start + glm::ivec3(0, y, z))]);
    }
  }
}

void add(DistanceCost& sum, const DistanceCost& cost) {
  const auto addTo = [](std::uint64_t& to, std::uint64_t what) { std::atomic_ref(to).fetch_add(what, std::memory_order_relaxed); };
  addTo(sum.packets, cost.packets);
  addTo(sum.nodes, cost.nodes);
  addTo(sum.leaves, cost.leaves);
  addTo(sum.vertices, cost.vertices);
  addTo(sum.triangles, cost.triangles);
}

/// Fills the active blocks of `job.distance` tile by tile; empties it when `progress` asks to stop.
void fillActive(Job& job, const Progress& progress, DistanceCost* total) {
  findWitnesses(job);
  const glm::ivec3 tiles = (job.blocks + (kTile - 1)) / kTile;
  const int tileCount = tiles.x * tiles.y * tiles.z;
  std::atomic<int> done = 0;
  std::atomic<bool> stopped = false;
  tbb::parallel_for(0, tileCount, [&](int tile) {
    if (stopped) return;
    const glm::ivec3 low = kTile * cellOf(tiles, tile);
    const glm::ivec3 size = glm::min(glm::ivec3(kTile), job.blocks - low);
    DistanceCost cost;
    for (int i = 0; i < size.x * size.y * size.z; ++i) {
      const glm::ivec3 block = low + cellOf(size, i);
      if (job.active[indexIn(job.blocks, block)] != 0) fillBlock(job, block, cost);
    }
    if (total != nullptr) add(*total, cost);
    if (progress && !progress(static_cast<double>(++done) / tileCount)) stopped = true;
  });
  if (stopped) job.distance.clear();
}

/// Marks the blocks with a sample within the band of a box around `low` .. `high` (voxels) whose distance to the plane of `triangle`, when
/// given, allows it too.
void activate(Job& job, const glm::vec3& low, const glm::vec3& high, const TreeTriangle* triangle) {
  const float reach = static_cast<float>(job.scene.band) + 8.0f * job.scene.positionError + 1e-3f;
  const glm::vec3 limit(job.blocks - 1);
  // Block b holds samples kBlock * b to kBlock * b + kBlock - 1.
  const glm::vec3 firstBlock = glm::floor((low - reach - static_cast<float>(kBlock - 1)) / static_cast<float>(kBlock));
  const glm::vec3 lastBlock = glm::floor((high + reach) / static_cast<float>(kBlock));
  if (glm::any(glm::lessThan(lastBlock, glm::vec3(0.0f))) || glm::any(glm::greaterThan(firstBlock, limit))) return;
  const glm::ivec3 first(glm::max(firstBlock, glm::vec3(0.0f)));
  const glm::ivec3 last(glm::min(lastBlock, limit));
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        if (triangle != nullptr) {
          const glm::vec3 from = static_cast<float>(kBlock) * glm::vec3(x, y, z) + 0.5f * static_cast<float>(kBlock - 1) -
                                 glm::vec3(triangle->a[0], triangle->a[1], triangle->a[2]);
          const float off = from.x * triangle->w[0] + from.y * triangle->w[1] + from.z * triangle->w[2];
          const float spread = std::abs(triangle->w[0]) + std::abs(triangle->w[1]) + std::abs(triangle->w[2]);
          if (std::abs(off) > (reach + 0.5f * static_cast<float>(kBlock - 1) * spread) * 1.0001f) continue;
        }
        std::atomic_ref(job.active[indexIn(job.blocks, {x, y, z})]).store(1, std::memory_order_relaxed);
      }
    }
  }
}

/// The box around those vertices of a leaf that `corners` names.
void boxOf(const TreeLeaf& leaf, std::uint32_t corners, glm::vec3& low, glm::vec3& high) {
  low = glm::vec3(std::numeric_limits<float>::max());
  high = -low;
  for (; corners != 0; corners &= corners - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(corners));
    const glm::vec3 vertex(leaf.vertex[0][i], leaf.vertex[1][i], leaf.vertex[2][i]);
    low = glm::min(low, vertex);
    high = glm::max(high, vertex);
  }
}

/// Marks the blocks that can hold a sample within the band: by leaf where a leaf is small, by triangle where it is not.
void activateBand(Job& job, const Tree& tree) {
  std::fill(job.active.begin(), job.active.end(), std::uint8_t{0});
  tbb::parallel_for(std::size_t{0}, tree.leafCount, [&](std::size_t i) {
    const TreeLeaf& leaf = tree.leaves[i];
    std::uint32_t corners = 0;
    for (const std::uint32_t ofTriangle : leaf.corners) corners |= ofTriangle;
    glm::vec3 low;
    glm::vec3 high;
    boxOf(leaf, corners, low, high);
    if (glm::all(glm::lessThan(high - low, glm::vec3(2 * kBlock)))) {
      activate(job, low, high, nullptr);
      return;
    }
    for (std::size_t k = 0; k < kTreeWidth && leaf.corners[k] != 0; ++k) {
      boxOf(leaf, leaf.corners[k], low, high);
      activate(job, low, high, &tree.triangles[leaf.firstTriangle + k]);
    }
  });
}

}  // namespace

std::uint64_t sampleCount(const Grid& grid) {
  return volume(grid.size);
}

std::vector<float> unsignedDistance(const Mesh& mesh, const Grid& grid, const Progress& progress, Simd simd, DistanceCost* cost) {
  OVERCAST_REQUIRE(!mesh.triangles.empty(), "distance to a mesh without triangles");
  const Tree tree = buildTree(mesh, grid);
  Job job = makeJob(mesh, grid, tree, kNoBand, simd);
  job.distance.resize(sampleCount(grid));
  fillActive(job, progress, cost);
  return std::move(job.distance);
}

std::vector<float> narrowBand(const Mesh& mesh, const Grid& grid, double bandVoxels, const Progress& progress, Simd simd,
                              DistanceCost* cost) {
  OVERCAST_REQUIRE(!mesh.triangles.empty(), "distance to a mesh without triangles");
  OVERCAST_REQUIRE(bandVoxels > 0.0, "band of {} voxels", bandVoxels);
  const Tree tree = buildTree(mesh, grid);
  Job job = makeJob(mesh, grid, tree, std::min(bandVoxels, kNoBand), simd);
  activateBand(job, tree);
  job.distance.resize(sampleCount(grid), static_cast<float>(bandVoxels * grid.voxelSize));
  fillActive(job, progress, cost);
  return std::move(job.distance);
}

}  // namespace overcast
