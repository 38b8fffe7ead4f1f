#include "bake/traced_scene.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <embree3/rtcore.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "bake/ray_scene.h"

namespace overcast {
namespace {

constexpr int kProbes = 64;

void addMesh(const Scene& scene, std::size_t node, const glm::dmat4& world, TracedScene& traced) {
  const Mesh& mesh = scene.meshes[static_cast<std::size_t>(scene.nodes[node].mesh)];
  const glm::dmat3 linear(world);
  // The cofactors are the inverse transpose times the determinant; they exist for flattened meshes, too.
  const double sign = glm::determinant(linear) < 0.0 ? -1.0 : 1.0;
  const glm::dmat3 turned(sign * glm::cross(linear[1], linear[2]), sign * glm::cross(linear[2], linear[0]),
                          sign * glm::cross(linear[0], linear[1]));
  const double size = std::max({glm::length(turned[0]), glm::length(turned[1]), glm::length(turned[2])});
  const auto first = static_cast<std::uint32_t>(traced.mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    traced.mesh.positions.emplace_back(world * glm::dvec4(mesh.positions[i], 1.0));
    const bool none = mesh.normals.empty() || !(size > 0.0);
    traced.mesh.normals.push_back(none ? glm::vec3(0.0f) : glm::vec3(turned * glm::dvec3(mesh.normals[i]) / size));
  }
  for (const MeshPart& part : mesh.parts) {
    const glm::vec4 colour =
        part.material < 0 ? Material{}.baseColour : scene.materials[static_cast<std::size_t>(part.material)].baseColour;
    for (std::uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
      const glm::uvec3 triangle = mesh.triangles[t] + first;
      traced.mesh.triangles.push_back(sign < 0.0 ? glm::uvec3(triangle.x, triangle.z, triangle.y) : triangle);
      traced.node.push_back(static_cast<int>(node));
      traced.colour.emplace_back(colour.x, colour.y, colour.z);
    }
  }
}

void addLights(const Lighting& lighting, const std::vector<glm::dmat4>& nodes, TracedScene& traced) {
  traced.sky = glm::dvec3(lighting.skyColour);
  traced.up = glm::normalize(glm::dvec3(lighting.up));
  if (lighting.sun) {
    const double radius = static_cast<double>(lighting.sun->angularRadius), sine = std::sin(0.5 * radius);
    const double solidAngle = 4.0 * std::numbers::pi * sine * sine;
    traced.lights.push_back(
        {glm::normalize(glm::dvec3(lighting.sun->direction)), radius, glm::dvec3(lighting.sun->colour) / solidAngle, true});
  }
  for (const AreaLight& light : lighting.areaLights) {
    glm::dvec3 place(light.position);
    if (light.node >= 0) place = glm::dvec3(nodes[static_cast<std::size_t>(light.node)] * glm::dvec4(place, 1.0));
    traced.lights.push_back({place, static_cast<double>(light.radius), glm::dvec3(light.colour), false});
  }
}

glm::vec3 unitsFromWorld(const RayScene& rays, const glm::dvec3& position) {
  return glm::vec3((position - rays.centre) * rays.scale);
}

RTCRay rayOf(const glm::vec3& origin, const glm::vec3& direction, float nearest, float farthest) {
  RTCRay ray{};
  ray.org_x = origin.x;
  ray.org_y = origin.y;
  ray.org_z = origin.z;
  ray.dir_x = direction.x;
  ray.dir_y = direction.y;
  ray.dir_z = direction.z;
  ray.tnear = nearest;
  ray.tfar = farthest;
  ray.mask = ~0u;
  return ray;
}

RTCRayHit trace(const RayScene& rays, const RTCRay& ray) {
  RTCRayHit query{ray, {}};
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(rays.scene, &context, &query);
  return query;
}

bool isFree(const RayScene& rays, const glm::vec3& from, const glm::vec3& to) {
  RTCRay ray = rayOf(from, to - from, 0.0f, 1.0f);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(rays.scene, &context, &ray);
  return ray.tfar >= 0.0f;
}

}  // namespace

Result<TracedScene> makeTracedScene(const Scene& scene, double time, const SkyImage* skyImage) {
  TracedScene traced;
  const std::vector<glm::dmat4> nodes = worldFromLocal(scene, time);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (scene.nodes[i].mesh >= 0) addMesh(scene, i, nodes[i], traced);
  addLights(scene.lighting.value_or(Lighting{}), nodes, traced);
  if (skyImage != nullptr) {
    traced.sky = skyImage->mean;
    traced.skyImage = skyImage;
  }
  auto rays = makeRayScene(traced.mesh);
  if (!rays) return rays.error();
  traced.rays = std::move(rays).value();
  return traced;
}

TracedSurface surfaceAt(const TracedScene& scene, const SurfaceSample& sample, const glm::dvec3& towards, bool smooth) {
  const glm::uvec3& t = scene.mesh.triangles[sample.triangle];
  std::array<glm::dvec3, 3> corners, normals;
  TracedSurface surface;
  surface.triangle = sample.triangle;
  glm::dvec3 normal(0.0);
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    corners[i] = scene.mesh.positions[t[c]];
    normals[i] = glm::dvec3(scene.mesh.normals[t[c]]);
    surface.position += sample.weight[c] * corners[i];
    normal += sample.weight[c] * normals[i];
  }
  const glm::dvec3 across = glm::cross((corners[1] - corners[0]) * scene.rays->scale, (corners[2] - corners[0]) * scene.rays->scale);
  const glm::dvec3 viewer = glm::normalize(towards);
  surface.face = glm::dot(across, across) > 0.0 ? glm::normalize(across) : viewer;
  if (glm::dot(surface.face, viewer) < 0.0) surface.face = -surface.face;
  const double side = glm::dot(normal, surface.face) < 0.0 ? -1.0 : 1.0;
  surface.normal = glm::dot(normal, normal) > 0.0 ? side * glm::normalize(normal) : surface.face;
  // Towards the viewer, too: that way is known to be free, also in the very corner where another solid begins.
  const glm::dvec3 above = surface.position + kRayOffset / scene.rays->scale * (surface.face + viewer);
  surface.start = unitsFromWorld(*scene.rays, above);
  if (!smooth) return surface;
  for (glm::dvec3& n : normals) n = glm::dot(n, n) > 0.0 ? side * glm::normalize(n) : glm::dvec3(0.0);
  const glm::vec3 lifted = unitsFromWorld(*scene.rays, above + liftAt(corners, normals, sample.weight));
  if (lifted != surface.start && isFree(*scene.rays, surface.start, lifted)) surface.start = lifted;
  return surface;
}

