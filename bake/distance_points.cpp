#include "bake/distance.h"

#include <embree3/rtcore.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <memory>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/triangle.h"

namespace overcast {
namespace {

constexpr std::size_t kPointTile = 64;  // points per task
constexpr double kSlack = 1e-6;         // relative: what single floats inside Embree may lose, many times over

/// The mesh centred at the origin and scaled by a power of two to about unit size, so that Embree's single floats resolve it anywhere.
struct QueryScene {
  std::vector<glm::dvec3> positions;
  std::vector<glm::uvec3> triangles;
  glm::dvec3 centre{0.0};
  double scale = 1.0;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  QueryScene(const Mesh& mesh);
  ~QueryScene() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  QueryScene(const QueryScene&) = delete;
  QueryScene& operator=(const QueryScene&) = delete;
};

void triangleBounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& query = *static_cast<const QueryScene*>(arguments->geometryUserPtr);
  const glm::uvec3 corners = query.triangles[arguments->primID];
  const glm::dvec3 a = query.positions[corners.x];
  const glm::dvec3 b = query.positions[corners.y];
  const glm::dvec3 c = query.positions[corners.z];
  const glm::vec3 low(glm::min(a, glm::min(b, c)) - kSlack);
  const glm::vec3 high(glm::max(a, glm::max(b, c)) + kSlack);
  *arguments->bounds_o = {low.x, low.y, low.z, 0.0f, high.x, high.y, high.z, 0.0f};
}

void requireNoError(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  OVERCAST_REQUIRE(error == RTC_ERROR_NONE, "Embree error {}", static_cast<int>(error));
}

QueryScene::QueryScene(const Mesh& mesh) : triangles(mesh.triangles) {
  OVERCAST_REQUIRE(!mesh.triangles.empty(), "distance to a mesh without triangles");
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high(std::numeric_limits<double>::lowest());
  for (const glm::uvec3& corners : triangles) {
    for (int k = 0; k < 3; ++k) {
      low = glm::min(low, mesh.positions[corners[k]]);
      high = glm::max(high, mesh.positions[corners[k]]);
    }
  }
  centre = 0.5 * (low + high);
  const double size = glm::length(high - low);
  scale = size > 0.0 ? std::exp2(-std::ceil(std::log2(size))) : 1.0;
  positions.reserve(mesh.positions.size());
  for (const glm::dvec3& position : mesh.positions) positions.push_back((position - centre) * scale);

  device = rtcNewDevice(nullptr);
  scene = rtcNewScene(device);
  auto* const geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(triangles.size()));
  rtcSetGeometryUserData(geometry, this);
  rtcSetGeometryBoundsFunction(geometry, triangleBounds, nullptr);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  requireNoError(device);
}

/// One running query: the point in double and the nearest squared distance so far.
struct Nearest {
  const QueryScene& scene;
  glm::dvec3 point;
  double squared;
};

using Coordinates = double[3];

const Coordinates& coordinates(const glm::dvec3& point) {
  return reinterpret_cast<const Coordinates&>(point);
}

float searchRadius(const Nearest& nearest) {
  const double distance = std::sqrt(nearest.squared);
  return static_cast<float>(distance + kSlack * (1.0 + distance + glm::length(nearest.point)));
}

bool visitTriangle(RTCPointQueryFunctionArguments* arguments) {
  auto& nearest = *static_cast<Nearest*>(arguments->userPtr);
  const glm::uvec3 corners = nearest.scene.triangles[arguments->primID];
  const auto& positions = nearest.scene.positions;
  const double squared = squaredDistanceToTriangle(coordinates(nearest.point), coordinates(positions[corners.x]),
                                                   coordinates(positions[corners.y]), coordinates(positions[corners.z]));
  if (squared >= nearest.squared) return false;
  nearest.squared = squared;
  arguments->query->radius = searchRadius(nearest);
  return true;
}

/// Distance in the scaled scene. `bound` is at least the distance: it saves work and cannot change the result.
double nearestDistance(const QueryScene& scene, const glm::dvec3& scaledPoint, double bound) {
  Nearest nearest{scene, scaledPoint, bound * bound};
  const glm::vec3 point(scaledPoint);
  RTCPointQuery query{point.x, point.y, point.z, 0.0f, searchRadius(nearest)};
  nearest.squared = std::numeric_limits<double>::max();
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(scene.scene, &query, &context, visitTriangle, &nearest);
  return std::sqrt(nearest.squared);
}

/// A bound that holds for every triangle of the scene, which lies within half a unit of the origin.
double anyBound(const glm::dvec3& scaledPoint) {
  return glm::length(scaledPoint) + 1.0;
}

}  // namespace

std::vector<double> distanceAt(const Mesh& mesh, std::span<const glm::dvec3> points) {
  const QueryScene scene(mesh);
  std::vector<double> distance(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), kPointTile), [&](const tbb::blocked_range<std::size_t>& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const glm::dvec3 point = (points[i] - scene.centre) * scene.scale;
      distance[i] = nearestDistance(scene, point, anyBound(point)) / scene.scale;
    }
  });
  return distance;
}

}  // namespace overcast
