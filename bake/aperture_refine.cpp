#include "bake/aperture_refine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

#include "bake/aperture.h"
#include "bake/mesh_bisect.h"

namespace overcast {
namespace {

constexpr int kMostRounds = 64;
constexpr float kUnknown = -1.0f;  // of a point in a solid

const std::array<glm::dvec3, 4> kLooks{{{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, {0.5, 0.5, 0.0}, {0.0, 0.5, 0.5}, {0.5, 0.0, 0.5}}};

struct Job {
  const Occluders& occluders;
  const RefineSettings& settings;
  const Progress& progress;
  Mesh mesh;
  std::vector<float> seen;    ///< at the vertices that were looked from
  std::vector<double> wrong;  ///< per triangle: by how much interpolation errs; below 0: not known yet
};

std::vector<float> look(const Job& job, const std::vector<SurfacePoint>& points) {
  std::vector<float> ambient;
  for (const PointVisibility& point : traceVisibility(job.occluders, points, job.settings.visibility, job.progress))
    ambient.push_back(point.interior ? kUnknown : point.ambient);
  return ambient;
}

/// Looks from the vertices that are new, a little within a triangle of theirs, else they lie in the plane of the wall behind a sharp edge.
void lookFromVertices(Job& job) {
  const std::size_t known = job.seen.size();
  const double pull = kVertexPull * diagonal(bounds(job.mesh));
  std::vector<SurfacePoint> points;
  for (std::size_t v = known; v < job.mesh.positions.size(); ++v) points.push_back({job.mesh.positions[v], job.mesh.normals[v]});
  for (const glm::uvec3& t : job.mesh.triangles)
    for (int c = 0; c < 3; ++c) {
      if (t[c] < known) continue;
      const glm::dvec3 way = (job.mesh.positions[t.x] + job.mesh.positions[t.y] + job.mesh.positions[t.z]) / 3.0 - job.mesh.positions[t[c]];
      if (const double length = glm::length(way); length > 0.0)
        points[t[c] - known].position = job.mesh.positions[t[c]] + pull / length * way;
    }
  const std::vector<float> ambient = look(job, points);
  job.seen.insert(job.seen.end(), ambient.begin(), ambient.end());
}

/// How far interpolation is off at one point. Where solids begin it is off by all there is.
double errorAt(const Job& job, const glm::uvec3& t, const glm::dvec3& weight, float there) {
  double sum = 0.0;
  int unknown = there == kUnknown;
  for (int c = 0; c < 3; ++c) {
    unknown += job.seen[t[c]] == kUnknown;
    sum += weight[c] * std::max(job.seen[t[c]], 0.0f);
  }
  if (unknown > 0) return unknown == 4 ? 0.0 : 1.0;
  return std::abs(sum - double{there});
}

/// Finds how wrong the triangles are that nobody looked at.
void lookAtTriangles(Job& job) {
  std::vector<std::size_t> fresh;
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < job.wrong.size(); ++i) {
    if (job.wrong[i] >= 0.0) continue;
    fresh.push_back(i);
    for (const glm::dvec3& weight : kLooks) points.push_back(surfacePoint(job.mesh, {static_cast<std::uint32_t>(i), weight}));
  }
  const std::vector<float> ambient = look(job, points);
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    double& wrong = job.wrong[fresh[i]];
    wrong = 0.0;
    for (std::size_t k = 0; k < kLooks.size(); ++k)
      wrong = std::max(wrong, errorAt(job, job.mesh.triangles[fresh[i]], kLooks[k], ambient[kLooks.size() * i + k]));
  }
}

struct Wish {
  double worth;
  std::uint32_t triangle;
};

/// Triangles to cut, those that err most over the largest area first, at most as many as there are vertices left.
std::vector<char> chosen(const Job& job) {
  const double shortest = kRefineEdge * diagonal(bounds(job.mesh));
  std::vector<Wish> wishes;
  for (std::uint32_t i = 0; i < job.wrong.size(); ++i) {
    const glm::uvec3& t = job.mesh.triangles[i];
    const glm::dvec3 a = job.mesh.positions[t.x], b = job.mesh.positions[t.y], c = job.mesh.positions[t.z];
    const double edge = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    if (job.wrong[i] > kRefineError && edge > shortest) wishes.push_back({job.wrong[i] * glm::length(glm::cross(b - a, c - a)), i});
  }
  std::sort(wishes.begin(), wishes.end(),
            [](const Wish& a, const Wish& b) { return a.worth != b.worth ? a.worth > b.worth : a.triangle < b.triangle; });
  wishes.resize(std::min(wishes.size(), job.settings.vertices - job.mesh.positions.size()));
  std::vector<char> marked(job.wrong.size(), 0);
  for (const Wish& wish : wishes) marked[wish.triangle] = 1;
  return marked;
}

}  // namespace

Mesh refined(Mesh mesh, const Occluders& occluders, const RefineSettings& settings, const Progress& progress) {
  OVERCAST_REQUIRE(mesh.normals.size() == mesh.positions.size(), "{} normals for {} vertices", mesh.normals.size(), mesh.positions.size());
  if (mesh.positions.size() >= settings.vertices) return mesh;
  Job job{occluders, settings, progress, std::move(mesh), {}, {}};
  job.wrong.assign(job.mesh.triangles.size(), -1.0);
  for (int round = 0; round < kMostRounds && job.mesh.positions.size() < settings.vertices; ++round) {
    if (progress && !progress(0.0)) break;
    lookFromVertices(job);
    lookAtTriangles(job);
    const std::vector<char> marked = chosen(job);
    if (std::find(marked.begin(), marked.end(), 1) == marked.end()) break;
    Bisected next = bisected(job.mesh, marked);
    std::vector<double> wrong;
    for (std::size_t i = 0; i < next.from.size(); ++i) {
      const bool whole = next.mesh.triangles[i] == job.mesh.triangles[next.from[i]];
      wrong.push_back(whole ? job.wrong[next.from[i]] : -1.0);
    }
    job.mesh = std::move(next.mesh);
    job.wrong = std::move(wrong);
  }
  return std::move(job.mesh);
}

}  // namespace overcast
