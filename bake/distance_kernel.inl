// The distance kernel, included by one file per instruction set. See distance_kernel.h; the ideas are told at `fillBlock`.
#pragma once

#include <cmath>

#include "bake/distance_kernel.h"
#include "bake/simd.h"
#include "bake/triangle.h"

namespace overcast::OVERCAST_SIMD {

constexpr int kSlice = kBlock * kBlock;
constexpr int kVectors = kBlockSamples / kLanes;  // of one block
constexpr int kSliceVectors = kSlice / kLanes;    // of one slice z = const
constexpr float kHalf = 0.5f * (kBlock - 1);      // half extent of a block's samples about its centre
constexpr Mask kAllSlices = (1u << kBlock) - 1;
constexpr int kStack = 1024;                 // (kTreeWidth - 1) times the depth of any tree, which is at most 30 + 31
constexpr float kRoundingOfSquares = 1e-6f;  // relative, several times what a squared distance can lose

/// Offsets of a slice's samples from the block's centre.
alignas(64) constexpr float kOffsetX[kSlice] = {-1.5f, -0.5f, 0.5f, 1.5f, -1.5f, -0.5f, 0.5f, 1.5f,
                                                -1.5f, -0.5f, 0.5f, 1.5f, -1.5f, -0.5f, 0.5f, 1.5f};
alignas(64) constexpr float kOffsetY[kSlice] = {-1.5f, -1.5f, -1.5f, -1.5f, -0.5f, -0.5f, -0.5f, -0.5f,
                                                0.5f,  0.5f,  0.5f,  0.5f,  1.5f,  1.5f,  1.5f,  1.5f};
constexpr float kOffsetZ[kBlock] = {-1.5f, -0.5f, 0.5f, 1.5f};

struct StackEntry {
  float squared;
  std::int32_t child;
};

/// The nearest vertex so far of a search from one point.
struct NearestVertex {
  float point[3];
  float squared;
  Witness witness;
};

static void visitLeaf(const TreeLeaf& leaf, NearestVertex& nearest) {
  alignas(64) float squared[kTreeWidth];
  for (int i = 0; i < kTreeWidth; i += kLanes) {
    const Floats dx = load(leaf.vertex[0] + i) - all(nearest.point[0]);
    const Floats dy = load(leaf.vertex[1] + i) - all(nearest.point[1]);
    const Floats dz = load(leaf.vertex[2] + i) - all(nearest.point[2]);
    store(squared + i, multiplyAdd(dx, dx, multiplyAdd(dy, dy, dz * dz)));
  }
  int best = -1;
  for (int i = 0; i < kTreeWidth; ++i) {
    if (squared[i] >= nearest.squared) continue;
    nearest.squared = squared[i];
    best = i;
  }
  if (best < 0) return;
  for (int axis = 0; axis < 3; ++axis) nearest.witness.position[axis] = leaf.vertex[axis][best];
  int triangle = 0;
  while ((leaf.corners[triangle] >> best & 1u) == 0) ++triangle;
  nearest.witness.triangle = static_cast<std::int32_t>(leaf.firstTriangle) + triangle;
}

/// Puts the children that may hold a nearer vertex on the stack, the nearest on top.
static int pushChildren(const TreeNode& node, const NearestVertex& nearest, StackEntry* stack, int top) {
  alignas(64) float squared[kTreeWidth];
  Mask open = 0;
  for (int i = 0; i < kTreeWidth; i += kLanes) {
    Floats sum = all(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
      const Floats p = all(nearest.point[axis]);
      const Floats gap = max(max(load(node.low[axis] + i) - p, p - load(node.high[axis] + i)), all(0.0f));
      sum = multiplyAdd(gap, gap, sum);
    }
    store(squared + i, sum);
    open |= bits(less(sum, all(nearest.squared))) << i;
  }
  const int bottom = top;
  for (; open != 0; open &= open - 1) {
    const int i = __builtin_ctz(open);
    int at = top++;
    for (; at > bottom && stack[at - 1].squared < squared[i]; --at) stack[at] = stack[at - 1];
    stack[at] = {squared[i], node.child[i]};
  }
  return top;
}

static void findNearestVertex(const KernelScene& scene, NearestVertex& nearest) {
  StackEntry stack[kStack];
  int top = pushChildren(scene.nodes[0], nearest, stack, 0);
  while (top > 0) {
    const StackEntry entry = stack[--top];
    if (entry.squared >= nearest.squared) continue;
    if (entry.child < 0) {
      visitLeaf(scene.leaves[~entry.child], nearest);
    } else {
      top = pushChildren(scene.nodes[entry.child], nearest, stack, top);
    }
  }
}

static void witnessRow(const KernelScene& scene, float y, float z, int count, const std::uint8_t* wanted, Witness* out) {
  NearestVertex nearest{{0.0f, y, z}, 3e38f, {}};
  bool warm = false;
  for (int i = 0; i < count; ++i) {
    if (wanted[i] == 0) continue;
    nearest.point[0] = static_cast<float>(kBlock * i);
    if (warm) {
      nearest.squared = 0.0f;
      for (int axis = 0; axis < 3; ++axis) {
        const float d = nearest.witness.position[axis] - nearest.point[axis];
        nearest.squared += d * d;
      }
    }
    findNearestVertex(scene, nearest);
    out[i] = nearest.witness;
    warm = true;
  }
}

/// A block at work. Positions are relative to its centre.
struct Block {
  const KernelScene& scene;
  DistanceCost& cost;
  float centre[3];
  int witnessCount = 0;
  float witness[8][3];       ///< different witnesses
  float witnessSlope[8][3];  ///< 2 kHalf witness
  float threshold[8];        ///< |witness|^2 + 3 kHalf^2 + margin
  float margin = 0.0f;       ///< for rounding, in squared voxels
  float band2 = 0.0f;        ///< squared band and margin
  alignas(64) float squared[kBlockSamples];
  alignas(64) std::int32_t nearest[kBlockSamples];
};

static bool samePlace(const Witness& a, const Witness& b) {
  return a.position[0] == b.position[0] && a.position[1] == b.position[1] && a.position[2] == b.position[2];
}

/// Starts every sample with the nearest of the witnesses, each of which is an upper bound, or with the band and no triangle.
static void startBlock(Block& block, const Witness* const (&around)[8]) {
  const Witness* different[8];
  int count = 0;
  for (const Witness* candidate : around) {
    bool known = false;
    for (int k = 0; k < count; ++k) known = known || samePlace(*candidate, *different[k]);
    if (!known) different[count++] = candidate;
  }
  block.witnessCount = count;
  float nearest2 = 3e38f;
  for (int k = 0; k < count; ++k) {
    float length2 = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      block.witness[k][axis] = different[k]->position[axis] - block.centre[axis];
      block.witnessSlope[k][axis] = 2.0f * kHalf * block.witness[k][axis];
      length2 += block.witness[k][axis] * block.witness[k][axis];
    }
    block.threshold[k] = length2;
    nearest2 = length2 < nearest2 ? length2 : nearest2;
  }
  const float reach = __builtin_sqrtf(nearest2) + 3.0f * kHalf;
  const float error = block.scene.positionError;
  const auto band = static_cast<float>(block.scene.band);
  block.margin = kRoundingOfSquares * reach * reach + 16.0f * error * (reach + error);
  block.band2 = band * band * (1.0f + kRoundingOfSquares) + block.margin;
  for (int k = 0; k < count; ++k) block.threshold[k] += 3.0f * kHalf * kHalf + block.margin;
  for (int s = 0; s < kVectors; ++s) {
    const int inSlice = s % kSliceVectors * kLanes;
    const Floats px = load(kOffsetX + inSlice);
    const Floats py = load(kOffsetY + inSlice);
    const Floats pz = all(kOffsetZ[s / kSliceVectors]);
    Floats best = all(block.band2);
    Ints triangle = all(std::int32_t{-1});
    for (int k = 0; k < count; ++k) {
      const Floats dx = px - all(block.witness[k][0]);
      const Floats dy = py - all(block.witness[k][1]);
      const Floats dz = pz - all(block.witness[k][2]);
      const Floats squared = multiplyAdd(dx, dx, multiplyAdd(dy, dy, dz * dz)) + all(block.margin);
      const Condition nearer = less(squared, best);
      best = min(best, squared);
      triangle = select(nearer, all(different[k]->triangle), triangle);
    }
    store(block.squared + s * kLanes, best);
    store(block.nearest + s * kLanes, triangle);
  }
}

