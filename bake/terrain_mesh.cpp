#include "bake/terrain_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "bake/terrain_grid.h"

namespace overcast {
namespace {

constexpr int kClusterHalvings = std::countr_zero(kClusterTriangles);
constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();

/// One patch of the tree.
struct Patch {
  GridTriangle triangle;
  std::size_t parent = 0;  ///< in the depth above
  std::uint32_t group = kNoLevelGroup;
  std::vector<glm::uvec3> triangles;
  double error = 0.0;
  Box box;  ///< of these triangles and of all finer ones
};

/// All patches of one depth of the tree, 0 the coarsest.
using Depth = std::vector<Patch>;

/// The tree without triangles: patches beyond the grid are left out.
std::vector<Depth> patchTree(const TerrainGrid& grid) {
  // Roots as large as the shorter side, or a quarter of the longer one: strips are flat beyond their sides, and still have levels.
  const auto power = [](int cells) { return static_cast<int>(std::bit_width(static_cast<unsigned>(cells) - 1)); };
  const glm::ivec2 cells = grid.last();
  const int rootPower = std::max({power(std::min(cells.x, cells.y)), power(std::max(cells.x, cells.y)) - 2, kClusterHalvings / 2});
  std::vector<Depth> tree(1);
  for (const GridTriangle& root : rootTriangles(grid, rootPower)) tree[0].push_back({root, 0, kNoLevelGroup, {}, 0.0, {}});
  for (int depth = 0; depth < 2 * rootPower - kClusterHalvings; ++depth) {
    Depth finer;
    GridTriangle within;
    for (std::size_t p = 0; p < tree.back().size(); ++p)
      for (const GridTriangle& half : halves(tree.back()[p].triangle))
        if (withinGrid(grid, half, within)) finer.push_back({half, p, kNoLevelGroup, {}, 0.0, {}});
    tree.push_back(std::move(finer));
  }
  return tree;
}

/// Places of all triangles in space.
struct Placement {
  const TerrainGrid& grid;
  glm::dvec2 middle;
  double lowest;

  explicit Placement(const TerrainGrid& of) : grid(of), middle(0.5 * glm::dvec2(of.last())) {
    lowest = std::numeric_limits<double>::infinity();
    for (const float h : of.terrain.heights)
      if (!std::isnan(h)) lowest = std::min(lowest, double{h});
  }
  glm::dvec3 at(std::size_t index) const {
    const auto columns = static_cast<std::size_t>(grid.terrain.columns);
    const glm::dvec2 place(static_cast<double>(index % columns), static_cast<double>(index / columns));
    const glm::dvec2 ground = (place - middle) * grid.terrain.spacing;
    return {ground.x, double{grid.terrain.heights[index]} - lowest, ground.y};
  }
  /// The middle of its texel in a picture with one for each height.
  glm::vec2 coordinate(std::size_t index) const {
    const auto columns = static_cast<std::size_t>(grid.terrain.columns);
    const glm::dvec2 texel(static_cast<double>(index % columns) + 0.5, static_cast<double>(index / columns) + 0.5);
    return glm::vec2(texel / glm::dvec2(grid.terrain.columns, grid.terrain.rows));
  }
};

/// Triangles and error of one patch; vertices are numbered by their place.
void fillPatch(const Placement& placement, Patch& patch, bool finest) {
  const TerrainGrid& grid = placement.grid;
  forParts(patch.triangle, kClusterHalvings, [&](const GridTriangle& part) {
    GridTriangle within;
    if (!withinGrid(grid, part, within)) return;
    const std::array<glm::ivec2, 3>& c = within.corner;
    if (grid.has(c[0]) && grid.has(c[1]) && grid.has(c[2]))
      patch.triangles.emplace_back(grid.index(c[0]), grid.index(c[1]), grid.index(c[2]));
    if (!finest) patch.error = std::max(patch.error, deviation(grid, within, within.corner == part.corner));
  });
  for (const glm::uvec3& t : patch.triangles)
    for (int c = 0; c < 3; ++c) include(patch.box, placement.at(t[c]));
}

/// A ball of single floats that holds what it is given.
struct Ball {
  glm::vec3 centre{0.0f};
  float radius = 0.0f;

