#include "bake/bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace overcast {
namespace {

constexpr std::size_t kBins = 16;
constexpr std::size_t kFewBins = 8;  // for ranges of fewer than kFewPrimitives
constexpr std::uint32_t kFewPrimitives = 64;
constexpr std::uint32_t kSerialBelow = 4096;  // triangles: smaller ranges are built by one thread
constexpr int kMedianBelow = 30;              // depth from which ranges are halved, which bounds the depth of the whole
constexpr float kFar = 1e15f;                 // where unused slots lie; its square is still a float
constexpr double kRounding = 0x1p-23;         // twice what rounding to float can lose, relatively

/// Four lanes, the last unused: the compiler has vector minima and maxima for them.
typedef float Float4 __attribute__((vector_size(16)));
typedef std::int32_t Int4 __attribute__((vector_size(16)));

Float4 lower(Float4 a, Float4 b) {
  return a < b ? a : b;
}
Float4 upper(Float4 a, Float4 b) {
  return a > b ? a : b;
}

struct Bounds {
  Float4 low{kFar, kFar, kFar, kFar};
  Float4 high{-kFar, -kFar, -kFar, -kFar};
};

void include(Bounds& bounds, const Bounds& other) {
  bounds.low = lower(bounds.low, other.low);
  bounds.high = upper(bounds.high, other.high);
}

float area(const Bounds& bounds) {
  const Float4 size = bounds.high - bounds.low;
  return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

/// The box around a triangle; its number takes the unused lane of `low`.
struct Primitive {
  Float4 low;
  Float4 high;
};

Primitive makePrimitive(const Bounds& bounds, std::uint32_t triangle) {
  Primitive primitive{bounds.low, bounds.high};
  primitive.low[3] = std::bit_cast<float>(triangle);
  return primitive;
}

std::uint32_t triangleOf(const Primitive& primitive) {
  return std::bit_cast<std::uint32_t>(float{primitive.low[3]});
}

/// Twice the centre, with a fourth lane that means nothing.
Float4 centre(const Primitive& primitive) {
  return primitive.low + primitive.high;
}

/// A range of primitives with the box around them and the box around their (doubled) centres.
struct Range {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  Bounds bounds;
  Bounds centres;
};

/// A node of the binary tree that is built first: a leaf when `left` is negative, else the right child is left + 1.
struct BinaryNode {
  Bounds bounds;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::int32_t left = -1;
};

struct Builder {
  const Mesh& mesh;
  const Grid& grid;
  std::vector<glm::vec3> positions;  // of the mesh, in voxels
  std::vector<Primitive> primitives;
  std::unique_ptr<BinaryNode[]> nodes;
  std::atomic<std::int32_t> nodeCount = 1;
};

glm::dvec3 inVoxels(const Grid& grid, const glm::dvec3& position) {
  return (position - grid.origin) / grid.voxelSize;
}

/// Rounds positions, makes primitives of them and returns all.
Range makePrimitives(Builder& builder) {
  const auto inRanges = [](std::size_t count, const auto& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kSerialBelow), [&](const tbb::blocked_range<std::size_t>& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
    });
  };
  builder.positions.resize(builder.mesh.positions.size());
  inRanges(builder.positions.size(), [&](std::size_t i) { builder.positions[i] = inVoxels(builder.grid, builder.mesh.positions[i]); });
  builder.primitives.resize(builder.mesh.triangles.size());
  inRanges(builder.primitives.size(), [&](std::size_t i) {
    Bounds bounds;
    for (int k = 0; k < 3; ++k) {
      const glm::vec3& corner = builder.positions[builder.mesh.triangles[i][k]];
      const Float4 point{corner.x, corner.y, corner.z, 0.0f};
      include(bounds, {point, point});
    }
    builder.primitives[i] = makePrimitive(bounds, static_cast<std::uint32_t>(i));
  });
  Range all{0, static_cast<std::uint32_t>(builder.primitives.size()), {}, {}};
  for (const Primitive& primitive : builder.primitives) {
    include(all.bounds, {primitive.low, primitive.high});
    include(all.centres, {centre(primitive), centre(primitive)});
  }
  return all;
}

/// Up to kTreeWidth different positions in voxels. Triangles share corners by position, so that an unwelded mesh makes leaves as full as a
/// welded one.
struct VertexSet {
  Float4 position[3][kTreeWidth / 4];
  std::size_t size = 0;

