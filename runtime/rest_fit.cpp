#include "runtime/rest_fit.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "formats/result.h"

namespace overcast {
namespace {

constexpr int kFewestCuts = 2, kMostCuts = 16;  // of an edge
constexpr double kToStart = 0.01;               // share of a vertex's area that is left to its own value
constexpr int kMostSteps = 64;
constexpr double kDone = 1e-8;  // of the squared residual

/// Centres of the pieces of a triangle whose edges are cut into `cuts`.
void addSpots(const glm::uvec3& corner, float area, int cuts, std::vector<SurfaceSpot>& spots) {
  const auto piece = [&](float i, float j) {
    const float n = static_cast<float>(cuts), a = i / n, b = j / n;
    spots.push_back({corner, {1.0f - a - b, a, b}, area / (n * n)});
  };
  const float third = 1.0f / 3.0f;
  for (int i = 0; i < cuts; ++i)
    for (int j = 0; i + j < cuts; ++j) {
      piece(static_cast<float>(i) + third, static_cast<float>(j) + third);
      if (i + j + 1 < cuts) piece(static_cast<float>(i) + 2.0f * third, static_cast<float>(j) + 2.0f * third);
    }
}

/// The normal equations, which are never written down: A x = sum of area w (w . x) over the spots, and x times its own weight.
struct System {
  std::span<const SurfaceSpot> spots;
  std::vector<double> diagonal;  ///< what a vertex trusts its own value
  std::vector<double> right;

  std::vector<double> times(const std::vector<double>& x) const {
    std::vector<double> result(x.size());
    for (std::size_t v = 0; v < x.size(); ++v) result[v] = diagonal[v] * x[v];
    for (const SurfaceSpot& spot : spots) {
      double sum = 0.0;
      for (int c = 0; c < 3; ++c) sum += double{spot.weight[c]} * x[spot.corner[c]];
      for (int c = 0; c < 3; ++c) result[spot.corner[c]] += double{spot.area} * spot.weight[c] * sum;
    }
    return result;
  }
};

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Conjugate gradients (Hestenes and Stiefel 1952), each unknown scaled by `scale`.
void solve(const System& system, const std::vector<double>& scale, std::vector<double>& x) {
  std::vector<double> residual = system.times(x);
  for (std::size_t i = 0; i < x.size(); ++i) residual[i] = system.right[i] - residual[i];
  std::vector<double> scaled(x.size());
  const auto precondition = [&] {
    for (std::size_t i = 0; i < x.size(); ++i) scaled[i] = residual[i] * scale[i];
  };
  precondition();
  std::vector<double> direction = scaled;
  double size = product(residual, scaled);
  const double enough = kDone * size;
  for (int step = 0; step < kMostSteps && size > enough; ++step) {
    const std::vector<double> image = system.times(direction);
    const double along = product(direction, image);
    if (!(along > 0.0)) return;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += size / along * direction[i];
    for (std::size_t i = 0; i < x.size(); ++i) residual[i] -= size / along * image[i];
    precondition();
    const double next = product(residual, scaled);
    for (std::size_t i = 0; i < x.size(); ++i) direction[i] = scaled[i] + next / size * direction[i];
    size = next;
  }
}

}  // namespace

std::vector<SurfaceSpot> spotsOver(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles, float longest) {
  std::vector<SurfaceSpot> spots;
  for (const glm::uvec3& corner : triangles) {
    const glm::vec3 a = positions[corner.x], b = positions[corner.y], c = positions[corner.z];
    const float edge = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    const float area = glm::length(glm::cross(b - a, c - a));
    if (!(edge > longest) || !(area > 0.0f)) continue;
    const float cuts = std::ceil(std::min(edge / longest, static_cast<float>(kMostCuts)));
    addSpots(corner, area, std::clamp(static_cast<int>(cuts), kFewestCuts, kMostCuts), spots);
  }
  return spots;
}

std::vector<float> fittedTo(std::vector<float> start, std::span<const SurfaceSpot> spots, std::span<const float> seen) {
  OVERCAST_REQUIRE(spots.size() == seen.size(), "{} values for {} spots", seen.size(), spots.size());
  std::vector<float> low = start, high = start;
  std::vector<double> scale(start.size(), 0.0), x(start.begin(), start.end());
  System system{spots, scale, scale};
  for (std::size_t s = 0; s < spots.size(); ++s)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t v = spots[s].corner[c];
      const double share = double{spots[s].area} * spots[s].weight[c];
      system.diagonal[v] += kToStart * share;
      system.right[v] += share * seen[s];
      scale[v] += share * spots[s].weight[c];
      if (!(spots[s].area > 0.0f)) continue;
      low[v] = std::min(low[v], seen[s]);
      high[v] = std::max(high[v], seen[s]);
    }
  for (std::size_t v = 0; v < start.size(); ++v) {
    if (system.diagonal[v] == 0.0) system.diagonal[v] = 1.0;  // around no spot
    system.right[v] += system.diagonal[v] * start[v];
    scale[v] = 1.0 / (scale[v] + system.diagonal[v]);
  }
  solve(system, scale, x);
  for (std::size_t v = 0; v < start.size(); ++v) start[v] = std::clamp(static_cast<float>(x[v]), low[v], high[v]);
  return start;
}

}  // namespace overcast