/// The children that can hold a point nearer to some sample than the band and every witness. Against one witness q, |p - x|^2 - |p - q|^2
/// is linear in p, so its least value over block and box is taken axis by axis at the ends of the block.
static Mask openChildren(const Block& block, const TreeNode& node) {
  Mask open = 0;
  for (int i = 0; i < kTreeWidth; i += kLanes) {
    Floats fromHigh[3];
    Floats fromLow[3];
    Floats between = all(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
      const Floats low = load(node.low[axis] + i);
      const Floats high = load(node.high[axis] + i);
      const Floats blockHigh = all(block.centre[axis] + kHalf);
      const Floats blockLow = all(block.centre[axis] - kHalf);
      const Floats toHigh = max(max(low - blockHigh, blockHigh - high), all(0.0f));
      const Floats toLow = max(max(low - blockLow, blockLow - high), all(0.0f));
      const Floats gap = max(max(low - blockHigh, blockLow - high), all(0.0f));
      between = multiplyAdd(gap, gap, between);
      fromHigh[axis] = toHigh * toHigh;
      fromLow[axis] = toLow * toLow;
    }
    Mask some = bits(less(between, all(block.band2)));
    for (int k = 0; k < block.witnessCount && some != 0; ++k) {
      Floats sum = all(0.0f);
      for (int axis = 0; axis < 3; ++axis) {
        const Floats slope = all(block.witnessSlope[k][axis]);
        sum = sum + min(fromHigh[axis] + slope, fromLow[axis] - slope);
      }
      some &= bits(less(sum, all(block.threshold[k])));
    }
    open |= some << i;
  }
  return open;
}