  VertexSet() {
    for (auto& axis : position) std::fill(std::begin(axis), std::end(axis), Float4{kFar, kFar, kFar, kFar});
  }
  /// The place of `point`, which is added when new and there is room; kTreeWidth when there is none.
  std::size_t place(const glm::vec3& point) {
    Int4 same{};
    Int4 bit{1, 2, 4, 8};
    for (std::size_t i = 0; i < kTreeWidth / 4; ++i, bit <<= 4) {
      same |= (position[0][i] == point.x) & (position[1][i] == point.y) & (position[2][i] == point.z) & bit;
    }
    const std::int32_t found = same[0] | same[1] | same[2] | same[3];
    if (found != 0) return static_cast<std::size_t>(std::countr_zero(static_cast<std::uint32_t>(found)));
    if (size == kTreeWidth) return kTreeWidth;
    for (int axis = 0; axis < 3; ++axis) position[axis][size / 4][size % 4] = point[axis];
    return size++;
  }
};

/// Whether a range of at most kTreeWidth triangles has at most kTreeWidth vertices.
bool fewVertices(const Builder& builder, std::uint32_t first, std::uint32_t count) {
  if (3 * count <= kTreeWidth) return true;
  VertexSet vertices;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const glm::uvec3& corners = builder.mesh.triangles[triangleOf(builder.primitives[i])];
    for (int k = 0; k < 3; ++k) {
      if (vertices.place(builder.positions[corners[k]]) == kTreeWidth) return false;
    }
  }
  return true;
}

/// How primitives fall into bins along one axis.
struct Binning {
  int axis = 0;
  std::size_t bins = kBins;
  float start = 0.0f;
  float scale = 0.0f;

  explicit Binning(const Range& range) : bins(range.count < kFewPrimitives ? kFewBins : kBins) {
    const Bounds& centres = range.centres;
    const Float4 size = centres.high - centres.low;
    axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
    start = centres.low[axis];
    scale = size[axis] > 0.0f ? static_cast<float>(bins) * 0.9999f / size[axis] : 0.0f;
  }
  std::size_t bin(const Primitive& primitive) const {
    return std::min(static_cast<std::size_t>((centre(primitive)[axis] - start) * scale), bins - 1);
  }
};

/// Splits the range where the surface-area heuristic is lowest; in the middle of the order when all centres fall together or the tree is
/// deep already.
std::array<Range, 2> split(Builder& builder, const Range& range, int depth) {
  const Binning binning(range);
  std::array<Range, kBins> bins;
  for (std::uint32_t i = range.first; i < range.first + range.count; ++i) {
    const Primitive& primitive = builder.primitives[i];
    Range& bin = bins[binning.bin(primitive)];
    ++bin.count;
    include(bin.bounds, {primitive.low, primitive.high});
    include(bin.centres, {centre(primitive), centre(primitive)});
  }
  const auto join = [](Range& to, const Range& bin) {
    to.count += bin.count;
    include(to.bounds, bin.bounds);
    include(to.centres, bin.centres);
  };
  std::array<Range, kBins> right;  // right[i] holds bins i and above
  right[binning.bins - 1] = bins[binning.bins - 1];
  for (std::size_t i = binning.bins - 1; i-- > 0;) {
    right[i] = right[i + 1];
    join(right[i], bins[i]);
  }
  std::array<Range, 2> best;
  float bestCost = std::numeric_limits<float>::max();
  std::size_t bestBin = 0;
  Range left;
  for (std::size_t i = 1; i < binning.bins; ++i) {
    join(left, bins[i - 1]);
    if (left.count == 0 || right[i].count == 0) continue;
    const float cost = area(left.bounds) * static_cast<float>(left.count) + area(right[i].bounds) * static_cast<float>(right[i].count);
    if (cost >= bestCost) continue;
    bestCost = cost;
    bestBin = i;
    best = {left, right[i]};
  }
  if (bestBin == 0 || depth >= kMedianBelow) {
    best = {range, range};
    best[0].count = range.count / 2;
    best[1].count = range.count - best[0].count;
  } else {
    const auto begin = builder.primitives.begin() + range.first;
    std::partition(begin, begin + range.count, [&](const Primitive& primitive) { return binning.bin(primitive) < bestBin; });
  }
  best[0].first = range.first;
  best[1].first = range.first + best[0].count;
  return best;
}

