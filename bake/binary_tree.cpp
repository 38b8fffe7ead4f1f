#include "bake/binary_tree.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <limits>

namespace overcast {
namespace {

constexpr std::size_t kBins = 16;
constexpr std::size_t kFewBins = 8;  // for ranges of fewer than kFewPrimitives
constexpr std::uint32_t kFewPrimitives = 64;
constexpr std::uint32_t kSerialBelow = 4096;  // triangles: smaller ranges are built by one thread and without the coarse grid
constexpr int kMedianBelow = 30;              // depth from which ranges are halved, which bounds the depth of the whole
constexpr unsigned kCellBits = 3;             // cells of the coarse grid: 2^kCellBits along each axis
constexpr unsigned kCells = 1u << (3 * kCellBits);

using Int4 __attribute__((vector_size(16))) = std::int32_t;

Float4 lower(Float4 a, Float4 b) {
  return a < b ? a : b;
}
Float4 upper(Float4 a, Float4 b) {
  return a > b ? a : b;
}

struct Bounds {
  Float4 low{kFarAway, kFarAway, kFarAway, kFarAway};
  Float4 high{-kFarAway, -kFarAway, -kFarAway, -kFarAway};
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

void include(Range& range, const Primitive& primitive) {
  ++range.count;
  include(range.bounds, {primitive.low, primitive.high});
  include(range.centres, {centre(primitive), centre(primitive)});
}

void include(Range& range, const Range& other) {
  range.count += other.count;
  include(range.bounds, other.bounds);
  include(range.centres, other.centres);
}

struct Builder {
  const std::vector<glm::vec3>& positions;
  const std::vector<glm::uvec3>& triangles;
  BinaryTree& tree;
  std::unique_ptr<Primitive[]> primitives;
  std::atomic<std::int32_t> nodeCount = 1;
};

/// Runs body(i) for i below `count` on the calling arena.
template <class Body>
void forEach(std::size_t count, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kSerialBelow), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
}

Range makePrimitives(Builder& builder) {
  const std::size_t count = builder.triangles.size();
  builder.primitives = std::make_unique_for_overwrite<Primitive[]>(count);
  forEach(count, [&](std::size_t i) {
    Bounds bounds;
    for (int k = 0; k < 3; ++k) {
      const glm::vec3& corner = builder.positions[builder.triangles[i][k]];
      const Float4 point{corner.x, corner.y, corner.z, 0.0f};
      include(bounds, {point, point});
    }
    bounds.low[3] = std::bit_cast<float>(static_cast<std::uint32_t>(i));
    builder.primitives[i] = {bounds.low, bounds.high};
  });
  Range all;
  for (std::size_t i = 0; i < count; ++i) include(all, builder.primitives[i]);
  return all;
}

/// Up to kTreeWidth different positions.
struct VertexSet {
  Float4 position[3][kTreeWidth / 4];
  std::uint32_t size = 0;

