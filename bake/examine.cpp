#include "bake/examine.h"

#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

#include "bake/edges.h"
#include "bake/sign.h"
#include "bake/surface_samples.h"

namespace overcast {
namespace {

constexpr std::uint64_t kEdges = 200000;
constexpr std::size_t kThinPoints = 2048;
constexpr std::size_t kSidePoints = 1024;
constexpr float kFromEnds = 1e-3f;  // of an edge
constexpr double kOffSide = 1e-4;   // of the diagonal: so far off the surface its sides are looked at

/// The mesh in Embree, scaled to about unit size.
class RayScene {
 public:
  explicit RayScene(const Mesh& mesh) : mesh_(mesh), scale_(1.0 / diagonal(bounds(mesh))) {
    for (const glm::dvec3& p : mesh.positions) positions_.emplace_back(p * scale_);
    positions_.emplace_back(0.0f);  // Embree reads whole vectors: one vertex of padding
    device_ = rtcNewDevice(nullptr);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    auto* const geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions_.data(), 0, sizeof(glm::vec3),
                               positions_.size() - 1);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0, sizeof(glm::uvec3),
                               mesh.triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    OVERCAST_REQUIRE(rtcGetDeviceError(device_) == RTC_ERROR_NONE, "Embree cannot take {} triangles", mesh.triangles.size());
  }
  ~RayScene() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// Whether the edge a - b passes through a triangle that has neither of them as a corner.
  bool pierces(std::uint32_t a, std::uint32_t b) const {
    struct Context {
      RTCIntersectContext embree;
      const Mesh* mesh;
      std::uint32_t a, b;
    } context{{}, &mesh_, a, b};
    rtcInitIntersectContext(&context.embree);
    context.embree.filter = [](const RTCFilterFunctionNArguments* arguments) {
      const auto& edge = *reinterpret_cast<const Context*>(arguments->context);
      const glm::uvec3& t = edge.mesh->triangles[RTCHitN_primID(arguments->hit, arguments->N, 0)];
      for (int i = 0; i < 3; ++i)
        if (t[i] == edge.a || t[i] == edge.b) arguments->valid[0] = 0;
    };
    RTCRay ray = rayFrom(positions_[a], positions_[b] - positions_[a]);
    ray.tnear = kFromEnds;
    ray.tfar = 1.0f - kFromEnds;
    rtcOccluded1(scene_, &context.embree, &ray);
    return ray.tfar < 0.0f;
  }

  /// Whether another piece of the surface that faces away lies within `reach` behind the point.
  bool isThin(const glm::dvec3& point, const glm::dvec3& normal, double reach) const {
    RTCRayHit query{};
    query.ray = rayFrom(glm::vec3(point * scale_), -glm::vec3(normal));
    query.ray.tnear = 1e-5f;
    query.ray.tfar = static_cast<float>(reach * scale_);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context{};
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    const glm::uvec3& t = mesh_.triangles[query.hit.primID];
    const glm::dvec3& a = mesh_.positions[t.x];
    return glm::dot(glm::cross(mesh_.positions[t.y] - a, mesh_.positions[t.z] - a), normal) < 0.0;
  }

 private:
  static RTCRay rayFrom(const glm::vec3& origin, const glm::vec3& direction) {
    RTCRay ray{};
    ray.org_x = origin.x, ray.org_y = origin.y, ray.org_z = origin.z;
    ray.dir_x = direction.x, ray.dir_y = direction.y, ray.dir_z = direction.z;
    ray.mask = 0xffffffffu;
    return ray;
  }

  const Mesh& mesh_;
  double scale_ = 1.0;
  std::vector<glm::vec3> positions_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
};

void countPiercing(const Mesh& mesh, const RayScene& scene, SurfaceReport& report) {
  std::vector<DirectedEdge> edges;
  forEachEdge(edgeUses(mesh.triangles), [&](auto first, auto) { edges.push_back({first->low, first->high}); });
  report.edges = edges.size();
  report.edgesChecked = std::min<std::uint64_t>(edges.size(), kEdges);
  std::atomic<std::uint64_t> piercing = 0;
  tbb::parallel_for(std::uint64_t{0}, report.edgesChecked, [&](std::uint64_t n) {
    const DirectedEdge& edge = edges[n * report.edges / report.edgesChecked];
    if (scene.pierces(edge.from, edge.to)) ++piercing;
  });
  report.edgesPiercing = piercing;
}

double shareOf(std::size_t count, std::size_t all) {
  return all == 0 ? 0.0 : static_cast<double>(count) / static_cast<double>(all);
}

double innerShareOf(const Mesh& mesh) {
  const SurfaceSamples samples = sampleSurface(mesh, kSidePoints);
  const double off = kOffSide * diagonal(bounds(mesh));
  std::vector<glm::dvec3> sides;
  for (std::size_t i = 0; i < samples.points.size(); ++i)
    for (const double way : {-off, off}) sides.push_back(samples.points[i] + way * samples.normals[i]);
  const std::vector<double> winding = windingAt(mesh, latticeGrid(mesh), sides);
  std::size_t inner = 0;
  for (std::size_t i = 0; i + 1 < winding.size(); i += 2) inner += std::abs(winding[i]) > 0.5 && std::abs(winding[i + 1]) > 0.5 ? 1 : 0;
  return shareOf(inner, samples.points.size());
}

}  // namespace

SurfaceReport examineSurface(const RepairedMesh& repaired, double thin) {
  const Mesh& mesh = repaired.mesh;
  SurfaceReport report;
  report.thin = thin;
  if (!(diagonal(bounds(mesh)) > 0.0)) return report;
  const RayScene scene(mesh);
  countPiercing(mesh, scene, report);
  const SurfaceSamples samples = sampleSurface(mesh, kThinPoints);
  std::size_t thinPoints = 0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) thinPoints += scene.isThin(samples.points[i], samples.normals[i], thin) ? 1 : 0;
  report.thinShare = shareOf(thinPoints, samples.points.size());
  if (report.edgesPiercing > 0 || repaired.found.components > 1) report.innerShare = innerShareOf(mesh);
  return report;
}

}  // namespace overcast
