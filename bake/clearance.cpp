#include "bake/clearance.h"

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include <glm/geometric.hpp>

namespace overcast {
namespace {

constexpr double kLeastClearance = 0.125;  ///< of kRayOffset: what lies nearer to a plane may be behind it in single floats
constexpr double kWanted = 1.0;            ///< of kRayOffset
constexpr int kMostSweeps = 4096;

/// Outer normal of a triangle, twice its area long.
glm::dvec3 areaOf(const Mesh& mesh, std::size_t triangle) {
  const glm::uvec3& t = mesh.triangles[triangle];
  return glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
}

/// Triangles with area around a point.
struct Around {
  std::vector<glm::dvec3> faces;  ///< unit outer normals
  glm::dvec3 area{0.0};
};

/// A vector whose product with each face is at least half of kWanted, from `start` on by the relaxation method for linear inequalities
/// (Agmon 1954; Motzkin and Schoenberg 1954). None when it finds none.
std::optional<glm::dvec3> inFrontOf(std::span<const glm::dvec3> faces, glm::dvec3 start) {
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    bool clear = true;
    for (const glm::dvec3& face : faces) {
      const double lies = glm::dot(start, face);
      clear = clear && lies >= 0.5 * kWanted;
      if (lies < kWanted) start += (kWanted - lies) * face;
    }
    if (clear) return start;
  }
  return std::nullopt;
}

}  // namespace

void clearOfTriangles(const Mesh& mesh, std::span<const glm::uvec3> triangles, std::span<const std::uint32_t> vertices,
                      std::span<SurfacePoint> origins) {
  const double offset = kRayOffset * diagonal(bounds(mesh));
  const auto startOf = [&](std::uint32_t point) {
    return (origins[point].position - mesh.positions[vertices[point]]) / offset + glm::dvec3(origins[point].normal);
  };
  std::map<std::uint32_t, Around> blocked;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const glm::dvec3 area = areaOf(mesh, i);
    for (int c = 0; c < 3; ++c)
      if (glm::dot(startOf(triangles[i][c]), area) < kLeastClearance * glm::length(area)) blocked[triangles[i][c]];
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const glm::dvec3 area = areaOf(mesh, i);
    const double length = glm::length(area);
    for (int c = 0; c < 3 && length > 0.0; ++c) {
      const auto found = blocked.find(triangles[i][c]);
      if (found == blocked.end()) continue;
      found->second.faces.push_back(area / length);
      found->second.area += area;
    }
  }
  for (const auto& [point, around] : blocked) {
    const glm::dvec3 normal(origins[point].normal);
    if (!(glm::dot(around.area, normal) > 0.0)) continue;
    const auto start = inFrontOf(around.faces, normal);
    if (!start) continue;
    const double length = glm::length(*start);
    const glm::dvec3 moved = *start * std::min(1.0, kMostLift / length) - normal;
    origins[point].position = mesh.positions[vertices[point]] + offset * moved;
  }
}

}  // namespace overcast