  VertexSet() {
    for (auto& axis : position) std::fill(std::begin(axis), std::end(axis), Float4{kFarAway, kFarAway, kFarAway, kFarAway});
  }
  /// The place of `point`, which is added when new and there is room; kTreeWidth when there is none.
  std::uint32_t place(const glm::vec3& point) {
    Int4 same{};
    Int4 bit{1, 2, 4, 8};
    for (std::size_t i = 0; i < kTreeWidth / 4; ++i, bit <<= 4) {
      same |= (position[0][i] == point.x) & (position[1][i] == point.y) & (position[2][i] == point.z) & bit;
    }
    const std::int32_t found = same[0] | same[1] | same[2] | same[3];
    if (found != 0) return static_cast<std::uint32_t>(std::countr_zero(static_cast<std::uint32_t>(found)));
    if (size == kTreeWidth) return kTreeWidth;
    for (int axis = 0; axis < 3; ++axis) position[axis][size / 4][size % 4] = point[axis];
    return size++;
  }
};

/// Whether a range makes a leaf: few triangles and few vertices. Notes their order and places then.
bool makeLeaf(Builder& builder, const Range& range) {
  if (range.count > kTreeWidth) return false;
  VertexSet vertices;
  for (std::uint32_t i = range.first; i < range.first + range.count; ++i) {
    const std::uint32_t triangle = triangleOf(builder.primitives[i]);
    std::uint32_t places = 0;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t place = vertices.place(builder.positions[builder.triangles[triangle][k]]);
      if (place == kTreeWidth) return false;
      places |= place << (4 * k);
    }
    builder.tree.order[i] = triangle;
    builder.tree.places[i] = static_cast<std::uint16_t>(places);
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
    const Float4 size = range.centres.high - range.centres.low;
    axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
    start = range.centres.low[axis];
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
  Primitive* const begin = builder.primitives.get() + range.first;
  Primitive* const end = begin + range.count;
  for (const Primitive* primitive = begin; primitive != end; ++primitive) include(bins[binning.bin(*primitive)], *primitive);
  std::array<Range, kBins> right;  // right[i] holds bins i and above
  right[binning.bins - 1] = bins[binning.bins - 1];
  for (std::size_t i = binning.bins - 1; i-- > 0;) {
    right[i] = right[i + 1];
    include(right[i], bins[i]);
  }
  std::array<Range, 2> best;
  float bestCost = std::numeric_limits<float>::max();
  std::size_t bestBin = 0;
  Range left;
  for (std::size_t i = 1; i < binning.bins; ++i) {
    include(left, bins[i - 1]);
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
    std::partition(begin, end, [&](const Primitive& primitive) { return binning.bin(primitive) < bestBin; });
  }
  best[0].first = range.first;
  best[1].first = range.first + best[0].count;
  return best;
}

/// Runs both, on two threads when there is enough to do.
template <class First, class Second>
void runBoth(std::uint32_t count, const First& first, const Second& second) {
  if (count < kSerialBelow) {
    first();
    second();
  } else {
    tbb::parallel_invoke(first, second);
  }
}

void buildRange(Builder& builder, std::int32_t index, const Range& range, int depth) {
  BinaryNode& node = builder.tree.nodes[static_cast<std::size_t>(index)];
  node = {range.bounds.low, range.bounds.high, range.first, range.count, -1};
  if (makeLeaf(builder, range)) return;
  const std::array<Range, 2> halves = split(builder, range, depth);
  const std::int32_t left = builder.nodeCount.fetch_add(2);
  node.left = left;
  runBoth(
      range.count, [&] { buildRange(builder, left, halves[0], depth + 1); }, [&] { buildRange(builder, left + 1, halves[1], depth + 1); });
}

/// Builds from the coarse grid's cells `first` .. `last` - 1, a power of two of them.
void buildCells(Builder& builder, std::int32_t index, const std::vector<Range>& cells, std::size_t first, std::size_t last, int depth) {
  Range all = cells[first];
  for (std::size_t i = first + 1; i < last; ++i) include(all, cells[i]);
  if (all.count < kSerialBelow || last - first == 1) {
    buildRange(builder, index, all, depth);
    return;
  }
  const std::size_t middle = (first + last) / 2;
  const auto isEmpty = [&](std::size_t from, std::size_t to) {
    return std::all_of(cells.begin() + static_cast<std::ptrdiff_t>(from), cells.begin() + static_cast<std::ptrdiff_t>(to),
                       [](const Range& cell) { return cell.count == 0; });
  };
  if (isEmpty(first, middle)) return buildCells(builder, index, cells, middle, last, depth);
  if (isEmpty(middle, last)) return buildCells(builder, index, cells, first, middle, depth);
  const std::int32_t left = builder.nodeCount.fetch_add(2);
  builder.tree.nodes[static_cast<std::size_t>(index)] = {all.bounds.low, all.bounds.high, all.first, all.count, left};
  runBoth(
      all.count, [&] { buildCells(builder, left, cells, first, middle, depth + 1); },
      [&] { buildCells(builder, left + 1, cells, middle, last, depth + 1); });
}

/// Sorts the primitives by the Morton code of their centres' cell and returns the cells.
std::vector<Range> sortIntoCells(Builder& builder, const Range& all) {
  const Float4 size = all.centres.high - all.centres.low;
  const float longest = std::max({size[0], size[1], size[2]});
  const float scale = longest > 0.0f ? static_cast<float>(1u << kCellBits) * 0.9999f / longest : 0.0f;
  const auto cellOf = [&](const Primitive& primitive) {
    const Float4 at = (centre(primitive) - all.centres.low) * scale;
    std::size_t code = 0;
    for (unsigned bit = kCellBits; bit-- > 0;) {
      for (int axis = 0; axis < 3; ++axis) code = 2 * code + (static_cast<std::size_t>(at[axis]) >> bit & 1);
    }
    return code;
  };
  std::vector<std::uint16_t> codes(all.count);
  std::vector<Range> cells(kCells);
  forEach(all.count, [&](std::size_t i) { codes[i] = static_cast<std::uint16_t>(cellOf(builder.primitives[i])); });
  for (std::uint32_t i = 0; i < all.count; ++i) include(cells[codes[i]], builder.primitives[i]);
  std::array<std::uint32_t, kCells> next;
  std::uint32_t first = 0;
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    next[cell] = cells[cell].first = first;
    first += cells[cell].count;
  }
  auto sorted = std::make_unique_for_overwrite<Primitive[]>(all.count);
  for (std::uint32_t i = 0; i < all.count; ++i) sorted[next[codes[i]]++] = builder.primitives[i];
  builder.primitives = std::move(sorted);
  return cells;
}

}  // namespace

float area(const BinaryNode& node) {
  return area(Bounds{node.low, node.high});
}

BinaryTree buildBinaryTree(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles) {
  BinaryTree tree{std::make_unique_for_overwrite<BinaryNode[]>(2 * triangles.size() + 1), {}, {}};
  tree.order.resize(triangles.size());
  tree.places.resize(triangles.size());
  Builder builder{positions, triangles, tree, {}};
  const Range all = makePrimitives(builder);
  if (all.count < kSerialBelow) {
    buildRange(builder, 0, all, 0);
  } else {
    buildCells(builder, 0, sortIntoCells(builder, all), 0, kCells, 0);
  }
  return tree;
}  // NOLINT(clang-analyzer-cplusplus.NewDeleteLeaks): the nodes leave with the tree

}  // namespace overcast
