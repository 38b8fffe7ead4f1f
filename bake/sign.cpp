#include "bake/sign.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <numeric>

#include <tbb/parallel_for.h>

#include "bake/edges.h"
#include "bake/lattice.h"
#include "bake/winding.h"

namespace overcast {
namespace {

constexpr int kSlab = 4;  ///< grid layers per tile, and the side of a block of samples that shares a walk through the winding tree

/// On which side of the line a -> b the row at (y, z) lies: +1 left, -1 right. Never 0 unless a and b project to one point: ties are
/// broken as if the row stood at (y + e, z + e^2) for an infinitesimal e > 0. Exactly antisymmetric in a and b.
int side(const glm::ivec3& a, const glm::ivec3& b, const glm::ivec3& row, std::int64_t& twiceArea) {
  twiceArea = orientation(a, b, row);
  if (twiceArea != 0) return twiceArea > 0 ? 1 : -1;
  if (a.z != b.z) return b.z < a.z ? 1 : -1;
  return b.y > a.y ? 1 : b.y < a.y ? -1 : 0;
}

/// Index of the first sample at or behind the crossing (sum weights * x) / area, the weights adding up to area > 0. Exact.
std::int64_t firstSampleBehind(const std::int64_t (&weights)[3], const std::int64_t (&x)[3], std::int64_t area, std::int64_t unit) {
  double estimate = 0.0;
  for (int i = 0; i < 3; ++i) estimate += static_cast<double>(weights[i]) * static_cast<double>(x[i]);
  estimate /= static_cast<double>(area) * static_cast<double>(unit);
  // The estimate is off by less than 1e-7; only near a sample does that matter.
  if (std::abs(estimate - std::round(estimate)) > 1e-6) return static_cast<std::int64_t>(std::ceil(estimate));
  Int128 numerator = 0;
  for (int i = 0; i < 3; ++i) numerator += Int128{weights[i]} * x[i];
  const Int128 denominator = Int128{area} * unit;
  return static_cast<std::int64_t>(numerator / denominator) + (numerator % denominator > 0 ? 1 : 0);
}

/// The integer k with k * unit >= value, and the one with k * unit <= value; unit is a power of two.
std::int64_t ceilIndex(std::int64_t value, std::int64_t unit) {
  return (value + unit - 1) >> std::countr_zero(static_cast<std::uint64_t>(unit));
}
std::int64_t floorIndex(std::int64_t value, std::int64_t unit) {
  return value >> std::countr_zero(static_cast<std::uint64_t>(unit));
}

/// Signed crossings of grid rows with triangles, for the layers firstLayer .. firstLayer + layers - 1.
struct Slab {
  glm::ivec3 size{0};  ///< of the whole grid
  int firstLayer = 0;
  int layers = 0;
  std::vector<std::int32_t> counts;  ///< x fastest, layers * size.y rows
};

/// Marks where rows running towards +x cross the triangle: +1 where they enter its inner side, -1 where they leave.
void addCrossings(Slab& slab, const glm::ivec3& a, glm::ivec3 b, glm::ivec3 c, std::int64_t unit) {
  std::int64_t area = orientation(a, b, c);
  if (area == 0) return;
  const int weight = area < 0 ? 1 : -1;
  if (area < 0) {
    std::swap(b, c);
    area = -area;
  }
  const auto [lowY, highY] = std::minmax({a.y, b.y, c.y});
  const auto [lowZ, highZ] = std::minmax({a.z, b.z, c.z});
  const auto firstRow = std::max<std::int64_t>(ceilIndex(lowY, unit), 0);
  const auto lastRow = std::min<std::int64_t>(floorIndex(highY, unit), slab.size.y - 1);
  const auto firstLayer = std::max<std::int64_t>(ceilIndex(lowZ, unit), slab.firstLayer);
  const auto lastLayer = std::min<std::int64_t>(floorIndex(highZ, unit), slab.firstLayer + slab.layers - 1);
  const std::int64_t x[3] = {a.x, b.x, c.x};
  for (std::int64_t k = firstLayer; k <= lastLayer; ++k) {
    for (std::int64_t j = firstRow; j <= lastRow; ++j) {
      const glm::ivec3 row(0, static_cast<int>(j * unit), static_cast<int>(k * unit));
      std::int64_t weights[3];
      if (side(b, c, row, weights[0]) <= 0 || side(c, a, row, weights[1]) <= 0 || side(a, b, row, weights[2]) <= 0) continue;
      const std::int64_t sample = std::max<std::int64_t>(firstSampleBehind(weights, x, area, unit), 0);
      if (sample < slab.size.x)
        slab.counts[static_cast<std::size_t>(((k - slab.firstLayer) * slab.size.y + j) * slab.size.x + sample)] += weight;
    }
  }
}

/// Triangles sorted by the slabs they touch: triangles[start[s] .. start[s + 1]).
struct Bins {
  std::vector<std::size_t> start;
  std::vector<std::uint32_t> triangles;
};

Bins binTriangles(const Lattice& lattice, const std::vector<glm::uvec3>& triangles, int slabs) {
  const auto range = [&](const glm::uvec3& t) {
    const auto [low, high] = std::minmax({lattice.points[t.x].z, lattice.points[t.y].z, lattice.points[t.z].z});
    const std::int64_t last = std::min<std::int64_t>(floorIndex(high, lattice.unit * kSlab), slabs - 1);
    return std::pair(std::max<std::int64_t>(floorIndex(ceilIndex(low, lattice.unit), kSlab), 0), last);
  };
  Bins bins;
  bins.start.assign(static_cast<std::size_t>(slabs) + 1, 0);
  for (const glm::uvec3& t : triangles)
    for (auto [s, last] = range(t); s <= last; ++s) ++bins.start[static_cast<std::size_t>(s) + 1];
  std::partial_sum(bins.start.begin(), bins.start.end(), bins.start.begin());
  bins.triangles.resize(bins.start.back());
  std::vector<std::size_t> next(bins.start.begin(), bins.start.end() - 1);
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    for (auto [s, last] = range(triangles[i]); s <= last; ++s) bins.triangles[next[static_cast<std::size_t>(s)]++] = i;
  return bins;
}

/// Bound on the error of one tree node taken whole. The errors largely cancel: in sum 1e-3 at worst for a soup of 100,000 triangles.
constexpr double kTolerance = 1e-2;

/// What all slabs read and what they write.
struct Job {
  const Grid& grid;
  const Lattice& lattice;
  const std::vector<glm::uvec3>& triangles;  ///< of the mesh and of the fill: a closed chain
  const Bins& bins;
  const WindingTree& fill;
  SignField& result;
  std::vector<std::uint64_t> ambiguous;  ///< samples per slab
};

/// Takes the fill's share off the crossings of one block of samples and decides them.
void decideBlock(Job& job, const Slab& slab, glm::ivec3 first, glm::ivec3 last, std::uint64_t& ambiguous) {
  std::vector<glm::ivec3> points;
  std::vector<std::size_t> places;  // in the slab
  const int unit = static_cast<int>(job.lattice.unit);
  for (int k = first.z; k < last.z; ++k)
    for (int j = first.y; j < last.y; ++j)
      for (int i = first.x; i < last.x; ++i) {
        points.push_back(glm::ivec3(i, j, k) * unit);
        places.push_back((static_cast<std::size_t>(k - slab.firstLayer) * slab.size.y + j) * slab.size.x + i);
      }
  std::vector<double> fill(points.size(), 0.0);
  addWinding(job.fill, job.lattice.points, points, kTolerance, fill);
  const std::size_t offset = static_cast<std::size_t>(slab.firstLayer) * slab.size.y * slab.size.x;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double winding = std::abs(slab.counts[places[i]] - fill[i]);
    job.result.inside[offset + places[i]] = winding > 0.5;
    ambiguous += winding > 0.2 && winding < 0.8;
  }
}

void decideSlab(Job& job, int index) {
  const glm::ivec3 size = job.grid.size;
  Slab slab{size, index * kSlab, std::min(kSlab, size.z - index * kSlab), {}};
  slab.counts.assign(static_cast<std::size_t>(slab.layers) * size.y * size.x, 0);
  for (std::size_t i = job.bins.start[static_cast<std::size_t>(index)]; i < job.bins.start[static_cast<std::size_t>(index) + 1]; ++i) {
    const glm::uvec3 t = job.triangles[job.bins.triangles[i]];
    addCrossings(slab, job.lattice.points[t.x], job.lattice.points[t.y], job.lattice.points[t.z], job.lattice.unit);
  }
  for (auto row = slab.counts.begin(); row != slab.counts.end(); row += size.x) std::partial_sum(row, row + size.x, row);

  if (job.fill.root < 0) {
    const std::size_t offset = static_cast<std::size_t>(slab.firstLayer) * size.y * size.x;
    for (std::size_t i = 0; i < slab.counts.size(); ++i) job.result.inside[offset + i] = slab.counts[i] != 0;
    return;
  }
  const int lastLayer = slab.firstLayer + slab.layers;
  for (int j = 0; j < size.y; j += kSlab)
    for (int i = 0; i < size.x; i += kSlab)
      decideBlock(job, slab, {i, j, slab.firstLayer}, {std::min(i + kSlab, size.x), std::min(j + kSlab, size.y), lastLayer},
                  job.ambiguous[static_cast<std::size_t>(index)]);
}

}  // namespace

