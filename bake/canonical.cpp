#include "bake/canonical.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include <tbb/parallel_sort.h>

#include "bake/bucket_sort.h"

namespace overcast {
namespace {

constexpr std::uint32_t kUnused = ~0u;

/// A position and where the mesh has it.
struct Place {
  glm::dvec3 position;
  std::uint32_t index;
};

bool precedes(const glm::dvec3& a, const glm::dvec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

bool precedes(const glm::uvec3& a, const glm::uvec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// The positions in use, sorted.
std::vector<Place> sortedPlaces(const Mesh& mesh) {
  std::vector<char> used(mesh.positions.size(), 0);
  for (const glm::uvec3& t : mesh.triangles) used[t.x] = used[t.y] = used[t.z] = 1;
  std::vector<Place> places;
  places.reserve(mesh.positions.size());
  // Adding zero makes -0 the same bits as 0.
  for (std::uint32_t i = 0; i < mesh.positions.size(); ++i)
    if (used[i]) places.push_back({mesh.positions[i] + glm::dvec3(0.0), i});
  tbb::parallel_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return precedes(a.position, b.position); });
  return places;
}

glm::uvec3 smallestRotation(const glm::uvec3& t) {
  glm::uvec3 smallest = t;
  for (const glm::uvec3& turned : {glm::uvec3(t.y, t.z, t.x), glm::uvec3(t.z, t.x, t.y)})
    if (precedes(turned, smallest)) smallest = turned;
  return smallest;
}

}  // namespace

Mesh canonicalOrder(const Mesh& mesh, std::uint64_t& merged) {
  Mesh ordered;
  ordered.name = mesh.name;
  std::vector<std::uint32_t> place(mesh.positions.size(), kUnused);
  {
    const std::vector<Place> places = sortedPlaces(mesh);
    ordered.positions.reserve(places.size());
    for (const Place& p : places) {
      if (ordered.positions.empty() || ordered.positions.back() != p.position) ordered.positions.push_back(p.position);
      place[p.index] = static_cast<std::uint32_t>(ordered.positions.size() - 1);
    }
    merged = places.size() - ordered.positions.size();
  }
  std::vector<glm::uvec3> triangles(mesh.triangles.size());
  std::transform(mesh.triangles.begin(), mesh.triangles.end(), triangles.begin(), [&](const glm::uvec3& t) {
    return smallestRotation({place[t.x], place[t.y], place[t.z]});
  });
  ordered.triangles = bucketSorted(
      triangles, ordered.positions.size(), [](const glm::uvec3& t) { return t.x; },
      [](const glm::uvec3& a, const glm::uvec3& b) { return precedes(a, b); });
  ordered.parts = {MeshPart{0, static_cast<std::uint32_t>(ordered.triangles.size()), -1}};
  return ordered;
}

Mesh canonicalOrder(const Mesh& mesh) {
  std::uint64_t merged = 0;
  return canonicalOrder(mesh, merged);
}

}  // namespace overcast
