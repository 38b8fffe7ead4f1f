#include "bake/chart_atlas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "formats/aperture_map.h"

namespace overcast {
namespace {

constexpr int kGap = 3;  ///< texels that a rectangle has beyond the legs of its two triangles: bilinear sampling of one needs one beyond
                         ///< its longest edge, and both have their corners on texels
constexpr int kSmallestCell = 1 + kGap;

/// A triangle laid out: where the corner between its legs is, and how long these are.
struct Leaf {
  int apex = 0;               ///< corner of the triangle; the longer leg leads to ends[0]
  std::array<int, 2> ends{};  ///< the other corners
  glm::dvec2 length{0.0};     ///< of the legs, the first not shorter
};

Leaf leafOf(const Mesh& mesh, const glm::uvec3& t, double scale) {
  std::array<double, 3> opposite{};
  for (int c = 0; c < 3; ++c)
    opposite[static_cast<std::size_t>(c)] = glm::length((mesh.positions[t[(c + 1) % 3]] - mesh.positions[t[(c + 2) % 3]]) / scale);
  const auto apex = static_cast<int>(std::max_element(opposite.begin(), opposite.end()) - opposite.begin());
  Leaf leaf{apex, {(apex + 1) % 3, (apex + 2) % 3}, {0.0, 0.0}};
  leaf.length = {opposite[static_cast<std::size_t>(leaf.ends[1])], opposite[static_cast<std::size_t>(leaf.ends[0])]};
  if (leaf.length.x >= leaf.length.y) return leaf;
  std::swap(leaf.length.x, leaf.length.y);
  std::swap(leaf.ends[0], leaf.ends[1]);
  return leaf;
}

/// Texels along the legs at so many texels for a unit of length.
glm::ivec2 legsAt(const Leaf& leaf, double density, int side) {
  const auto texels = [&](double length) {
    return static_cast<int>(std::clamp(std::round(length * density), 1.0, static_cast<double>(side - kGap)));
  };
  return {texels(leaf.length.x), texels(leaf.length.y)};
}

/// Two triangles, or one, in a rectangle.
struct Cell {
  std::uint32_t first = 0;
  std::optional<std::uint32_t> second;
  glm::ivec2 low{0};
  glm::ivec2 legs{0};
};

/// Fills shelves from the top; nothing when the texture is too small. Triangles of like size lie side by side.
std::optional<std::vector<Cell>> shelves(const std::vector<Leaf>& leaves, double density, int side) {
  std::vector<glm::ivec2> legs;
  for (const Leaf& leaf : leaves) legs.push_back(legsAt(leaf, density, side));
  std::vector<std::uint32_t> order(leaves.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::array<std::int64_t, 3>{-legs[a].y, -legs[a].x, a} < std::array<std::int64_t, 3>{-legs[b].y, -legs[b].x, b};
  });
  std::vector<Cell> cells;
  glm::ivec2 at(0);
  int height = 0;
  for (std::size_t i = 0; i < order.size(); i += 2) {
    Cell cell{order[i], std::nullopt, at, legs[order[i]]};
    if (i + 1 < order.size()) {
      cell.second = order[i + 1];
      cell.legs = glm::max(cell.legs, legs[order[i + 1]]);
    }
    const glm::ivec2 size = cell.legs + kGap;
    if (at.x + size.x > side) at = {0, at.y + height};
    if (at.x == 0) height = size.y;
    if (at.x + size.x > side || at.y + size.y > side) return std::nullopt;
    cell.low = at;
    cells.push_back(cell);
    at.x += size.x;
  }
  return cells;
}

/// The cells at the highest density that fits, to within a hundredth.
std::optional<std::vector<Cell>> densest(const std::vector<Leaf>& leaves, int side, double& density) {
  double total = 0.0;
  for (const Leaf& leaf : leaves) total += 0.5 * leaf.length.x * leaf.length.y;
  density = 0.0;
  std::optional<std::vector<Cell>> best = shelves(leaves, 0.0, side);
  if (!best || !(total > 0.0)) return best;
  double low = 0.0, high = 2.0 * side / std::sqrt(total);
  for (int step = 0; step < 12; ++step) {
    const double middle = 0.5 * (low + high);
    auto cells = shelves(leaves, middle, side);
    (cells ? low : high) = middle;
    if (cells) best = std::move(cells);
  }
  density = low;
  return best;
}

void place(Mesh& mesh, const Leaf& leaf, std::uint32_t triangle, const glm::ivec2& corner, const glm::ivec2& legs, int side) {
  const auto put = [&](int c, const glm::ivec2& texel) {
    mesh.textureCoordinates[mesh.triangles[triangle][c]] = glm::vec2((glm::dvec2(texel) + 0.5) / static_cast<double>(side));
  };
  put(leaf.apex, corner);
  put(leaf.ends[0], {corner.x + legs.x, corner.y});
  put(leaf.ends[1], {corner.x, corner.y + legs.y});
}

/// The mesh with three vertices for every triangle.
Mesh splitMesh(const Mesh& mesh) {
  Mesh split{mesh.name, {}, {}, {}, mesh.parts};
  for (const glm::uvec3& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(split.positions.size());
    split.triangles.emplace_back(first, first + 1, first + 2);
    for (int c = 0; c < 3; ++c) {
      split.positions.push_back(mesh.positions[t[c]]);
      if (!mesh.normals.empty()) split.normals.push_back(mesh.normals[t[c]]);
    }
  }
  split.textureCoordinates.resize(split.positions.size(), glm::vec2(0.0f));
  return split;
}

}  // namespace

int smallestAtlas(std::size_t triangles) {
  int side = 16;
  const auto holds = [](int s) {
    const auto along = static_cast<std::size_t>(s / kSmallestCell);
    return 2 * along * along;
  };
  while (side < (1 << 16) && holds(side) < triangles) side *= 2;
  return side;
}

Result<Mesh> packTriangles(const Mesh& mesh, int side) {
  const std::size_t triangles = mesh.triangles.size();
  const double scale = diagonal(bounds(mesh));
  std::vector<Leaf> leaves;
  for (const glm::uvec3& t : mesh.triangles) leaves.push_back(leafOf(mesh, t, scale));
  double density = 0.0;
  const auto cells = densest(leaves, side, density);
  if (!cells) {
    const int enough = smallestAtlas(triangles);
    const std::string way = enough <= kLargestApertureMapSide ? fmt::format("--texels {} holds them", enough)
                                                              : fmt::format("and no map of up to {} does", kLargestApertureMapSide);
    return Error{"", "", fmt::format("{} triangles do not fit into an atlas of {} x {} texels, {}", triangles, side, side, way)};
  }
  Mesh packed = splitMesh(mesh);
  for (const Cell& cell : *cells) {
    place(packed, leaves[cell.first], cell.first, cell.low, legsAt(leaves[cell.first], density, side), side);
    if (!cell.second) continue;
    // Turned by half a turn, in the opposite corner of the rectangle.
    const glm::ivec2 far = cell.low + cell.legs + kGap - 1;
    place(packed, leaves[*cell.second], *cell.second, far, -legsAt(leaves[*cell.second], density, side), side);
  }
  return packed;
}

}  // namespace overcast