SignField signField(const Mesh& mesh, const Grid& grid, const Progress& progress) {
  const Lattice lattice = snap(mesh, grid);
  const std::vector<DirectedEdge> boundary = netBoundary(mesh.triangles);
  const WindingTree fill = fillBoundary(lattice.points, boundary);
  std::vector<glm::uvec3> triangles = mesh.triangles;
  triangles.insert(triangles.end(), fill.triangles.begin(), fill.triangles.end());
  const int slabs = (grid.size.z + kSlab - 1) / kSlab;
  const Bins bins = binTriangles(lattice, triangles, slabs);

  SignField result;
  result.method = boundary.empty() ? kSignedCrossings : kWindingNumber;
  result.inside.assign(sampleCount(grid), 0);
  Job job{grid, lattice, triangles, bins, fill, result, std::vector<std::uint64_t>(static_cast<std::size_t>(slabs), 0)};
  std::atomic<int> done = 0;
  std::atomic<bool> stopped = false;
  tbb::parallel_for(0, slabs, [&](int index) {
    if (stopped) return;
    decideSlab(job, index);
    if (progress && !progress(static_cast<double>(++done) / slabs)) stopped = true;
  });
  if (stopped) return {};
  const std::uint64_t ambiguous = std::accumulate(job.ambiguous.begin(), job.ambiguous.end(), std::uint64_t{0});
  result.ambiguous = static_cast<double>(ambiguous) / static_cast<double>(result.inside.size());
  return result;
}

std::vector<double> windingAt(const Mesh& mesh, const Grid& grid, std::span<const glm::dvec3> points) {
  const Lattice lattice = snap(mesh, grid);
  const WindingTree tree = windingTree(lattice.points, mesh.triangles);
  std::vector<double> winding(points.size(), 0.0);
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    const glm::ivec3 point = snapPoint(lattice, grid, points[i]);
    addWinding(tree, lattice.points, {&point, 1}, kTolerance, {&winding[i], 1});
  });
  return winding;
}

}  // namespace overcast