static float dot(const float (&x)[3], const float (&y)[3]) {
  return multiplyAdd(x[0], y[0], multiplyAdd(x[1], y[1], x[2] * y[2]));
}

/// Tests one triangle against the samples of those vectors that `vectors` names (bits part * kBlock + slice).
static void testTriangle(Block& block, std::int32_t index, Mask vectors) {
  const TreeTriangle& t = block.scene.triangles[index];
  float a[3];
  for (int axis = 0; axis < 3; ++axis) a[axis] = (t.a[axis] - block.centre[axis]) + t.aRest[axis];
  const float u0 = -dot(t.u, a);
  const float v0 = -dot(t.v, a);
  const float w0 = -dot(t.w, a);
  const Floats zero = all(0.0f);
  const Floats uz = all(t.u[2]);
  const Floats vz = all(t.v[2]);
  const Floats wz = all(t.w[2]);
  for (int part = 0; part < kSliceVectors; ++part) {
    Mask slices = vectors >> (part * kBlock) & kAllSlices;
    if (slices == 0) continue;
    const Floats px = load(kOffsetX + part * kLanes);
    const Floats py = load(kOffsetY + part * kLanes);
    const Floats uStart = multiplyAdd(px, all(t.u[0]), multiplyAdd(py, all(t.u[1]), all(u0)));
    const Floats vStart = multiplyAdd(px, all(t.v[0]), multiplyAdd(py, all(t.v[1]), all(v0)));
    const Floats wStart = multiplyAdd(px, all(t.w[0]), multiplyAdd(py, all(t.w[1]), all(w0)));
    for (; slices != 0; slices &= slices - 1) {
      const int slice = __builtin_ctz(slices);
      const Floats pz = all(kOffsetZ[slice]);
      const Floats u = multiplyAdd(pz, uz, uStart);
      const Floats v = multiplyAdd(pz, vz, vStart);
      const Floats w = multiplyAdd(pz, wz, wStart);
      const Floats along1 = multiplyAdd(u, all(t.along1[0]), multiplyAdd(v, all(t.along1[1]), all(t.alongStart1)));
      const Floats inner1 = multiplySubtractFrom(u, all(t.along1[1]), multiplyAdd(v, all(t.along1[0]), all(t.innerStart1)));
      const Floats along2 = multiplyAdd(u, all(t.along2[0]), v * all(t.along2[1]));
      const Floats inner2 = multiplySubtractFrom(v, all(t.along2[0]), u * all(t.along2[1]));
      const Floats off0 = max(u - all(t.length0), min(u, zero));
      const Floats off1 = max(along1 - all(t.length1), min(along1, zero));
      const Floats off2 = max(along2 - all(t.length2), min(along2, zero));
      const Floats edge0 = multiplyAdd(off0, off0, v * v);
      const Floats edge1 = multiplyAdd(off1, off1, inner1 * inner1);
      const Floats edge2 = multiplyAdd(off2, off2, inner2 * inner2);
      const Condition outside = less(min(v, min(inner1, inner2)), zero);
      const Floats inPlane = select(outside, min(edge0, min(edge1, edge2)), zero);
      const Floats squared = multiplyAdd(w, w, inPlane);
      const int at = (slice * kSliceVectors + part) * kLanes;
      const Floats best = load(block.squared + at);
      const Condition nearer = less(squared, best);
      store(block.squared + at, min(best, squared));
      storeWhere(nearer, block.nearest + at, all(index));
    }
  }
  ++block.cost.triangles;
}