std::optional<TracedHit> firstHit(const TracedScene& scene, const glm::dvec3& origin, const glm::dvec3& direction, double nearest) {
  const RayScene& rays = *scene.rays;
  const RTCRayHit found = trace(rays, rayOf(unitsFromWorld(rays, origin), glm::vec3(direction), static_cast<float>(nearest * rays.scale),
                                            std::numeric_limits<float>::infinity()));
  if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const double u = static_cast<double>(found.hit.u), v = static_cast<double>(found.hit.v);
  TracedHit hit;
  hit.surface = surfaceAt(scene, {found.hit.primID, {1.0 - u - v, u, v}}, -direction);
  hit.distance = glm::dot(hit.surface.position - origin, direction);
  return hit;
}

bool liesInside(const TracedScene& scene, const TracedSurface& surface) {
  const auto frame = frameOf(surface.normal, 0.0);
  int backs = 0;
  for (const glm::dvec3& d : hemisphereDirections(kProbes)) {
    const glm::vec3 direction(frame[0] * d.x + frame[1] * d.y + frame[2] * d.z);
    const RTCRayHit found = trace(*scene.rays, rayOf(surface.start, direction, 0.0f, std::numeric_limits<float>::infinity()));
    if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
    backs += glm::dot(glm::vec3(found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z), direction) > 0.0f;
  }
  return 2 * backs > kProbes;
}

}  // namespace overcast
