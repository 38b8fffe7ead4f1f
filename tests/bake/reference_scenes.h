// Scenes of a few triangles for the tests of references, and truth at single points of them.
#pragma once

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bake/reference_trace.h"
#include "formats/scene.h"

namespace overcast::test {

/// Adds a node with a mesh and a base colour.
inline Node& addMesh(Scene& scene, Mesh mesh, const glm::vec3& colour) {
  mesh.parts = {{0, static_cast<std::uint32_t>(mesh.triangles.size()), static_cast<int>(scene.materials.size())}};
  scene.materials.push_back({"", glm::vec4(colour, 1.0f)});
  scene.nodes.emplace_back().mesh = static_cast<int>(scene.meshes.size());
  scene.meshes.push_back(std::move(mesh));
  return scene.nodes.back();
}

/// A parallelogram; triangles 0 and 1 of its mesh. Its outside is where cross(a, b) points.
inline Mesh sheet(const glm::dvec3& corner, const glm::dvec3& a, const glm::dvec3& b) {
  Mesh mesh;
  mesh.positions = {corner, corner + a, corner + a + b, corner + b};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// A square floor of side 2 `half` about the origin, y up.
inline Mesh flatFloor(double half) {
  return sheet({-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half});
}

/// The surface at `position`, which lies on one of the first two triangles (a sheet), seen from `towards`.
inline TracedSurface onSheet(const TracedScene& scene, const glm::dvec3& position, const glm::dvec3& towards) {
  for (std::uint32_t t = 0; t < 2; ++t) {
    const glm::uvec3& corners = scene.mesh.triangles[t];
    const glm::dvec3 a = scene.mesh.positions[corners.x], b = scene.mesh.positions[corners.y] - a, c = scene.mesh.positions[corners.z] - a;
    const glm::dvec3 normal = glm::cross(b, c), p = position - a;
    const double area = glm::dot(normal, normal);
    const double v = glm::dot(glm::cross(p, c), normal) / area, w = glm::dot(glm::cross(b, p), normal) / area;
    if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) return surfaceAt(scene, {t, {1.0 - v - w, v, w}}, towards);
  }
  ADD_FAILURE() << "the point lies on no triangle";
  return {};
}

/// Quantities by name at one point, three channels by their mean.
inline std::map<std::string, double> truthAt(const TracedScene& scene, const TracedSurface& point, const TraceSettings& settings) {
  std::map<std::string, double> truth;
  const auto traced = traceQuantities(scene, std::vector{point}, settings);
  for (const TracedQuantity& quantity : traced.value()) {
    truth[quantity.name] = quantity.mean;
    truth[quantity.name + ".error"] = quantity.meanError;
  }
  return truth;
}

inline TracedScene traced(const Scene& scene, double time = 0.0) {
  auto made = makeTracedScene(scene, time);
  EXPECT_TRUE(made.ok()) << message(made.error());
  return std::move(made).value();
}

}  // namespace overcast::test
