#include "tests/bench/ray_traced.h"

#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "runtime/sky_light.h"

namespace overcast::bench {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kOffset = 2e-6;  ///< of ray origins, times the scene's diagonal

struct Corner {
  glm::vec3 position;  ///< relative to the scene's centre
  glm::vec3 normal;    ///< zero where there is none
};

/// All triangles of a scene at one time, and what rays need to know of them.
struct Traced {
  std::vector<Corner> corners;     ///< three for each triangle
  std::vector<glm::vec3> colours;  ///< one for each triangle
  glm::dvec3 centre{0.0};
  double offset = 0.0;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

struct Hit {
  glm::dvec3 position;
  glm::dvec3 face;
  glm::dvec3 normal;
  glm::dvec3 colour;
};

void addMesh(const Scene& scene, const Mesh& mesh, const glm::dmat4& world, Traced& traced) {
  const glm::dmat3 linear(world);
  const glm::dmat3 turned = glm::transpose(glm::inverse(linear));
  for (const MeshPart& part : mesh.parts) {
    const glm::vec4 colour =
        part.material < 0 ? Material{}.baseColour : scene.materials[static_cast<std::size_t>(part.material)].baseColour;
    for (std::uint32_t t = part.firstTriangle; t < part.firstTriangle + part.triangleCount; ++t) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t i = mesh.triangles[t][k];
        const glm::dvec3 normal = mesh.normals.empty() ? glm::dvec3(0.0) : turned * glm::dvec3(mesh.normals[i]);
        traced.corners.push_back({glm::vec3(glm::dvec3(world * glm::dvec4(mesh.positions[i], 1.0)) - traced.centre),
                                  glm::dot(normal, normal) > 0.0 ? glm::vec3(glm::normalize(normal)) : glm::vec3(0.0f)});
      }
      traced.colours.emplace_back(colour.x, colour.y, colour.z);
    }
  }
}

Traced makeTraced(const Scene& scene, double time) {
  Traced traced;
  const std::vector<glm::dmat4> nodes = worldFromLocal(scene, time);
  const Box box = worldBounds(scene);
  traced.centre = centre(box);
  traced.offset = kOffset * diagonal(box);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (const int mesh = scene.nodes[i].mesh; mesh >= 0) addMesh(scene, scene.meshes[static_cast<std::size_t>(mesh)], nodes[i], traced);
  traced.device = rtcNewDevice(nullptr);
  traced.scene = rtcNewScene(traced.device);
  rtcSetSceneFlags(traced.scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(traced.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* positions = static_cast<glm::vec3*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), traced.corners.size()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), traced.colours.size()));
  for (std::size_t i = 0; i < traced.corners.size(); ++i) {
    positions[i] = traced.corners[i].position;
    indices[i] = static_cast<std::uint32_t>(i);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(traced.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(traced.scene);
  return traced;
}

RTCRay rayOf(const glm::dvec3& from, const glm::dvec3& direction, double far) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(from.x);
  ray.org_y = static_cast<float>(from.y);
  ray.org_z = static_cast<float>(from.z);
  ray.dir_x = static_cast<float>(direction.x);
  ray.dir_y = static_cast<float>(direction.y);
  ray.dir_z = static_cast<float>(direction.z);
  ray.tfar = static_cast<float>(far);
  ray.mask = 0xffffffffu;
  return ray;
}

