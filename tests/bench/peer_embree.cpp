#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "tests/bench/peers.h"

namespace overcast::bench {
namespace {

struct Scene {
  std::vector<glm::vec3> positions;
  const Mesh& mesh;
};

/// Closest point by regions, in floats (Ericson 2005, "Real-Time Collision Detection", 5.1.5), as in Embree's own tutorial.
glm::vec3 closestPoint(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 ab = b - a;
  const glm::vec3 ac = c - a;
  const float d1 = glm::dot(ab, p - a);
  const float d2 = glm::dot(ac, p - a);
  if (d1 <= 0.0f && d2 <= 0.0f) return a;
  const float d3 = glm::dot(ab, p - b);
  const float d4 = glm::dot(ac, p - b);
  if (d3 >= 0.0f && d4 <= d3) return b;
  const float d5 = glm::dot(ab, p - c);
  const float d6 = glm::dot(ac, p - c);
  if (d6 >= 0.0f && d5 <= d6) return c;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return a + d1 / (d1 - d3) * ab;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return a + d2 / (d2 - d6) * ac;
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0.0f && d4 - d3 >= 0.0f && d5 - d6 >= 0.0f) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const float denominator = 1.0f / (va + vb + vc);
  return a + vb * denominator * ab + vc * denominator * ac;
}

bool visitTriangle(RTCPointQueryFunctionArguments* arguments) {
  const auto& scene = *static_cast<const Scene*>(arguments->userPtr);
  const glm::uvec3 corners = scene.mesh.triangles[arguments->primID];
  const glm::vec3 p(arguments->query->x, arguments->query->y, arguments->query->z);
  const float distance =
      glm::length(p - closestPoint(p, scene.positions[corners.x], scene.positions[corners.y], scene.positions[corners.z]));
  if (distance >= arguments->query->radius) return false;
  arguments->query->radius = distance;
  return true;
}

RTCScene makeScene(RTCDevice device, const Scene& scene, RTCPointQueryFunction visit) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, scene.positions.data(), 0, sizeof(glm::vec3),
                             scene.positions.size() - 1);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, scene.mesh.triangles.data(), 0, sizeof(glm::uvec3),
                             scene.mesh.triangles.size());
  rtcSetGeometryPointQueryFunction(geometry, visit);
  rtcCommitGeometry(geometry);
  const RTCScene result = rtcNewScene(device);
  rtcAttachGeometry(result, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(result);
  return result;
}

}  // namespace

std::vector<float> embreeDistance(const Mesh& mesh, const Grid& grid) {
  Scene scene{{}, mesh};
  for (const glm::dvec3& position : mesh.positions) scene.positions.emplace_back((position - grid.origin) / grid.voxelSize);
  scene.positions.emplace_back(0.0f);  // Embree reads whole vectors: one vertex of padding
  const RTCDevice device = rtcNewDevice(nullptr);
  const RTCScene tree = makeScene(device, scene, visitTriangle);
  std::vector<float> distance(sampleCount(grid));
  tbb::parallel_for(0, grid.size.y * grid.size.z, [&](int row) {
    float* out = distance.data() + static_cast<std::ptrdiff_t>(row) * grid.size.x;
    float bound = std::numeric_limits<float>::infinity();
    for (int x = 0; x < grid.size.x; ++x) {
      RTCPointQuery query{static_cast<float>(x), static_cast<float>(row % grid.size.y), static_cast<float>(row / grid.size.y), 0.0f, bound};
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      rtcPointQuery(tree, &query, &context, nullptr, &scene);
      out[x] = static_cast<float>(static_cast<double>(query.radius) * grid.voxelSize);
      bound = query.radius + 1.001f;
    }
  });
  rtcReleaseScene(tree);
  rtcReleaseDevice(device);
  return distance;
}

std::vector<NearestPoint> embreeNearest(const Mesh& mesh, const Grid& grid) {
  Scene scene{{}, mesh};
  for (const glm::dvec3& position : mesh.positions) scene.positions.emplace_back((position - grid.origin) / grid.voxelSize);
  scene.positions.emplace_back(0.0f);
  const RTCDevice device = rtcNewDevice(nullptr);
  struct Search {
    const Scene& scene;
    std::uint32_t triangle = 0;
    glm::vec3 point{0.0f};
  };
  const auto visit = [](RTCPointQueryFunctionArguments* arguments) {
    auto& search = *static_cast<Search*>(arguments->userPtr);
    const glm::uvec3 t = search.scene.mesh.triangles[arguments->primID];
    const glm::vec3 p(arguments->query->x, arguments->query->y, arguments->query->z);
    const auto& positions = search.scene.positions;
    const glm::vec3 point = closestPoint(p, positions[t.x], positions[t.y], positions[t.z]);
    const float distance = glm::length(p - point);
    if (distance >= arguments->query->radius) return false;
    search.triangle = arguments->primID;
    search.point = point;
    arguments->query->radius = distance;
    return true;
  };
  const RTCScene tree = makeScene(device, scene, visit);
  std::vector<NearestPoint> nearest(sampleCount(grid));
  tbb::parallel_for(std::size_t{0}, nearest.size(), [&](std::size_t i) {
    const auto nx = static_cast<std::size_t>(grid.size.x), ny = static_cast<std::size_t>(grid.size.y);
    Search search{scene};
    RTCPointQuery query{static_cast<float>(i % nx), static_cast<float>(i / nx % ny), static_cast<float>(i / nx / ny), 0.0f,
                        std::numeric_limits<float>::infinity()};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(tree, &query, &context, nullptr, &search);
    nearest[i] = {search.triangle, grid.origin + grid.voxelSize * glm::dvec3(search.point)};
  });
  rtcReleaseScene(tree);
  rtcReleaseDevice(device);
  return nearest;
}

}  // namespace overcast::bench
