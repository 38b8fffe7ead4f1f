#include "data/make/terrain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>
#include <random>
#include <utility>

#include <fmt/format.h>

namespace overcast {
namespace {

constexpr int kSide = 129;
constexpr double kSpacing = 10.0;   // metres
constexpr double kHighest = 260.0;  // metres above the border
constexpr int kSteps = 500;
constexpr double kUplift = 1.0;     // a step
constexpr double kErosion = 0.04;   // of a cell's own area, a step
constexpr double kRounding = 0.02;  // share by which heights become those around them, a step

using Grid = std::vector<double>;

std::size_t at(int x, int y) {
  return static_cast<std::size_t>(y * kSide + x);
}

// Smooth noise of `cells` cells along the side, -1 to 1.
Grid noise(int cells, std::uint32_t seed) {
  std::mt19937 random(seed);
  Grid knots(static_cast<std::size_t>((cells + 1) * (cells + 1)));
  for (double& knot : knots) knot = static_cast<double>(random()) / 2147483648.0 - 1.0;
  const auto knotAt = [&](int i, int j) { return knots[static_cast<std::size_t>(j * (cells + 1) + i)]; };
  const auto eased = [](double t) { return t * t * (3.0 - 2.0 * t); };
  Grid values(static_cast<std::size_t>(kSide * kSide));
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double u = static_cast<double>(x) * cells / (kSide - 1), v = static_cast<double>(y) * cells / (kSide - 1);
      const int i = std::min(static_cast<int>(u), cells - 1), j = std::min(static_cast<int>(v), cells - 1);
      const double s = eased(u - i), t = eased(v - j);
      const double north = knotAt(i, j) + s * (knotAt(i + 1, j) - knotAt(i, j));
      const double south = knotAt(i, j + 1) + s * (knotAt(i + 1, j + 1) - knotAt(i, j + 1));
      values[at(x, y)] = north + t * (south - north);
    }
  return values;
}

bool isBorder(int x, int y) {
  return x == 0 || y == 0 || x == kSide - 1 || y == kSide - 1;
}

// Where the water of each cell goes, and the cells in an order in which it comes before them: flooded from the border, lowest first.
struct Rivers {
  std::vector<std::size_t> order;
  std::vector<std::size_t> to;
};

Rivers riversOf(const Grid& heights) {
  Rivers rivers;
  rivers.to.resize(heights.size());
  std::vector<char> known(heights.size(), 0);
  std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>, std::greater<>> open;
  const auto flood = [&](std::size_t cell, std::size_t to, double level) {
    known[cell] = 1;
    rivers.to[cell] = to;
    open.emplace(std::max(heights[cell], level), cell);
  };
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (isBorder(x, y)) flood(at(x, y), at(x, y), heights[at(x, y)]);
  while (!open.empty()) {
    const auto [level, cell] = open.top();
    open.pop();
    rivers.order.push_back(cell);
    const int x = static_cast<int>(cell) % kSide, y = static_cast<int>(cell) / kSide;
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, kSide - 1); ++j)
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, kSide - 1); ++i)
        if (!known[at(i, j)]) flood(at(i, j), cell, level);
  }
  return rivers;
}

// One step of uplift and of rivers cutting down, implicit in time.
void erode(Grid& heights, const Grid& hardness) {
  const Rivers rivers = riversOf(heights);
  Grid area(heights.size(), 1.0);
  for (std::size_t n = rivers.order.size(); n-- > 0;) {
    const std::size_t cell = rivers.order[n];
    if (rivers.to[cell] != cell) area[rivers.to[cell]] += area[cell];
  }
  for (const std::size_t cell : rivers.order) {
    const std::size_t to = rivers.to[cell];
    if (to == cell) continue;
    const bool straight = cell % kSide == to % kSide || cell / kSide == to / kSide;
    const double cut = kErosion * hardness[cell] * std::sqrt(area[cell] + 3.0) / (straight ? 1.0 : std::sqrt(2.0));
    heights[cell] = (heights[cell] + kUplift + cut * heights[to]) / (1.0 + cut);
  }
}

void roundOff(Grid& heights) {
  const Grid before = heights;
  for (int y = 1; y + 1 < kSide; ++y)
    for (int x = 1; x + 1 < kSide; ++x) {
      const double around = before[at(x - 1, y)] + before[at(x + 1, y)] + before[at(x, y - 1)] + before[at(x, y + 1)];
      heights[at(x, y)] += kRounding * (around - 4.0 * before[at(x, y)]);
    }
}

}  // namespace

Mountains makeMountains() {
  Grid heights(static_cast<std::size_t>(kSide * kSide), 0.0), hardness(heights.size(), 1.0);
  const Grid broad = noise(4, 3), middle = noise(11, 5), fine = noise(64, 7);
  for (std::size_t i = 0; i < heights.size(); ++i) {
    heights[i] = 4.0 + 2.0 * broad[i] + middle[i] + 0.5 * fine[i];
    hardness[i] = 1.0 + 0.6 * broad[i] + 0.25 * middle[i];
  }
  for (int i = 0; i < kSide; ++i)
    for (const int edge : {0, kSide - 1}) heights[at(i, edge)] = heights[at(edge, i)] = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    erode(heights, hardness);
    roundOff(heights);
  }
  const double highest = *std::max_element(heights.begin(), heights.end());
  for (std::size_t i = 0; i < heights.size(); ++i) heights[i] *= kHighest / highest;
  return {kSide, kSpacing, std::move(heights)};
}

std::string esriGrid(const Mountains& mountains) {
  std::string text =
      fmt::format("ncols {0}\nnrows {0}\nxllcorner 0\nyllcorner 0\ncellsize {1}\nNODATA_value -9999\n", mountains.side, mountains.spacing);
  for (std::size_t i = 0; i < mountains.heights.size(); ++i) {
    const bool last = (i + 1) % static_cast<std::size_t>(mountains.side) == 0;
    text += fmt::format("{:.1f}{}", mountains.heights[i], last ? '\n' : ' ');
  }
  return text;
}

}  // namespace overcast
