#include "bake/winding.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/ext/vector_int3_sized.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace overcast {
namespace {

/// (b - a) x (c - a), exact: coordinate differences are below 2^30.
glm::i64vec3 normalOf(const glm::ivec3& a, const glm::ivec3& b, const glm::ivec3& c) {
  const glm::i64vec3 u(b - a), v(c - a);
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}

/// Makes the parent of up to two subtrees and one own triangle (indices or -1); drops levels that would hold a single subtree.
class TreeBuilder {
 public:
  TreeBuilder(const std::vector<glm::ivec3>& points, WindingTree& tree) : points_(points), tree_(tree) {}

  int join(const glm::uvec3* own, int left, int right) {
    const bool hasArea = own && normalOf(points_[own->x], points_[own->y], points_[own->z]) != glm::i64vec3(0);
    if (!hasArea && (left < 0 || right < 0)) return std::max(left, right);
    WindingNode node;
    node.children = {left, right};
    if (hasArea) {
      node.triangle = static_cast<int>(tree_.triangles.size());
      tree_.triangles.push_back(*own);
    }
    sum(node, own);
    tree_.nodes.push_back(node);
    return static_cast<int>(tree_.nodes.size()) - 1;
  }

  /// Joins subtrees by spatial medians of their centres.
  int joinAll(std::span<int> subtrees) {
    if (subtrees.empty()) return -1;
    if (subtrees.size() == 1) return subtrees[0];
    glm::dvec3 low(1e300), high(-1e300);
    for (const int index : subtrees) {
      low = glm::min(low, at(index).centre);
      high = glm::max(high, at(index).centre);
    }
    const glm::dvec3 size = high - low;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto middle = subtrees.begin() + static_cast<std::ptrdiff_t>(subtrees.size() / 2);
    std::nth_element(subtrees.begin(), middle, subtrees.end(), [&](int a, int b) {
      const double ca = at(a).centre[axis], cb = at(b).centre[axis];
      return ca != cb ? ca < cb : a < b;
    });
    const std::size_t half = subtrees.size() / 2;
    const int left = joinAll(subtrees.first(half));
    const int right = joinAll(subtrees.subspan(half));
    return join(nullptr, left, right);
  }

  /// Fills the loop's piece first..last (indices into `loop`, cyclic): a triangle over its halves, then each half.
  int fill(const std::vector<std::uint32_t>& loop, std::size_t first, std::size_t last) {
    if (last - first < 2) return -1;
    const std::size_t middle = (first + last) / 2;
    const int left = fill(loop, first, middle);
    const int right = fill(loop, middle, last);
    const glm::uvec3 own(loop[first], loop[last % loop.size()], loop[middle]);
    return join(&own, left, right);
  }

 private:
  const WindingNode& at(int index) const { return tree_.nodes[static_cast<std::size_t>(index)]; }
  glm::dvec3 point(std::uint32_t index) const { return glm::dvec3(points_[index]); }
  glm::dvec3 areaOf(const glm::uvec3& t) const { return 0.5 * glm::dvec3(normalOf(points_[t.x], points_[t.y], points_[t.z])); }

  void sum(WindingNode& node, const glm::uvec3* own) const {
    const bool hasOwn = node.triangle >= 0;
    const glm::dvec3 ownArea = hasOwn ? areaOf(*own) : glm::dvec3(0.0);
    const glm::dvec3 ownCentre = hasOwn ? (point(own->x) + point(own->y) + point(own->z)) / 3.0 : glm::dvec3(0.0);
    glm::dvec3 weighted = glm::length(ownArea) * ownCentre;
    node.absolute = glm::length(ownArea);
    node.area = ownArea;
    for (const int child : node.children) {
      if (child < 0) continue;
      node.absolute += at(child).absolute;
      node.area += at(child).area;
      weighted += at(child).absolute * at(child).centre;
    }
    node.centre = weighted / node.absolute;
    if (hasOwn) {
      node.moment = glm::outerProduct(ownArea, ownCentre - node.centre);
      for (int corner = 0; corner < 3; ++corner) node.radius = std::max(node.radius, glm::distance(point((*own)[corner]), node.centre));
    }
    for (const int child : node.children) {
      if (child < 0) continue;
      node.moment += at(child).moment + glm::outerProduct(at(child).area, at(child).centre - node.centre);
      node.radius = std::max(node.radius, glm::distance(at(child).centre, node.centre) + at(child).radius);
    }
  }

