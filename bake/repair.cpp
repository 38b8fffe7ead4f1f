#include "bake/repair.h"

#include <algorithm>
#include <array>
#include <tuple>

#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Simple_cartesian.h>

#include <glm/geometric.hpp>

#include "bake/bucket_sort.h"
#include "bake/canonical.h"
#include "bake/edges.h"

namespace overcast {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Simple_cartesian<double>;
using Polygon = std::array<std::size_t, 3>;

bool isCollapsed(const glm::uvec3& t) {
  return t.x == t.y || t.y == t.z || t.z == t.x;
}

glm::dvec3 areaVector(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3& a = mesh.positions[t.x];
  return 0.5 * glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
}

/// Six times the volume under a triangle as seen from `apex`.
double volumeUnder(const Mesh& mesh, const glm::uvec3& t, const glm::dvec3& apex) {
  return glm::dot(mesh.positions[t.x] - apex, glm::cross(mesh.positions[t.y] - apex, mesh.positions[t.z] - apex));
}

constexpr char kFirstOfPair = 1;
constexpr char kSecondOfPair = 2;

/// Removes the marked triangles, and what `paired` says of them; returns how many.
std::uint64_t removeTriangles(Mesh& mesh, std::vector<char>& paired, const std::vector<char>& marked) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (marked[i]) continue;
    paired[kept] = paired[i];
    mesh.triangles[kept++] = mesh.triangles[i];
  }
  const std::uint64_t removed = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  paired.resize(kept);
  return removed;
}

/// Drops repeated triangles and says of those that stay whether one of the opposite orientation stays as well: such a pair
/// encloses nothing, so it says nothing about orientation.
std::vector<char> dropDuplicates(Mesh& mesh, std::uint64_t& dropped) {
  struct Key {
    std::array<std::uint32_t, 3> corners;
    bool even;
    std::uint32_t triangle;
  };
  std::vector<Key> keys;
  keys.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    std::array<std::uint32_t, 3> corners{t.x, t.y, t.z};
    std::sort(corners.begin(), corners.end());
    const bool even =
        (t.x == corners[0] && t.y == corners[1]) || (t.y == corners[0] && t.z == corners[1]) || (t.z == corners[0] && t.x == corners[1]);
    keys.push_back({corners, even || isCollapsed(t), i});
  }
  keys = bucketSorted(
      keys, mesh.positions.size(), [](const Key& key) { return key.corners[0]; },
      [](const Key& a, const Key& b) { return std::tie(a.corners, a.even, a.triangle) < std::tie(b.corners, b.even, b.triangle); });
  std::vector<char> repeated(mesh.triangles.size(), 0), paired(mesh.triangles.size(), 0);
  std::size_t group = 0;  // first key with these corners
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].corners != keys[i - 1].corners) {
      group = i;
    } else if (keys[i].even == keys[i - 1].even) {
      repeated[keys[i].triangle] = 1;
    } else {
      paired[std::min(keys[i].triangle, keys[group].triangle)] = kFirstOfPair;
      paired[std::max(keys[i].triangle, keys[group].triangle)] = kSecondOfPair;
    }
  }
  dropped = removeTriangles(mesh, paired, repeated);
  return paired;
}

/// Counts components, and takes the second triangle of every pair out of those that consist of pairs alone: surfaces modelled with
/// two sides, which would otherwise cancel as a whole and be nowhere solid. Then the first ones count as a surface of one side.
void openDoubleSided(Mesh& mesh, std::vector<char>& paired, MeshDiagnosis& found) {
  TriangleSets sets = connectedPieces(mesh.triangles);
  std::vector<char> seen(mesh.triangles.size(), 0), singleSided(mesh.triangles.size(), 0), marked(mesh.triangles.size(), 0);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (isCollapsed(mesh.triangles[i])) continue;
    const std::uint32_t component = sets.find(i);
    found.components += seen[component] == 0 ? 1 : 0;
    seen[component] = 1;
    if (paired[i] == 0) singleSided[component] = 1;
  }
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (singleSided[sets.find(i)]) continue;
    marked[i] = paired[i] == kSecondOfPair ? 1 : 0;
    paired[i] = 0;
  }
  found.duplicateTriangles += removeTriangles(mesh, paired, marked);
}

struct FlipRecorder : pmp::Default_orientation_visitor {
  std::vector<char>* flipped = nullptr;
  void polygon_orientation_reversed(std::size_t polygon) { (*flipped)[polygon] ^= 1; }
};