  void hold(const glm::dvec3& point, double around) {
    const double reach = glm::length(point - glm::dvec3(centre)) + around;
    if (reach > double{radius}) radius = std::nextafter(static_cast<float>(reach), std::numeric_limits<float>::infinity());
  }
};

/// Makes the groups of a depth: patches that share the edge which is halved. They hold the groups of their halves, which exist already.
void groupDepth(Depth& depth, const Depth& finer, std::vector<LevelGroup>& groups) {
  std::map<std::pair<int, int>, std::vector<std::size_t>> bySplit;
  for (std::size_t p = 0; p < depth.size(); ++p) {
    const glm::ivec2 split = splitPlace(depth[p].triangle);
    bySplit[{split.y, split.x}].push_back(p);
  }
  std::vector<std::vector<std::uint32_t>> below(depth.size());
  for (const Patch& half : finer) {
    include(depth[half.parent].box, half.box);
    if (half.group != kNoLevelGroup) below[half.parent].push_back(half.group);
  }
  for (const auto& [split, members] : bySplit) {
    Box box;
    double error = 0.0;
    for (const std::size_t p : members) {
      error = std::max(error, depth[p].error);
      include(box, depth[p].box);
      depth[p].group = static_cast<std::uint32_t>(groups.size());
    }
    Ball ball;
    if (!isEmpty(box)) ball = {glm::vec3(centre(box)), 0.0f};
    if (!isEmpty(box)) ball.hold(centre(box), 0.5 * diagonal(box));
    auto largest = static_cast<float>(error);
    if (double{largest} < error) largest = std::nextafter(largest, std::numeric_limits<float>::infinity());
    for (const std::size_t p : members)
      for (const std::uint32_t g : below[p]) {
        ball.hold(glm::dvec3(groups[g].centre), double{groups[g].radius});
        largest = std::max(largest, groups[g].error);
      }
    groups.push_back({ball.centre, ball.radius, largest});
  }
}

/// Puts the patches of a depth behind what is there.
void appendDepth(const std::vector<Depth>& tree, std::size_t depth, std::uint32_t& next, std::vector<glm::uvec3>& triangles,
                 MeshLevels& levels) {
  for (const Patch& patch : tree[depth]) {
    if (patch.triangles.empty()) continue;
    const auto count = static_cast<std::uint32_t>(patch.triangles.size());
    const std::uint32_t coarser = depth == 0 ? kNoLevelGroup : tree[depth - 1][patch.parent].group;
    levels.clusters.push_back({next, count, patch.group, coarser});
    triangles.insert(triangles.end(), patch.triangles.begin(), patch.triangles.end());
    next += count;
  }
}

/// Numbers the vertices that triangles use, row by row, and puts them into the mesh.
void placeVertices(const Placement& placement, Mesh& mesh, std::vector<glm::uvec3>& coarse) {
  std::vector<std::uint32_t> number(placement.grid.terrain.heights.size(), kUnused);
  for (const glm::uvec3& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) number[t[c]] = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] == kUnused) continue;
    number[i] = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(placement.at(i));
    mesh.textureCoordinates.push_back(placement.coordinate(i));
  }
  for (auto* triangles : {&mesh.triangles, &coarse})
    for (glm::uvec3& t : *triangles) t = {number[t.x], number[t.y], number[t.z]};
}

void addNormals(Mesh& mesh) {
  std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3& a = mesh.positions[t.x];
    const glm::dvec3 normal = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
    for (int c = 0; c < 3; ++c) sums[t[c]] += normal;
  }
  mesh.normals.reserve(sums.size());
  for (const glm::dvec3& sum : sums) mesh.normals.emplace_back(glm::normalize(sum));
}

/// A coarse triangle may have a corner that no finest triangle uses: a lone height. It is dropped; its error is its size already.
void dropLoneCorners(std::vector<Depth>& tree, std::size_t samples) {
  std::vector<char> used(samples, 0);
  for (const Patch& patch : tree.back())
    for (const glm::uvec3& t : patch.triangles)
      for (int c = 0; c < 3; ++c) used[t[c]] = 1;
  for (std::size_t d = 0; d + 1 < tree.size(); ++d)
    for (Patch& patch : tree[d])
      std::erase_if(patch.triangles, [&](const glm::uvec3& t) { return !used[t.x] || !used[t.y] || !used[t.z]; });
}

}  // namespace

Result<Mesh> terrainMesh(const Terrain& terrain) {
  OVERCAST_REQUIRE(isWhole(terrain), "a terrain of {} x {} is not whole", terrain.columns, terrain.rows);
  const TerrainGrid grid{terrain};
  const Placement placement(grid);
  std::vector<Depth> tree = patchTree(grid);
  for (std::size_t d = 0; d < tree.size(); ++d)
    tbb::parallel_for(std::size_t{0}, tree[d].size(), [&](std::size_t p) { fillPatch(placement, tree[d][p], d + 1 == tree.size()); });
  dropLoneCorners(tree, terrain.heights.size());
  Mesh mesh;
  MeshLevels& levels = mesh.levels.emplace();
  for (std::size_t d = tree.size() - 1; d-- > 0;) groupDepth(tree[d], tree[d + 1], levels.groups);
  std::uint32_t next = 0;
  for (std::size_t d = tree.size(); d-- > 0;) appendDepth(tree, d, next, d + 1 == tree.size() ? mesh.triangles : levels.triangles, levels);
  if (mesh.triangles.empty()) return Error{"", "", "has no three heights beside each other"};
  placeVertices(placement, mesh, levels.triangles);
  addNormals(mesh);
  mesh.parts.push_back({0, static_cast<std::uint32_t>(mesh.triangles.size()), -1});
  if (levels.triangles.empty()) mesh.levels.reset();
  return mesh;
}

}  // namespace overcast
