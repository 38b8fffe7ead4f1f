#include "bake/edges.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <tuple>

#include "bake/bucket_sort.h"

namespace overcast {

std::vector<EdgeUse> edgeUses(const std::vector<glm::uvec3>& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(triangles.size() * 3);
  std::size_t vertices = 0;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      vertices = std::max(vertices, std::size_t{triangles[t][corner]} + 1);
      const std::uint32_t from = triangles[t][corner];
      const std::uint32_t to = triangles[t][(corner + 1) % 3];
      if (from != to) uses.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  }
  return bucketSorted(
      uses, vertices, [](const EdgeUse& use) { return use.low; },
      [](const EdgeUse& a, const EdgeUse& b) { return std::tie(a.high, a.triangle, a.forward) < std::tie(b.high, b.triangle, b.forward); });
}

std::vector<DirectedEdge> netBoundary(const std::vector<glm::uvec3>& triangles) {
  std::vector<DirectedEdge> boundary;
  forEachEdge(edgeUses(triangles), [&](auto first, auto last) {
    int net = 0;
    for (auto use = first; use != last; ++use) net += use->forward ? 1 : -1;
    const DirectedEdge edge = net > 0 ? DirectedEdge{first->low, first->high} : DirectedEdge{first->high, first->low};
    boundary.insert(boundary.end(), static_cast<std::size_t>(std::abs(net)), edge);
  });
  return boundary;
}

TriangleSets::TriangleSets(std::size_t size) : parent_(size) {
  std::iota(parent_.begin(), parent_.end(), 0u);
}

std::uint32_t TriangleSets::find(std::uint32_t triangle) {
  while (parent_[triangle] != triangle) triangle = parent_[triangle] = parent_[parent_[triangle]];
  return triangle;
}

void TriangleSets::join(std::uint32_t a, std::uint32_t b) {
  a = find(a);
  b = find(b);
  parent_[std::max(a, b)] = std::min(a, b);
}

TriangleSets connectedPieces(const std::vector<glm::uvec3>& triangles) {
  TriangleSets sets(triangles.size());
  forEachEdge(edgeUses(triangles), [&](auto first, auto last) {
    for (auto use = first + 1; use != last; ++use) sets.join(first->triangle, use->triangle);
  });
  return sets;
}

TriangleSets consistentPieces(const std::vector<glm::uvec3>& triangles) {
  TriangleSets sets(triangles.size());
  forEachEdge(edgeUses(triangles), [&](auto first, auto last) {
    if (last - first == 2 && first->forward != (last - 1)->forward) sets.join(first->triangle, (last - 1)->triangle);
  });
  return sets;
}

}  // namespace overcast
