#include "bake/mesh_bisect.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <utility>

#include <glm/geometric.hpp>

#include "formats/result.h"

namespace overcast {
namespace {

/// Of an edge, by its ends' places; the lower first.
using Edge = std::pair<std::uint32_t, std::uint32_t>;

Edge edgeBetween(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Vertices at the same position have the same number.
std::vector<std::uint32_t> placesOf(const std::vector<glm::dvec3>& positions) {
  std::vector<std::uint32_t> order(positions.size()), place(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t v) { return std::array<double, 3>{positions[v].x, positions[v].y, positions[v].z}; };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  for (std::size_t i = 0; i < order.size(); ++i)
    place[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? place[order[i - 1]] : order[i];
  return place;
}

struct Job {
  Bisected result;
  std::vector<std::uint32_t> place;  ///< of the vertices of the input
  std::vector<Edge> cut;             ///< sorted
  std::map<Edge, std::uint32_t> middles;

  bool isCut(std::uint32_t a, std::uint32_t b) const {
    return a < place.size() && b < place.size() && std::binary_search(cut.begin(), cut.end(), edgeBetween(place[a], place[b]));
  }
  std::uint32_t middleOf(std::uint32_t a, std::uint32_t b);
  void emit(const glm::uvec3& triangle, std::uint32_t from);
};

/// The corner after which the longest edge begins; of edges as long the one whose ends come first, for all triangles alike.
int longestEdge(const Mesh& mesh, const std::vector<std::uint32_t>& place, const glm::uvec3& t) {
  int best = 0;
  std::pair<double, Edge> longest{-1.0, {}};
  for (int c = 0; c < 3; ++c) {
    const std::uint32_t a = t[c], b = t[(c + 1) % 3];
    const bool turned = place[a] > place[b];
    const glm::dvec3 way = turned ? mesh.positions[a] - mesh.positions[b] : mesh.positions[b] - mesh.positions[a];
    const std::pair<double, Edge> length{glm::dot(way, way), edgeBetween(place[a], place[b])};
    if (length > longest) {
      longest = length;
      best = c;
    }
  }
  return best;
}

std::uint32_t Job::middleOf(std::uint32_t a, std::uint32_t b) {
  Mesh& mesh = result.mesh;
  const auto [entry, fresh] = middles.emplace(edgeBetween(a, b), static_cast<std::uint32_t>(mesh.positions.size()));
  if (!fresh) return entry->second;
  mesh.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
  if (!mesh.normals.empty()) {
    const glm::vec3 sum = mesh.normals[a] + mesh.normals[b];
    const float length = glm::length(sum);
    mesh.normals.push_back(length > 0.0f ? sum / length : mesh.normals[a]);
  }
  if (!mesh.textureCoordinates.empty()) mesh.textureCoordinates.push_back(0.5f * (mesh.textureCoordinates[a] + mesh.textureCoordinates[b]));
  return entry->second;
}

/// The pieces of a triangle whose cut edges, but for the longest, are edges of the input.
void Job::emit(const glm::uvec3& triangle, std::uint32_t from) {
  for (int c = 0; c < 3; ++c) {
    const std::uint32_t a = triangle[c], b = triangle[(c + 1) % 3], far = triangle[(c + 2) % 3];
    if (!isCut(a, b)) continue;
    const std::uint32_t middle = middleOf(a, b);
    emit({middle, far, a}, from);
    emit({middle, b, far}, from);
    return;
  }
  result.mesh.triangles.push_back(triangle);
  result.from.push_back(from);
}

/// Edges to cut: the longest of every marked triangle, and of every triangle that has a cut edge.
std::vector<Edge> edgesToCut(const Mesh& mesh, const std::vector<std::uint32_t>& place, std::vector<char> marked) {
  std::vector<int> longest;
  for (const glm::uvec3& t : mesh.triangles) longest.push_back(longestEdge(mesh, place, t));
  std::vector<Edge> cut;
  for (bool grown = true; grown;) {
    grown = false;
    std::vector<Edge> added;
    for (std::size_t i = 0; i < marked.size(); ++i) {
      const glm::uvec3& t = mesh.triangles[i];
      const int c = longest[i];
      if (marked[i] == 1) added.push_back(edgeBetween(place[t[c]], place[t[(c + 1) % 3]]));
      if (marked[i]) marked[i] = 2;
    }
    cut.insert(cut.end(), added.begin(), added.end());
    std::sort(cut.begin(), cut.end());
    cut.erase(std::unique(cut.begin(), cut.end()), cut.end());
    for (std::size_t i = 0; i < marked.size(); ++i) {
      const glm::uvec3& t = mesh.triangles[i];
      for (int c = 0; c < 3 && !marked[i]; ++c)
        if (std::binary_search(cut.begin(), cut.end(), edgeBetween(place[t[c]], place[t[(c + 1) % 3]]))) marked[i] = 1;
      grown = grown || marked[i] == 1;
    }
  }
  return cut;
}

}  // namespace

Bisected bisected(const Mesh& mesh, const std::vector<char>& marked) {
  OVERCAST_REQUIRE(marked.size() == mesh.triangles.size(), "{} marks for {} triangles", marked.size(), mesh.triangles.size());
  Job job;
  job.place = placesOf(mesh.positions);
  std::vector<char> wanted;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const glm::dvec3 a = mesh.positions[t.x];
    wanted.push_back(static_cast<char>(marked[i] && glm::length(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a)) > 0.0));
  }
  job.cut = edgesToCut(mesh, job.place, std::move(wanted));
  Mesh& made = job.result.mesh;
  made.name = mesh.name;
  made.positions = mesh.positions;
  made.normals = mesh.normals;
  made.textureCoordinates = mesh.textureCoordinates;
  for (const MeshPart& part : mesh.parts) {
    const auto first = static_cast<std::uint32_t>(made.triangles.size());
    for (std::uint32_t i = part.firstTriangle; i < part.firstTriangle + part.triangleCount; ++i) {
      const glm::uvec3& t = mesh.triangles[i];
      const int c = longestEdge(mesh, job.place, t);
      const bool whole = !job.isCut(t[c], t[(c + 1) % 3]);
      job.emit(whole ? t : glm::uvec3(t[c], t[(c + 1) % 3], t[(c + 2) % 3]), i);
    }
    made.parts.push_back({first, static_cast<std::uint32_t>(made.triangles.size()) - first, part.material});
  }
  return std::move(job.result);
}

}  // namespace overcast
