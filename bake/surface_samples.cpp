#include "bake/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "bake/random.h"

namespace overcast {

SurfaceSamples sampleSurface(const Mesh& mesh, std::size_t count, std::span<const std::uint8_t> skip) {
  const auto taken = [&](std::size_t i) { return skip.empty() || skip[i] == 0; };
  const auto twiceAreaVector = [&](std::size_t i) {
    const glm::uvec3& t = mesh.triangles[i];
    const glm::dvec3& a = mesh.positions[t.x];
    return glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
  };
  double whole = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) whole += taken(i) ? glm::length(twiceAreaVector(i)) : 0.0;
  SurfaceSamples samples;
  double next = 0.5, passed = 0.0;  // in samples
  for (std::size_t i = 0; i < mesh.triangles.size() && whole > 0.0; ++i) {
    if (!taken(i)) continue;
    const glm::dvec3 area = twiceAreaVector(i);
    passed += static_cast<double>(count) * glm::length(area) / whole;
    const glm::uvec3& t = mesh.triangles[i];
    for (; next < passed; next += 1.0) {
      const std::uint64_t n = samples.points.size();
      const double u = std::sqrt(uniform(1, 2 * n)), v = uniform(1, 2 * n + 1);
      samples.points.push_back((1.0 - u) * mesh.positions[t.x] + u * (1.0 - v) * mesh.positions[t.y] + u * v * mesh.positions[t.z]);
      samples.normals.push_back(glm::normalize(area));
      samples.triangle.push_back(static_cast<std::uint32_t>(i));
    }
  }
  return samples;
}

Grid latticeGrid(const Mesh& mesh) {
  constexpr int kCells = 64;
  const Box box = bounds(mesh);
  const glm::dvec3 size = extent(box);
  return {glm::ivec3(kCells + 1), box.min, std::max({size.x, size.y, size.z, std::numeric_limits<double>::min()}) / kCells};
}

}  // namespace overcast