void buildBinary(Builder& builder, std::int32_t index, const Range& range, int depth) {
  BinaryNode& node = builder.nodes[static_cast<std::size_t>(index)];
  node = {range.bounds, range.first, range.count, -1};
  if (range.count <= kTreeWidth && fewVertices(builder, range.first, range.count)) return;
  const std::array<Range, 2> halves = split(builder, range, depth);
  node.left = builder.nodeCount.fetch_add(2);
  const std::int32_t left = node.left;
  if (range.count < kSerialBelow) {
    buildBinary(builder, left, halves[0], depth + 1);
    buildBinary(builder, left + 1, halves[1], depth + 1);
  } else {
    tbb::parallel_invoke([&] { buildBinary(builder, left, halves[0], depth + 1); },
                         [&] { buildBinary(builder, left + 1, halves[1], depth + 1); });
  }
}

/// Opens the largest children of `index` until there are kTreeWidth or only leaves.
std::vector<std::int32_t> widen(const Builder& builder, std::int32_t index) {
  std::vector<std::int32_t> children{index};
  while (children.size() < kTreeWidth) {
    std::size_t largest = children.size();
    float largestArea = -1.0f;
    for (std::size_t i = 0; i < children.size(); ++i) {
      const BinaryNode& child = builder.nodes[static_cast<std::size_t>(children[i])];
      if (child.left < 0 || area(child.bounds) <= largestArea) continue;
      largest = i;
      largestArea = area(child.bounds);
    }
    if (largest == children.size()) break;
    const std::int32_t left = builder.nodes[static_cast<std::size_t>(children[largest])].left;
    children[largest] = left;
    children.insert(children.begin() + static_cast<std::ptrdiff_t>(largest) + 1, left + 1);
  }
  return children;
}

/// Appends the wide node made of binary node `index` and everything below; leaves are noted as ranges of primitives.
std::int32_t collapse(const Builder& builder, std::int32_t index, Tree& tree, std::vector<std::int32_t>& leafNodes) {
  const auto wide = static_cast<std::int32_t>(tree.nodes.size());
  tree.nodes.emplace_back();
  for (int axis = 0; axis < 3; ++axis) {
    std::fill_n(tree.nodes.back().low[axis], kTreeWidth, kFar);
    std::fill_n(tree.nodes.back().high[axis], kTreeWidth, kFar);
  }
  const std::vector<std::int32_t> children = widen(builder, index);
  for (std::size_t i = 0; i < children.size(); ++i) {
    const BinaryNode& child = builder.nodes[static_cast<std::size_t>(children[i])];
    std::int32_t target = 0;
    if (child.left < 0) {
      target = ~static_cast<std::int32_t>(leafNodes.size());
      leafNodes.push_back(children[i]);
    } else {
      target = collapse(builder, children[i], tree, leafNodes);
    }
    TreeNode& node = tree.nodes[static_cast<std::size_t>(wide)];
    node.child[i] = target;
    for (int axis = 0; axis < 3; ++axis) {
      node.low[axis][i] = child.bounds.low[axis] - tree.positionError;
      node.high[axis][i] = child.bounds.high[axis] + tree.positionError;
    }
  }
  return wide;
}

/// Squared radius of the smallest circle around a triangle whose longest edge runs from 0 to `base` on the first axis and whose third
/// corner is `c`.
double enclosingRadius2(double base, const glm::dvec2& c) {
  const double toMiddle = c.x - 0.5 * base;
  const double half2 = 0.25 * base * base;
  const double outside = toMiddle * toMiddle + c.y * c.y - half2;
  if (outside <= 0.0) return half2;
  const double up = outside / (2.0 * c.y);  // circumcentre above the middle of the base
  return half2 + up * up;
}

/// Any unit vector perpendicular to the unit vector `u`.
glm::dvec3 perpendicularTo(const glm::dvec3& u) {
  return glm::normalize(glm::cross(u, std::abs(u.x) < 0.5 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0)));
}

void store(float (&to)[3], const glm::dvec3& from) {
  for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(from[k]);
}