std::optional<Hit> firstHit(const Traced& traced, const glm::dvec3& from, const glm::dvec3& direction) {
  RTCRayHit query{rayOf(from, direction, 1e30), {}};
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(traced.scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Corner* corners = &traced.corners[std::size_t{3} * query.hit.primID];
  const double u = query.hit.u, v = query.hit.v;
  const auto blend = [&](auto member) {
    return (1.0 - u - v) * glm::dvec3(corners[0].*member) + u * glm::dvec3(corners[1].*member) + v * glm::dvec3(corners[2].*member);
  };
  Hit hit;
  hit.position = blend(&Corner::position);
  hit.face = glm::normalize(glm::dvec3(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z));
  if (glm::dot(hit.face, direction) > 0.0) hit.face = -hit.face;
  const glm::dvec3 normal = blend(&Corner::normal);
  hit.normal = glm::dot(normal, normal) > 0.0 ? glm::normalize(normal) : hit.face;
  if (glm::dot(hit.normal, hit.face) < 0.0) hit.normal = -hit.normal;
  hit.colour = traced.colours[query.hit.primID];
  return hit;
}

bool isFree(const Traced& traced, const Hit& hit, const glm::dvec3& direction, double far) {
  if (glm::dot(direction, hit.face) <= 0.0) return false;
  RTCRay ray = rayOf(hit.position + traced.offset * hit.face, direction, far);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(traced.scene, &context, &ray);
  return ray.tfar >= 0.0f;
}

/// A light as seen from a point.
struct SeenLight {
  glm::dvec3 axis{0.0};
  double height = 0.0;    ///< 1 minus the cosine of its cap's radius
  double distance = 0.0;  ///< to its middle; 0: the sun
  double radius = 0.0;
  glm::dvec3 radiance{0.0};
};

/// How far its surface is in a direction of its cap.
double farOf(const SeenLight& light, const glm::dvec3& direction) {
  if (light.distance == 0.0) return 1e30;
  const double along = light.distance * glm::dot(direction, light.axis);
  return along - std::sqrt(std::max(along * along - light.distance * light.distance + light.radius * light.radius, 0.0));
}

std::vector<SeenLight> lightsFrom(const Lighting& lighting, const std::vector<glm::dmat4>& nodes, const glm::dvec3& point) {
  std::vector<SeenLight> seen;
  const auto heightOf = [](double radius) { return 2.0 * std::pow(std::sin(0.5 * radius), 2.0); };
  if (lighting.sun) {
    const double height = heightOf(static_cast<double>(lighting.sun->angularRadius));
    seen.push_back({glm::dvec3(lighting.sun->direction), height, 0.0, 0.0, glm::dvec3(lighting.sun->colour) / (2.0 * kPi * height)});
  }
  for (const AreaLight& light : lighting.areaLights) {
    glm::dvec3 place(light.position);
    if (light.node >= 0) place = glm::dvec3(nodes[static_cast<std::size_t>(light.node)] * glm::dvec4(place, 1.0));
    const double distance = glm::length(place - point), radius = static_cast<double>(light.radius);
    if (distance <= radius) continue;
    seen.push_back({(place - point) / distance, heightOf(std::asin(radius / distance)), distance, radius, glm::dvec3(light.colour)});
  }
  return seen;
}

struct Frame {
  glm::dvec3 x, y, z;
};

Frame frameAbout(const glm::dvec3& z) {
  const glm::dvec3 x = glm::normalize(glm::cross(z, std::abs(z.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
  return {x, glm::cross(z, x), z};
}

/// Point i of n of a Fibonacci set over a cap of that height about the frame's z, uniform in solid angle, turned by `turn`.
glm::dvec3 capPoint(const Frame& frame, double height, int i, int n, double turn) {
  const double h = height * (i + 0.5) / n, sine = std::sqrt(h * (2.0 - h)), angle = turn + 2.39996322972865332 * i;
  return (1.0 - h) * frame.z + sine * (std::cos(angle) * frame.x + std::sin(angle) * frame.y);
}

RayTracedPixel shade(const Traced& traced, const Hit& hit, const Lighting& lighting, const SkyHarmonics& sky,
                     const std::vector<glm::dmat4>& nodes, double turn, const RayTracedSettings& settings) {
  const std::vector<SeenLight> lights = lightsFrom(lighting, nodes, hit.position + traced.centre);
  RayTracedPixel pixel;
  pixel.surface = lights.size() == lighting.areaLights.size() + (lighting.sun ? 1 : 0);
  glm::dvec3 received(0.0);
  for (const SeenLight& light : lights) {
    const Frame frame = frameAbout(light.axis);
    double sum = 0.0;
    for (int i = 0; i < settings.lightRays; ++i) {
      const glm::dvec3 direction = capPoint(frame, light.height, i, settings.lightRays, turn);
      const double cosine = glm::dot(direction, hit.normal);
      if (cosine > 0.0 && isFree(traced, hit, direction, farOf(light, direction))) sum += cosine;
    }
    received += light.radiance * (2.0 * light.height * sum / settings.lightRays);
  }
  pixel.lights = glm::vec3(hit.colour * received);
  const Frame frame = frameAbout(hit.normal);
  const shared::SkyLight dome = skyLight(sky);
  glm::dvec3 sum(0.0);
  double free = 0.0;
  for (int i = 0; i < settings.skyRays; ++i) {
    const glm::dvec3 direction = capPoint(frame, 1.0, i, settings.skyRays, turn);
    const bool lit = std::any_of(lights.begin(), lights.end(),
                                 [&](const SeenLight& light) { return glm::dot(direction, light.axis) > 1.0 - light.height; });
    if (lit || !isFree(traced, hit, direction, 1e30)) continue;
    const double cosine = glm::dot(direction, hit.normal);
    free += cosine;
    sum += cosine * glm::dvec3(shared::skyRadiance(dome, glm::vec3(direction)));
  }
  pixel.visible = 2.0 * free / settings.skyRays;
  pixel.sky = glm::vec3(hit.colour * sum * (2.0 / settings.skyRays));
  return pixel;
}

}  // namespace

std::vector<RayTracedPixel> rayTrace(const Scene& scene, const Lighting& lighting, const SkyHarmonics& sky, double time, const View& view,
                                     const RayTracedSettings& settings) {
  const Traced traced = makeTraced(scene, time);
  const std::vector<glm::dmat4> nodes = worldFromLocal(scene, time);
  const glm::dmat4 relativeFromClip = glm::inverse(clipFromRelative(view, static_cast<double>(settings.width) / settings.height));
  const glm::dvec3 from = eye(view) - traced.centre;
  std::vector<RayTracedPixel> pixels(static_cast<std::size_t>(settings.width) * static_cast<std::size_t>(settings.height));
  tbb::parallel_for(0, settings.height, [&](int y) {
    for (int x = 0; x < settings.width; ++x) {
      const glm::dvec4 far =
          relativeFromClip * glm::dvec4((2 * x + 1.0) / settings.width - 1.0, (2 * y + 1.0) / settings.height - 1.0, 0.5, 1.0);
      const std::optional<Hit> hit = firstHit(traced, from, glm::normalize(glm::dvec3(far) / far.w));
      const std::size_t index = static_cast<std::size_t>(y) * static_cast<std::size_t>(settings.width) + static_cast<std::size_t>(x);
      // Each pixel turns its directions by an angle of its own (the golden ratio's multiples spread evenly).
      if (hit)
        pixels[index] = shade(traced, *hit, lighting, sky, nodes, 2.0 * kPi * 0.61803398874989485 * static_cast<double>(index), settings);
    }
  });
  rtcReleaseScene(traced.scene);
  rtcReleaseDevice(traced.device);
  return pixels;
}

}  // namespace overcast::bench