/// For each triangle whether CGAL would flip it to agree with its neighbours across manifold edges.
std::vector<char> flipsToAgree(const Mesh& mesh, const std::vector<glm::uvec3>& triangles) {
  // Orientation is combinatorial; the copies that CGAL makes of points at non-manifold places are thrown away with the soup.
  std::vector<Kernel::Point_3> points(mesh.positions.size());
  std::vector<Polygon> polygons;
  polygons.reserve(triangles.size());
  for (const glm::uvec3& t : triangles) polygons.push_back({t.x, t.y, t.z});
  std::vector<char> flipped(triangles.size(), 0);
  FlipRecorder recorder;
  recorder.flipped = &flipped;
  pmp::orient_polygon_soup(points, polygons, CGAL::parameters::visitor(recorder));
  return flipped;
}

/// Triangles connected across manifold edges.
struct Patch {
  bool inconsistent = false;
  bool open = false;         ///< has an edge with other than two triangles
  double volume = 0.0;       ///< six times, with the flips
  double keptArea = 0.0;     ///< of triangles that the flips leave alone
  double flippedArea = 0.0;  ///< of the others
};

/// Orients `active` triangles (indices into mesh.triangles) within each patch that is inconsistent.
void orientPatches(Mesh& mesh, const std::vector<std::uint32_t>& active, MeshDiagnosis& found) {
  std::vector<glm::uvec3> triangles;
  for (const std::uint32_t i : active) triangles.push_back(mesh.triangles[i]);
  const std::vector<EdgeUse> uses = edgeUses(triangles);
  TriangleSets sets(triangles.size());
  forEachEdge(uses, [&](auto first, auto last) {
    found.nonManifoldEdges += last - first > 2;
    if (last - first == 2) sets.join(first->triangle, (last - 1)->triangle);
  });
  std::vector<Patch> patches(triangles.size());  // by the set's smallest triangle
  forEachEdge(uses, [&](auto first, auto last) {
    for (auto use = first; use != last; ++use) patches[sets.find(use->triangle)].open |= last - first != 2;
    if (last - first != 2 || first->forward != (last - 1)->forward) return;
    ++found.inconsistentEdges;
    patches[sets.find(first->triangle)].inconsistent = true;
  });
  if (found.inconsistentEdges == 0) return;

  const std::vector<char> flips = flipsToAgree(mesh, triangles);
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    Patch& patch = patches[sets.find(i)];
    const glm::dvec3& apex = mesh.positions[triangles[sets.find(i)].x];
    patch.volume += (flips[i] ? -1.0 : 1.0) * volumeUnder(mesh, triangles[i], apex);
    (flips[i] ? patch.flippedArea : patch.keptArea) += glm::length(areaVector(mesh, triangles[i]));
  }
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const Patch& patch = patches[sets.find(i)];
    // Closed: outward. Open: as most of its area was.
    const bool reverse = patch.open ? patch.flippedArea > patch.keptArea : patch.volume < 0.0;
    if (!patch.inconsistent || (flips[i] != 0) == reverse) continue;
    std::swap(mesh.triangles[active[i]].y, mesh.triangles[active[i]].z);
    ++found.reorientedTriangles;
  }
}

}  // namespace

void countBoundary(const Mesh& mesh, MeshDiagnosis& found) {
  found.boundaryEdges = 0;
  forEachEdge(edgeUses(mesh.triangles), [&](auto first, auto last) {
    std::ptrdiff_t net = 0;
    for (auto use = first; use != last; ++use) net += use->forward ? 1 : -1;
    found.boundaryEdges += net != 0 ? 1 : 0;
  });
  found.closed = found.boundaryEdges == 0;
}

RepairedMesh repair(const Mesh& mesh) {
  RepairedMesh repaired;
  MeshDiagnosis& found = repaired.found;
  repaired.mesh = canonicalOrder(mesh, found.verticesMerged);
  std::vector<char> paired = dropDuplicates(repaired.mesh, found.duplicateTriangles);
  openDoubleSided(repaired.mesh, paired, found);
  const std::vector<glm::uvec3>& triangles = repaired.mesh.triangles;

  double volume = 0.0;
  std::vector<std::uint32_t> active;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    found.degenerateTriangles += areaVector(repaired.mesh, triangles[i]) == glm::dvec3(0.0);
    volume += volumeUnder(repaired.mesh, triangles[i], repaired.mesh.positions[triangles[0].x]);
    if (!isCollapsed(triangles[i]) && !paired[i]) active.push_back(i);
  }
  orientPatches(repaired.mesh, active, found);

  countBoundary(repaired.mesh, found);
  found.insideOut = found.closed && volume < 0.0;
  repaired.mesh.parts.front().triangleCount = static_cast<std::uint32_t>(triangles.size());
  return repaired;
}

}  // namespace overcast