/// Those vertices of the leaf whose triangles may be nearer to some sample than every witness is (axis by axis as in openChildren).
/// Leaves their positions relative to the block in `relative` and |vertex|^2 - slack - margin in `reach`.
static Mask openVertices(const Block& block, const TreeLeaf& leaf, float (&relative)[3][kTreeWidth], float (&reach)[kTreeWidth]) {
  Mask open = 0;
  for (int i = 0; i < kTreeWidth; i += kLanes) {
    Floats vertex[3];
    Floats sum = all(0.0f) - load(leaf.slack + i);
    for (int axis = 0; axis < 3; ++axis) {
      vertex[axis] = load(leaf.vertex[axis] + i) - all(block.centre[axis]);
      store(relative[axis] + i, vertex[axis]);
      sum = multiplyAdd(vertex[axis], vertex[axis], sum);
    }
    store(reach + i, sum - all(block.margin));
    const Floats twice = all(2.0f * kHalf);
    Mask some = ~Mask{0};
    for (int k = 0; k < block.witnessCount && some != 0; ++k) {
      Floats least = sum;
      for (int axis = 0; axis < 3; ++axis) {
        least = multiplySubtractFrom(twice, absolute(vertex[axis] - all(block.witness[k][axis])), least);
      }
      some &= bits(less(least, all(block.threshold[k] - 3.0f * kHalf * kHalf)));
    }
    open |= some << i;
  }
  return open;
}

/// Of the vertices `open`, those whose triangles may be nearer to some sample than what it has so far, for every vector of samples
/// (numbered part * kBlock + slice).
static void closeVertices(Block& block, Mask open, const float (&relative)[3][kTreeWidth], const float (&reach)[kTreeWidth],
                          Mask (&close)[kVectors]) {
  for (Mask& ofVector : close) ofVector = 0;
  for (; open != 0; open &= open - 1) {
    const int i = __builtin_ctz(open);
    ++block.cost.vertices;
    const float vx = -2.0f * relative[0][i];
    const float vy = -2.0f * relative[1][i];
    const float vz = -2.0f * relative[2][i];
    for (int part = 0; part < kSliceVectors; ++part) {
      const Floats px = load(kOffsetX + part * kLanes);
      const Floats py = load(kOffsetY + part * kLanes);
      const Floats base = multiplyAdd(px, px + all(vx), multiplyAdd(py, py + all(vy), all(reach[i])));
      for (int slice = 0; slice < kBlock; ++slice) {
        const float z = kOffsetZ[slice];
        const Floats bound = base + all(z * (z + vz));
        const Condition nearer = less(bound, load(block.squared + (slice * kSliceVectors + part) * kLanes));
        close[part * kBlock + slice] |= static_cast<Mask>(any(nearer)) << i;
      }
    }
  }
}

