// Edges: the table of directed edge uses that repair and sign share, and which triangles hang together by it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

namespace overcast {

/// One triangle running along one undirected edge {low, high}, low < high.
struct EdgeUse {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t triangle = 0;
  bool forward = false;  ///< the triangle runs from low to high
};

/// All edge uses of `triangles`, sorted by (low, high, triangle). Edges from a vertex to itself are left out.
std::vector<EdgeUse> edgeUses(const std::vector<glm::uvec3>& triangles);

/// A directed boundary edge; the chain of triangles has it in its boundary once.
struct DirectedEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
};

/// The boundary of the triangles as a chain: every undirected edge whose uses do not cancel, in the direction that is left over, as often
/// as it is left over. Empty exactly when the winding number of the triangles is an integer everywhere. At every vertex as many
/// of these edges end as begin.
std::vector<DirectedEdge> netBoundary(const std::vector<glm::uvec3>& triangles);

/// Calls `visit(first, last)` for each run of uses of the same undirected edge.
template <class Visit>
void forEachEdge(const std::vector<EdgeUse>& uses, Visit visit) {
  for (auto first = uses.begin(); first != uses.end();) {
    auto last = first;
    while (last != uses.end() && last->low == first->low && last->high == first->high) ++last;
    visit(first, last);
    first = last;
  }
}

/// Disjoint sets of triangles; a set is named by its smallest triangle.
class TriangleSets {
 public:
  explicit TriangleSets(std::size_t size);
  std::uint32_t find(std::uint32_t triangle);
  void join(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<std::uint32_t> parent_;
};

/// Triangles that share an edge are in one set.
TriangleSets connectedPieces(const std::vector<glm::uvec3>& triangles);

/// Only across edges of two triangles that run along it in opposite directions: pieces whose orientation is consistent.
TriangleSets consistentPieces(const std::vector<glm::uvec3>& triangles);

}  // namespace overcast