/// Fills `out` and returns the squared radius of the smallest enclosing circle. Corners in voxels.
double makeTriangle(const std::array<glm::dvec3, 3>& corners, TreeTriangle& out) {
  const std::array<glm::dvec3, 3> edges = {corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]};
  const std::array<double, 3> length2 = {glm::dot(edges[0], edges[0]), glm::dot(edges[1], edges[1]), glm::dot(edges[2], edges[2])};
  const auto longest = static_cast<std::size_t>(std::max_element(length2.begin(), length2.end()) - length2.begin());
  const std::size_t next = (longest + 1) % 3;
  const std::size_t last = (longest + 2) % 3;
  const double base = std::sqrt(length2[longest]);
  const glm::dvec3 a = corners[longest];
  const glm::dvec3 ac = -edges[last];
  const glm::dvec3 u = base > 0.0 ? edges[longest] / base : glm::dvec3(1.0, 0.0, 0.0);
  const glm::dvec3 normal = glm::cross(u, ac);
  const double height = glm::length(normal);
  const bool degenerate = !(height > 1e-9 * base);
  const glm::dvec3 w = degenerate ? perpendicularTo(u) : normal / height;
  store(out.a, a);
  store(out.aRest, a - glm::dvec3(out.a[0], out.a[1], out.a[2]));
  store(out.u, u);
  store(out.v, glm::cross(w, u));
  store(out.w, w);
  out.length0 = static_cast<float>(base);
  if (degenerate) {
    // The longest edge is all there is: edge 1 is put out of reach, which leaves no point inside, and edge 2 repeats edge 0.
    out.length1 = out.along1[0] = out.along1[1] = 0.0f;
    out.alongStart1 = kFar;
    out.innerStart1 = -kFar;
    out.length2 = out.length0;
    out.along2[0] = 1.0f;
    out.along2[1] = 0.0f;
    return 0.25 * base * base;
  }
  const glm::dvec2 c(glm::dot(ac, u), height);
  const double length1 = std::sqrt(length2[next]);
  const double lengthC = std::sqrt(length2[last]);
  const glm::dvec2 along1 = (c - glm::dvec2(base, 0.0)) / length1;
  const glm::dvec2 along2 = c / lengthC;
  out.length1 = static_cast<float>(length1);
  out.length2 = static_cast<float>(lengthC);
  out.along1[0] = static_cast<float>(along1.x);
  out.along1[1] = static_cast<float>(along1.y);
  out.alongStart1 = static_cast<float>(-along1.x * base);
  out.innerStart1 = static_cast<float>(along1.y * base);
  out.along2[0] = static_cast<float>(along2.x);
  out.along2[1] = static_cast<float>(along2.y);
  return enclosingRadius2(base, c);
}

void fillLeaf(const Builder& builder, const BinaryNode& range, Tree& tree, TreeLeaf& leaf) {
  VertexSet vertices;
  leaf = {};
  leaf.firstTriangle = range.first;
  for (std::uint32_t i = 0; i < range.count; ++i) {
    const std::uint32_t triangle = triangleOf(builder.primitives[range.first + i]);
    tree.order[range.first + i] = triangle;
    std::array<glm::dvec3, 3> corners;
    std::array<std::size_t, 3> slots;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = builder.mesh.triangles[triangle][static_cast<int>(k)];
      corners[k] = inVoxels(builder.grid, builder.mesh.positions[vertex]);
      slots[k] = vertices.place(builder.positions[vertex]);
      leaf.corners[i] |= 1u << slots[k];
    }
    const double radius2 = makeTriangle(corners, tree.triangles[range.first + i]);
    // Besides R^2: what the rounding of positions and of |p - v|^2, which is about R^2 when it matters, can do.
    const double error = tree.positionError;
    const auto slack = static_cast<float>(radius2 * (1.0 + 64.0 * kRounding) + 8.0 * error * (std::sqrt(radius2) + error));
    for (const std::size_t slot : slots) leaf.slack[slot] = std::max(leaf.slack[slot], slack);
  }
  static_assert(sizeof leaf.vertex == sizeof vertices.position);
  std::memcpy(leaf.vertex, vertices.position, sizeof leaf.vertex);
}

}  // namespace

Tree buildTree(const Mesh& mesh, const Grid& grid) {
  Tree tree;
  Builder builder{mesh, grid, {}, {}, {}};
  const std::size_t count = mesh.triangles.size();
  const Range all = makePrimitives(builder);
  double reach = glm::length(glm::dvec3(grid.size));
  for (int axis = 0; axis < 3; ++axis) {
    reach = std::max({reach, std::abs(double{all.bounds.low[axis]}), std::abs(double{all.bounds.high[axis]})});
  }
  OVERCAST_REQUIRE(reach < 1e12, "mesh reaches {} voxels from the grid's origin", reach);
  tree.positionError = static_cast<float>(kRounding * reach);
  builder.nodes = std::make_unique_for_overwrite<BinaryNode[]>(2 * count + 1);
  buildBinary(builder, 0, all, 0);
  std::vector<std::int32_t> leafNodes;
  collapse(builder, 0, tree, leafNodes);
  tree.leaves.resize(leafNodes.size());
  tree.triangles.resize(count);
  tree.order.resize(count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leafNodes.size(), 256), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      fillLeaf(builder, builder.nodes[static_cast<std::size_t>(leafNodes[i])], tree, tree.leaves[i]);
    }
  });
  return tree;
}

}  // namespace overcast