static void testLeaf(Block& block, const TreeLeaf& leaf) {
  alignas(64) float relative[3][kTreeWidth];
  alignas(64) float reach[kTreeWidth];
  Mask vertices[kVectors];
  Mask triangles[kVectors];
  ++block.cost.leaves;
  const Mask open = openVertices(block, leaf, relative, reach);
  if (open == 0) return;
  closeVertices(block, open, relative, reach, vertices);
  Mask some = 0;
  for (int v = 0; v < kVectors; ++v) {
    triangles[v] = 0;
    for (int i = 0; i < kTreeWidth; i += kLanes) triangles[v] |= sharingBits(leaf.corners + i, vertices[v]) << i;
    some |= triangles[v];
  }
  for (; some != 0; some &= some - 1) {
    const int i = __builtin_ctz(some);
    Mask vectors = 0;
    for (int v = 0; v < kVectors; ++v) vectors |= (triangles[v] >> i & 1u) << v;
    testTriangle(block, static_cast<std::int32_t>(leaf.firstTriangle) + i, vectors);
  }
}

/// The corners of a triangle, one array per coordinate. A function of its own, because the compiler makes slow vectors of the look-ups.
__attribute__((noinline)) static void loadCorners(const KernelScene& scene, std::int32_t triangle, int sample,
                                                  double (&corner)[9][kBlockSamples]) {
  const std::uint32_t* corners = scene.corners + 3 * std::size_t{scene.order[triangle]};
  for (int k = 0; k < 3; ++k) {
    const double* position = scene.positions + 3 * std::size_t{corners[k]};
    for (int axis = 0; axis < 3; ++axis) corner[3 * k + axis][sample] = position[axis];
  }
}

/// The distances again in double, to the triangles that were found nearest.
static void refine(const Block& block, const int (&first)[3], float (&out)[kBlockSamples]) {
  const KernelScene& scene = block.scene;
  const double band = scene.band * scene.voxelSize;
  alignas(64) double corner[9][kBlockSamples];
  alignas(64) double point[3][kBlockSamples];
  for (int i = 0; i < kBlockSamples; ++i) {
    loadCorners(scene, block.nearest[i] < 0 ? 0 : block.nearest[i], i, corner);
    point[0][i] = scene.origin[0] + scene.voxelSize * (first[0] + i % kBlock);
    point[1][i] = scene.origin[1] + scene.voxelSize * (first[1] + i / kBlock % kBlock);
    point[2][i] = scene.origin[2] + scene.voxelSize * (first[2] + i / kSlice);
  }
  for (int i = 0; i < kBlockSamples; ++i) {
    const double p[3] = {point[0][i], point[1][i], point[2][i]};
    const double a[3] = {corner[0][i], corner[1][i], corner[2][i]};
    const double b[3] = {corner[3][i], corner[4][i], corner[5][i]};
    const double c[3] = {corner[6][i], corner[7][i], corner[8][i]};
    const double best = squaredDistanceToTriangle(p, a, b, c);
    const double distance = __builtin_sqrt(best);
    out[i] = static_cast<float>(block.nearest[i] < 0 || distance > band ? band : distance);
  }
}

static void fillBlock(const KernelScene& scene, const int (&first)[3], const Witness* const (&around)[8], float (&out)[kBlockSamples],
                      DistanceCost& cost) {
  Block block{scene, cost, {}, 0, {}, {}, {}, 0.0f, 0.0f, {}, {}};
  for (int axis = 0; axis < 3; ++axis) block.centre[axis] = static_cast<float>(first[axis]) + kHalf;
  startBlock(block, around);
  std::int32_t stack[kStack];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const TreeNode& node = scene.nodes[stack[--top]];
    ++cost.nodes;
    for (Mask open = openChildren(block, node); open != 0; open &= open - 1) {
      const std::int32_t child = node.child[__builtin_ctz(open)];
      if (child < 0) {
        testLeaf(block, scene.leaves[~child]);
      } else {
        stack[top++] = child;
      }
    }
  }
  refine(block, first, out);
}

}  // namespace overcast::OVERCAST_SIMD
