#include "bake/bvh.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace overcast {
namespace {

constexpr double kRounding = 0x1p-23;  // twice what rounding to float can lose, relatively

/// What a tree is made of.
struct Source {
  const Mesh& mesh;
  glm::dvec3 origin;
  double voxelsPerUnit;
  std::vector<glm::vec3> positions;  // of the mesh, in voxels
  BinaryTree binary;
};

glm::dvec3 inVoxels(const Source& source, const glm::dvec3& position) {
  return (position - source.origin) * source.voxelsPerUnit;
}

/// Opens the largest children of `index` until there are kTreeWidth or only leaves.
std::vector<std::int32_t> widen(const Source& source, std::int32_t index) {
  std::vector<std::int32_t> children{index};
  while (children.size() < kTreeWidth) {
    std::size_t largest = children.size();
    float largestArea = -1.0f;
    for (std::size_t i = 0; i < children.size(); ++i) {
      const BinaryNode& child = source.binary.nodes[static_cast<std::size_t>(children[i])];
      if (child.left < 0 || area(child) <= largestArea) continue;
      largest = i;
      largestArea = area(child);
    }
    if (largest == children.size()) break;
    const std::int32_t left = source.binary.nodes[static_cast<std::size_t>(children[largest])].left;
    children[largest] = left;
    children.insert(children.begin() + static_cast<std::ptrdiff_t>(largest) + 1, left + 1);
  }
  return children;
}

/// Appends the wide node made of binary node `index` and everything below; leaves are noted as ranges of primitives.
std::int32_t collapse(const Source& source, std::int32_t index, Tree& tree, std::vector<std::int32_t>& leafNodes) {
  const auto wide = static_cast<std::int32_t>(tree.nodes.size());
  tree.nodes.emplace_back();
  for (int axis = 0; axis < 3; ++axis) {
    std::fill_n(tree.nodes.back().low[axis], kTreeWidth, kFarAway);
    std::fill_n(tree.nodes.back().high[axis], kTreeWidth, kFarAway);
  }
  const std::vector<std::int32_t> children = widen(source, index);
  for (std::size_t i = 0; i < children.size(); ++i) {
    const BinaryNode& child = source.binary.nodes[static_cast<std::size_t>(children[i])];
    std::int32_t target = 0;
    if (child.left < 0) {
      target = ~static_cast<std::int32_t>(leafNodes.size());
      leafNodes.push_back(children[i]);
    } else {
      target = collapse(source, children[i], tree, leafNodes);
    }
    TreeNode& node = tree.nodes[static_cast<std::size_t>(wide)];
    node.child[i] = target;
    for (int axis = 0; axis < 3; ++axis) {
      node.low[axis][i] = child.low[axis] - tree.positionError;
      node.high[axis][i] = child.high[axis] + tree.positionError;
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
  const glm::dvec3 u = base > 0.0 ? edges[longest] * (1.0 / base) : glm::dvec3(1.0, 0.0, 0.0);
  const glm::dvec3 normal = glm::cross(u, ac);
  const double height = glm::length(normal);
  const bool degenerate = !(height > 1e-9 * base);
  const glm::dvec3 w = degenerate ? perpendicularTo(u) : normal * (1.0 / height);
  store(out.a, a);
  store(out.aRest, a - glm::dvec3(out.a[0], out.a[1], out.a[2]));
  store(out.u, u);
  store(out.v, glm::cross(w, u));
  store(out.w, w);
  out.length0 = static_cast<float>(base);
  if (degenerate) {
    // The longest edge is all there is: edge 1 is put out of reach, which leaves no point inside, and edge 2 repeats edge 0.
    out.length1 = out.along1[0] = out.along1[1] = 0.0f;
    out.alongStart1 = kFarAway;
    out.innerStart1 = -kFarAway;
    out.length2 = out.length0;
    out.along2[0] = 1.0f;
    out.along2[1] = 0.0f;
    return 0.25 * base * base;
  }
  const glm::dvec2 c(glm::dot(ac, u), height);
  const double length1 = std::sqrt(length2[next]);
  const double lengthC = std::sqrt(length2[last]);
  const glm::dvec2 along1 = (c - glm::dvec2(base, 0.0)) * (1.0 / length1);
  const glm::dvec2 along2 = c * (1.0 / lengthC);
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

void fillLeaf(const Source& source, const BinaryNode& range, Tree& tree, TreeLeaf& leaf) {
  leaf = {};
  for (auto& axis : leaf.vertex) std::fill(std::begin(axis), std::end(axis), kFarAway);
  leaf.firstTriangle = range.first;
  for (std::uint32_t i = 0; i < range.count; ++i) {
    const glm::uvec3& vertices = source.mesh.triangles[source.binary.order[range.first + i]];
    std::array<glm::dvec3, 3> corners;
    std::array<std::size_t, 3> places;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = vertices[static_cast<int>(k)];
      corners[k] = inVoxels(source, source.mesh.positions[vertex]);
      places[k] = source.binary.places[range.first + i] >> (4 * k) & (kTreeWidth - 1);
      leaf.corners[i] |= 1u << places[k];
      for (int axis = 0; axis < 3; ++axis) leaf.vertex[axis][places[k]] = source.positions[vertex][axis];
    }
    const double radius2 = makeTriangle(corners, tree.triangles[range.first + i]);
    // Besides R^2: what the rounding of positions and of |p - v|^2, which is about R^2 when it matters, can do.
    const double error = tree.positionError;
    const auto slack = static_cast<float>(radius2 * (1.0 + 64.0 * kRounding) + 8.0 * error * (std::sqrt(radius2) + error));
    for (const std::size_t place : places) leaf.slack[place] = std::max(leaf.slack[place], slack);
  }
}

/// The largest coordinate of the tree's box and of the grid, in voxels.
double reachOf(const BinaryNode& root, const Grid& grid) {
  double reach = glm::length(glm::dvec3(grid.size));
  for (int axis = 0; axis < 3; ++axis) reach = std::max({reach, std::abs(double{root.low[axis]}), std::abs(double{root.high[axis]})});
  return reach;
}

}  // namespace

Tree buildTree(const Mesh& mesh, const Grid& grid) {
  Source source{mesh, grid.origin, 1.0 / grid.voxelSize, std::vector<glm::vec3>(mesh.positions.size()), {}};
  tbb::parallel_for(std::size_t{0}, mesh.positions.size(),
                    [&](std::size_t i) { source.positions[i] = inVoxels(source, mesh.positions[i]); });
  source.binary = buildBinaryTree(source.positions, mesh.triangles);
  const double reach = reachOf(source.binary.nodes[0], grid);
  OVERCAST_REQUIRE(reach < 1e12, "mesh reaches {} voxels from the grid's origin", reach);
  Tree tree;
  tree.positionError = static_cast<float>(kRounding * reach);
  std::vector<std::int32_t> leafNodes;
  collapse(source, 0, tree, leafNodes);
  tree.leafCount = leafNodes.size();
  tree.leaves = std::make_unique_for_overwrite<TreeLeaf[]>(leafNodes.size());
  tree.triangles = std::make_unique_for_overwrite<TreeTriangle[]>(mesh.triangles.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, leafNodes.size(), 256), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      fillLeaf(source, source.binary.nodes[static_cast<std::size_t>(leafNodes[i])], tree, tree.leaves[i]);
    }
  });
  tree.order = std::move(source.binary.order);
  return tree;
}

}  // namespace overcast
