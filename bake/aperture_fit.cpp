#include "bake/aperture_fit.h"

#include <algorithm>
#include <array>
#include <vector>

#include <Eigen/Sparse>
#include <glm/geometric.hpp>

#include "formats/result.h"

namespace overcast {
namespace {

constexpr double kToStart = 0.05;      // samples' worth of trust in a vertex's own value
constexpr double kToNeighbour = 0.05;  // and in each edge
constexpr int kComponents = 14;        // direction, radius, ambient, transfer

using Row = std::array<double, kComponents>;

Row rowOf(const ApertureSample& sample) {
  Row row = {sample.direction.x, sample.direction.y, sample.direction.z, sample.radius, sample.ambient};
  std::copy(sample.transfer.begin(), sample.transfer.end(), row.begin() + 5);
  return row;
}

ApertureSample sampleOf(const Row& row, const glm::dvec3& fallback) {
  ApertureSample sample;
  const glm::dvec3 direction(row[0], row[1], row[2]);
  const double length = glm::length(direction);
  sample.direction = length > 1e-3 ? direction / length : fallback;
  sample.radius = row[3];
  sample.ambient = row[4];
  std::copy(row.begin() + 5, row.end(), sample.transfer.begin());
  return sample;
}

using Matrix = Eigen::SparseMatrix<double>;
using Values = Eigen::Matrix<double, Eigen::Dynamic, kComponents>;

struct System {
  std::vector<Eigen::Triplet<double>> entries;
  Values right;

  void couple(std::uint32_t i, std::uint32_t j, double value) { entries.emplace_back(static_cast<int>(i), static_cast<int>(j), value); }
};

System normalEquations(std::span<const ApertureSample> start, std::span<const glm::uvec3> triangles, std::span<const FitSample> samples) {
  System system;
  system.right = Values::Zero(static_cast<Eigen::Index>(start.size()), kComponents);
  const auto addRight = [&](std::uint32_t vertex, const Row& row, double weight) {
    for (int c = 0; c < kComponents; ++c) system.right(static_cast<Eigen::Index>(vertex), c) += weight * row[static_cast<std::size_t>(c)];
  };
  for (const FitSample& sample : samples) {
    const Row row = rowOf(sample.seen);
    for (int a = 0; a < 3; ++a) {
      addRight(sample.corner[a], row, sample.weight[a]);
      for (int b = 0; b < 3; ++b) system.couple(sample.corner[a], sample.corner[b], sample.weight[a] * sample.weight[b]);
    }
  }
  for (std::uint32_t v = 0; v < start.size(); ++v) {
    addRight(v, rowOf(start[v]), kToStart);
    system.couple(v, v, kToStart);
  }
  for (const glm::uvec3& t : triangles) {
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t i = t[c], j = t[(c + 1) % 3];
      if (i == j) continue;
      system.couple(i, i, 0.5 * kToNeighbour);
      system.couple(j, j, 0.5 * kToNeighbour);
      system.couple(i, j, -0.5 * kToNeighbour);
      system.couple(j, i, -0.5 * kToNeighbour);
    }
  }
  return system;
}

/// Smallest and largest of each component around every vertex.
struct Ranges {
  std::vector<Row> low, high;
};

Ranges rangesAround(std::span<const ApertureSample> start, std::span<const FitSample> samples) {
  Ranges ranges;
  for (const ApertureSample& own : start) ranges.low.push_back(rowOf(own));
  ranges.high = ranges.low;
  for (const FitSample& sample : samples) {
    const Row row = rowOf(sample.seen);
    for (int a = 0; a < 3; ++a) {
      Row& low = ranges.low[sample.corner[a]];
      Row& high = ranges.high[sample.corner[a]];
      for (std::size_t c = 0; c < kComponents; ++c) {
        low[c] = std::min(low[c], row[c]);
        high[c] = std::max(high[c], row[c]);
      }
    }
  }
  return ranges;
}

}  // namespace

std::vector<ApertureSample> fitApertures(std::span<const ApertureSample> start, std::span<const glm::uvec3> triangles,
                                         std::span<const FitSample> samples) {
  const auto count = static_cast<Eigen::Index>(start.size());
  const System system = normalEquations(start, triangles, samples);
  Matrix matrix(count, count);
  matrix.setFromTriplets(system.entries.begin(), system.entries.end());
  const Eigen::SimplicialLDLT<Matrix> solver(matrix);
  OVERCAST_REQUIRE(solver.info() == Eigen::Success, "{} unknowns have no positive definite system", start.size());
  const Values solved = solver.solve(system.right);
  const Ranges ranges = rangesAround(start, samples);
  std::vector<ApertureSample> fitted;
  for (std::size_t v = 0; v < start.size(); ++v) {
    Row row;
    for (std::size_t c = 0; c < kComponents; ++c)
      row[c] = std::clamp(solved(static_cast<Eigen::Index>(v), static_cast<Eigen::Index>(c)), ranges.low[v][c], ranges.high[v][c]);
    fitted.push_back(sampleOf(row, start[v].direction));
  }
  return fitted;
}

}  // namespace overcast