  const std::vector<glm::ivec3>& points_;
  WindingTree& tree_;
};

/// Splits the boundary into loops that visit no vertex twice.
std::vector<std::vector<std::uint32_t>> loopsOf(const std::vector<DirectedEdge>& boundary, std::size_t vertexCount) {
  std::vector<std::uint32_t> start(vertexCount + 1, 0);
  for (const DirectedEdge& edge : boundary) ++start[edge.from + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<std::uint32_t> next(start.begin(), start.end() - 1), target(boundary.size());
  for (const DirectedEdge& edge : boundary) target[next[edge.from]++] = edge.to;
  std::copy(start.begin(), start.end() - 1, next.begin());

  std::vector<std::vector<std::uint32_t>> loops;
  std::vector<int> place(vertexCount, -1);  // position on the current path
  std::vector<std::uint32_t> path;
  for (const DirectedEdge& edge : boundary) {
    std::uint32_t vertex = edge.from;
    while (next[vertex] < start[vertex + 1]) {
      place[vertex] = static_cast<int>(path.size());
      path.push_back(vertex);
      vertex = target[next[vertex]++];
      if (place[vertex] < 0) continue;
      const auto begin = path.begin() + place[vertex];
      for (auto v = begin; v != path.end(); ++v) place[*v] = -1;
      loops.emplace_back(begin, path.end());
      path.erase(begin, path.end());
    }
    OVERCAST_REQUIRE(path.empty(), "a boundary path of {} edges does not close at vertex {}", path.size(), vertex);
  }
  return loops;
}

/// Solid angle of a triangle over 4 pi (van Oosterom and Strackee 1983), positive where its outward side is turned away. Exact sign.
class TriangleWinding {
 public:
  explicit TriangleWinding(const std::array<glm::ivec3, 3>& corners) : corners_(corners) {
    const glm::i64vec3 normal = normalOf(corners[0], corners[1], corners[2]);
    for (int axis = 2; axis >= 0; --axis)
      if (normal[axis] != 0) tie_ = normal[axis] > 0 ? -1.0 : 1.0;
    normal_ = glm::dvec3(normal);
  }

  double operator()(const glm::ivec3& point) const {
    const glm::dvec3 a(corners_[0] - point), b(corners_[1] - point), c(corners_[2] - point);
    double volume = glm::dot(a, glm::cross(b, c));
    // Coordinates below 2^30 give a rounding error below 2^41.
    if (std::abs(volume) < 0x1p44) {
      const Int128 exact = exactVolume(point);
      if (exact == 0) return inPlane(a, b, c);
      volume = static_cast<double>(exact);
    }
    return share(volume, a, b, c);
  }

 private:
  static double share(double volume, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double denominator = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
    return std::atan2(volume, denominator) * (0.5 / std::numbers::pi);
  }

  /// From a point of the triangle's plane. On an edge both arguments of the arc tangent vanish, and what remains is the direction in
  /// which the point is moved off it: so it is moved, by x before y before z as the tie says, far enough for doubles to tell.
  double inPlane(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) const {
    const glm::dvec3 moved(0x1p-6, 0x1p-14, 0x1p-22);
    const double volume = std::abs(glm::dot(normal_, moved));
    return share(std::copysign(volume, tie_), a - moved, b - moved, c - moved);
  }

  Int128 exactVolume(const glm::ivec3& point) const {
    const glm::ivec3 a = corners_[0] - point, b = corners_[1] - point, c = corners_[2] - point;
    const auto minor = [](std::int64_t p, std::int64_t q, std::int64_t r, std::int64_t s) { return Int128{p} * s - Int128{q} * r; };
    return a.x * minor(b.y, b.z, c.y, c.z) - a.y * minor(b.x, b.z, c.x, c.z) + a.z * minor(b.x, b.y, c.x, c.y);
  }

  std::array<glm::ivec3, 3> corners_;
  glm::dvec3 normal_{0.0};
  double tie_ = 0.0;  ///< sign of the volume after moving a point of the triangle's plane by +x, +y, +z infinitesimally
};

/// What a group of points sees of a tree: nodes to take whole and triangles to take exactly.
struct Visible {
  std::vector<int> nodes;
  std::vector<int> triangles;
};

Visible visibleFrom(const WindingTree& tree, const glm::dvec3& centre, double halfDiagonal, double tolerance) {
  Visible visible;
  std::vector<int> stack;
  if (tree.root >= 0) stack.push_back(tree.root);
  while (!stack.empty()) {
    const int index = stack.back();
    stack.pop_back();
    const WindingNode& node = tree.nodes[static_cast<std::size_t>(index)];
    // Taylor remainder of area . r / (4 pi r^3) beyond the first moment: second derivatives of r / r^3 are at most 12 / r^4.
    const double clearance = glm::distance(node.centre, centre) - halfDiagonal - node.radius;
    const double squared = clearance * clearance;
    if (clearance > 0.0 && 0.5 * node.absolute * node.radius * node.radius < tolerance * squared * squared) {
      visible.nodes.push_back(index);
      continue;
    }
    if (node.triangle >= 0) visible.triangles.push_back(node.triangle);
    for (const int child : node.children)
      if (child >= 0) stack.push_back(child);
  }
  return visible;
}

/// Dipole and first moment at many points: (area . r / r^3 + trace(moment) / r^3 - 3 r . moment r / r^5) / 4 pi.
void addNode(const WindingNode& node, std::span<const glm::dvec3> points, std::span<double> result) {
  constexpr double kScale = 0.25 / std::numbers::pi;
  const glm::dvec3 area = node.area;
  const glm::dmat3 moment = node.moment;
  const double trace = moment[0][0] + moment[1][1] + moment[2][2];
  for (std::size_t i = 0; i < points.size(); ++i) {
    const glm::dvec3 r = node.centre - points[i];
    const double squared = glm::dot(r, r);
    const double inverse = 1.0 / squared;
    const double cubed = inverse / std::sqrt(squared);
    result[i] += kScale * cubed * (glm::dot(area, r) + trace - 3.0 * inverse * glm::dot(r, moment * r));
  }
}

}  // namespace

WindingTree windingTree(const std::vector<glm::ivec3>& points, const std::vector<glm::uvec3>& triangles) {
  WindingTree tree;
  TreeBuilder builder(points, tree);
  std::vector<int> leaves;
  for (const glm::uvec3& triangle : triangles)
    if (const int leaf = builder.join(&triangle, -1, -1); leaf >= 0) leaves.push_back(leaf);
  tree.root = builder.joinAll(leaves);
  return tree;
}

WindingTree fillBoundary(const std::vector<glm::ivec3>& points, const std::vector<DirectedEdge>& boundary) {
  WindingTree tree;
  TreeBuilder builder(points, tree);
  std::vector<int> fills;
  for (const std::vector<std::uint32_t>& loop : loopsOf(boundary, points.size()))
    if (const int fill = builder.fill(loop, 0, loop.size()); fill >= 0) fills.push_back(fill);
  tree.root = builder.joinAll(fills);
  return tree;
}

void addWinding(const WindingTree& tree, const std::vector<glm::ivec3>& vertices, std::span<const glm::ivec3> points, double tolerance,
                std::span<double> result) {
  if (points.empty()) return;
  glm::dvec3 low(1e300), high(-1e300);
  std::vector<glm::dvec3> positions(points.begin(), points.end());
  for (const glm::dvec3& p : positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const Visible visible = visibleFrom(tree, 0.5 * (low + high), 0.5 * glm::distance(low, high), tolerance);
  for (const int index : visible.nodes) addNode(tree.nodes[static_cast<std::size_t>(index)], positions, result);
  for (const int index : visible.triangles) {
    const glm::uvec3& t = tree.triangles[static_cast<std::size_t>(index)];
    const TriangleWinding winding({vertices[t.x], vertices[t.y], vertices[t.z]});
    for (std::size_t i = 0; i < points.size(); ++i) result[i] += winding(points[i]);
  }
}

}  // namespace overcast
