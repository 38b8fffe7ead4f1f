// Distance kernel: the inner loops of unsignedDistance, compiled once per instruction set. Plain pointers only: what these files inline
// must not meet code compiled for another instruction set. Private to bake.
#pragma once

#include <cstdint>

#include "bake/bvh.h"

namespace overcast {

constexpr int kBlock = 4;  // samples along the side of a block, the packet that shares every decision
constexpr int kBlockSamples = kBlock * kBlock * kBlock;

/// A vertex of the mesh near a point of the lattice, in voxels, and one triangle it belongs to: what the blocks around are started with.
struct Witness {
  float position[3];
  std::int32_t triangle;
};

/// Everything a kernel reads.
struct KernelScene {
  const TreeNode* nodes;
  const TreeLeaf* leaves;
  const TreeTriangle* triangles;
  const std::uint32_t* order;
  const double* positions;       ///< mesh.positions, three per vertex
  const std::uint32_t* corners;  ///< mesh.triangles, three per triangle
  float positionError;           ///< Tree::positionError
  double origin[3];
  double voxelSize;
  double band;  ///< in voxels: distances beyond come out as the band itself; kNoBand for none
};

constexpr double kNoBand = 1e15;

/// One variant. Both functions may be called from any number of threads.
struct DistanceKernel {
  const char* name;
  /// The mesh vertex nearest to each of `count` points (kBlock * i, y, z) where wanted[i] is not zero.
  void (*witnessRow)(const KernelScene& scene, float y, float z, int count, const std::uint8_t* wanted, Witness* out);
  /// Distances at the samples (x, y, z) + [0, kBlock)^3 in the mesh's units, x fastest. `around` are the witnesses at the eight corners
  /// (x, y, z) + {0, kBlock}^3.
  void (*block)(const KernelScene& scene, const int (&first)[3], const Witness* const (&around)[8], float (&out)[kBlockSamples],
                DistanceCost& cost);
};

extern const DistanceKernel kPortableKernel;
extern const DistanceKernel kAvx2Kernel;
extern const DistanceKernel kAvx512Kernel;

}  // namespace overcast
