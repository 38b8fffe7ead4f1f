#include "bake/radius.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>
#include <glm/geometric.hpp>

#include "bake/kernel.h"
#include "bake/repair.h"
#include "formats/shared/cube_map.h"

namespace overcast {
namespace {

Error failure(std::string reason) {
  return Error{"", "", std::move(reason)};
}

double visibleShare(const Mesh& mesh, const glm::dvec3& point) {
  double seen = 0.0, all = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x] - point;
    const glm::dvec3 n = glm::cross(mesh.positions[t.y] - point - a, mesh.positions[t.z] - point - a);
    const double area = glm::length(n);
    all += area;
    if (glm::dot(n, a) > 0.0) seen += area;
  }
  return all > 0.0 ? seen / all : 0.0;
}

/// Centroids of the area and of the volume, relative to `origin`.
std::array<glm::dvec3, 2> centroids(const Mesh& mesh, const glm::dvec3& origin) {
  std::array<glm::dvec3, 2> sum{};
  double area = 0.0, volume = 0.0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x] - origin, b = mesh.positions[t.y] - origin, c = mesh.positions[t.z] - origin;
    const double triangleArea = glm::length(glm::cross(b - a, c - a)), tetrahedron = glm::dot(a, glm::cross(b, c));
    sum[0] += triangleArea / 3.0 * (a + b + c);
    sum[1] += tetrahedron / 4.0 * (a + b + c);
    area += triangleArea;
    volume += tetrahedron;
  }
  return {area > 0.0 ? sum[0] / area : glm::dvec3(0.0), volume > 0.0 ? sum[1] / volume : glm::dvec3(0.0)};
}

struct EmbreeRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using EmbreeDevice = std::unique_ptr<RTCDeviceTy, EmbreeRelease>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, EmbreeRelease>;

/// The mesh about the centre in units of its reach, for rays.
struct Rays {
  const Mesh& mesh;  ///< about the centre, units of `reach`
  EmbreeDevice device;
  EmbreeScene scene;
};

Result<Rays> makeRays(const Mesh& mesh) {
  Rays rays{mesh, EmbreeDevice(rtcNewDevice("threads=1")), nullptr};
  if (!rays.device) return failure("Embree does not start");
  rays.scene.reset(rtcNewScene(rays.device.get()));
  rtcSetSceneFlags(rays.scene.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(rays.device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions.size()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
  if (vertices != nullptr && indices != nullptr) {
    for (const glm::dvec3& p : mesh.positions)
      for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(p[axis]);
    for (const glm::uvec3& t : mesh.triangles)
      for (int corner = 0; corner < 3; ++corner) *indices++ = t[corner];
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(rays.scene.get(), geometry);
    rtcCommitScene(rays.scene.get());
  }
  rtcReleaseGeometry(geometry);
  if (rtcGetDeviceError(rays.device.get()) != RTC_ERROR_NONE) return failure("Embree cannot hold the mesh");
  return rays;
}

/// Distance of the outermost crossing of the ray from the centre along the unit vector; 0 when there is none. Embree names the triangle,
/// its plane gives the distance in double.
double outermost(const Rays& rays, const glm::dvec3& direction) {
  constexpr double kStart = 2.0;  // the mesh lies within 1
  RTCRayHit hit{};
  hit.ray.org_x = static_cast<float>(kStart * direction.x);
  hit.ray.org_y = static_cast<float>(kStart * direction.y);
  hit.ray.org_z = static_cast<float>(kStart * direction.z);
  hit.ray.dir_x = static_cast<float>(-direction.x);
  hit.ray.dir_y = static_cast<float>(-direction.y);
  hit.ray.dir_z = static_cast<float>(-direction.z);
  hit.ray.tfar = static_cast<float>(kStart);
  hit.ray.mask = ~0u;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(rays.scene.get(), &context, &hit);
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return 0.0;
  const double found = kStart - double{hit.ray.tfar};
  const glm::uvec3 t = rays.mesh.triangles[hit.hit.primID];
  const glm::dvec3 a = rays.mesh.positions[t.x];
  const glm::dvec3 n = glm::cross(rays.mesh.positions[t.y] - a, rays.mesh.positions[t.z] - a);
  const double exact = glm::dot(n, a) / glm::dot(n, direction);
  constexpr double kTrusted = 1e-4;  // grazed planes say nothing
  return std::abs(exact - found) <= kTrusted ? exact : found;
}

/// One value of a lattice on the cube.
struct Sample {
  double mean = 0.0;
  double variance = 0.0;
};

/// The coarse places that one place of a fine lattice contributes to along one axis, and by how much.
struct Shares {
  std::array<int, 2> place{0, 0};
  std::array<double, 2> weight{0.0, 0.0};
};

enum class Filter { box, tent };  ///< of one coarse texel, of two

Shares sharesOf(int fine, int fineSide, int coarseSide, Filter filter) {
  const double x = static_cast<double>(fine) * (coarseSide - 1) / (fineSide - 1);
  const int low = std::min(static_cast<int>(x), coarseSide - 2);
  const double t = x - low;
  if (filter == Filter::tent) return {{low, low + 1}, {1.0 - t, t}};
  const double upper = t < 0.5 ? 0.0 : (t > 0.5 ? 1.0 : 0.5);
  return {{low, low + 1}, {1.0 - upper, upper}};
}

/// Sums of weight, weighted value and weighted square.
struct Moments {
  double weight = 0.0, first = 0.0, second = 0.0;
};

/// Every sample goes to the texels whose footprint it is in, weighted by its solid angle; texels that faces share then sum up theirs.
std::vector<Sample> filtered(const std::vector<Sample>& fine, int fineSide, int coarseSide, Filter filter) {
  std::vector<Moments> sums(texelCount(coarseSide));
  for (unsigned face = 0; face < shared::kCubeFaces; ++face)
    for (int j = 0; j < fineSide; ++j)
      for (int i = 0; i < fineSide; ++i) {
        const Sample& sample = fine[texelIndex(fineSide, face, i, j)];
        const glm::dvec3 d = texelDirection(fineSide, face, i, j);
        // The part of the sample's cell on this face.
        const double part = (i == 0 || i == fineSide - 1 ? 0.5 : 1.0) * (j == 0 || j == fineSide - 1 ? 0.5 : 1.0);
        const double solidAngle = part * std::pow(glm::dot(d, d), -1.5);
        const Shares across = sharesOf(i, fineSide, coarseSide, filter), down = sharesOf(j, fineSide, coarseSide, filter);
        for (std::size_t k = 0; k < 4; ++k) {
          const double weight = solidAngle * across.weight[k & 1] * down.weight[k >> 1];
          Moments& sum = sums[texelIndex(coarseSide, face, across.place[k & 1], down.place[k >> 1])];
          sum.weight += weight;
          sum.first += weight * sample.mean;
          sum.second += weight * (sample.variance + sample.mean * sample.mean);
        }
      }
  std::vector<std::size_t> standsFor(sums.size());
  std::vector<Moments> together(sums.size());
  for (unsigned face = 0; face < shared::kCubeFaces; ++face)
    for (int j = 0; j < coarseSide; ++j)
      for (int i = 0; i < coarseSide; ++i) {
        const std::size_t own = texelIndex(coarseSide, face, i, j);
        standsFor[own] = texelTowards(coarseSide, texelDirection(coarseSide, face, i, j));
        Moments& sum = together[standsFor[own]];
        sum.weight += sums[own].weight;
        sum.first += sums[own].first;
        sum.second += sums[own].second;
      }
  std::vector<Sample> coarse(sums.size());
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    const Moments& sum = together[standsFor[i]];
    const double mean = sum.first / sum.weight;
    coarse[i] = {mean, std::max(sum.second / sum.weight - mean * mean, 0.0)};
  }
  return coarse;
}

/// One ray for every place of a lattice fine enough for kRadiusRays along a texel; empty when one found nothing.
std::vector<Sample> castRays(const Rays& rays, int side) {
  std::vector<Sample> samples(texelCount(side));
  std::atomic<bool> missed = false;
  tbb::parallel_for(0, 6 * side, [&](int row) {
    const auto face = static_cast<unsigned>(row / side);
    for (int i = 0; i < side; ++i) {
      const double radius = outermost(rays, glm::normalize(texelDirection(side, face, i, row % side)));
      if (!(radius > 0.0)) missed = true;
      samples[texelIndex(side, face, i, row % side)].mean = radius;
    }
  });
  if (missed) samples.clear();
  return samples;
}

/// Scale of the mesh about `centre`: the largest distance of a vertex in use.
double reachOf(const Mesh& mesh, const glm::dvec3& centre) {
  double reach = 0.0;
  for (const glm::uvec3& t : mesh.triangles)
    for (int corner = 0; corner < 3; ++corner) reach = std::max(reach, glm::length(mesh.positions[t[corner]] - centre));
  return reach;
}

Result<Done> check(const Mesh& mesh, const RadiusSettings& settings) {
  if (settings.side < kSmallestRadiusSide || settings.side > kLargestRadiusSide || (settings.side & (settings.side - 1)) != 0)
    return failure(
        fmt::format("{} texels along a face are not a power of two in {} to {}", settings.side, kSmallestRadiusSide, kLargestRadiusSide));
  const Box box = bounds(mesh);
  if (isEmpty(box)) return failure("mesh has no triangle");
  const double size = diagonal(box);
  // Radii are single floats, their squares too.
  if (!(size > 1e-15) || !(size < 1e15))
    return failure(fmt::format("mesh measures {:.3g} units, a radius field holds 1e-15 to 1e15", size));
  return Done{};
}

}  // namespace

StarCentre starCentre(const Mesh& mesh) {
  const Kernel kernel = findKernel(mesh);
  if (kernel.margin > 0.0) return {kernel.centre, kernel.margin, 1.0};
  const glm::dvec3 middle = centre(bounds(mesh));
  const auto [area, volume] = centroids(mesh, middle);
  StarCentre best{kernel.centre, kernel.margin, visibleShare(mesh, kernel.centre)};
  for (const glm::dvec3& candidate : {middle + volume, middle + area, middle}) {
    const double visible = visibleShare(mesh, candidate);
    if (visible > best.visible) best = {candidate, starMargin(mesh, candidate), visible};
  }
  return best;
}

Result<RadiusField> bakeRadius(const Mesh& mesh, const RadiusSettings& settings, const Progress& progress) {
  if (const Result<Done> checked = check(mesh, settings); !checked) return checked.error();
  RepairedMesh repaired = repair(mesh);
  Mesh& about = repaired.mesh;
  if (about.triangles.empty()) return failure("nothing is left of the mesh after repair");
  if (repaired.found.insideOut)
    for (glm::uvec3& t : about.triangles) std::swap(t.y, t.z);
  RadiusField field;
  field.centre = starCentre(about).centre;
  const double reach = reachOf(about, field.centre);
  for (glm::dvec3& p : about.positions) p = (p - field.centre) / reach;
  const Result<Rays> rays = makeRays(about);
  if (!rays) return rays.error();
  if (progress && !progress(0.2)) return failure("interrupted");
  const int fineSide = (settings.side - 1) * kRadiusRays + 1;
  std::vector<Sample> samples = castRays(rays.value(), fineSide);
  if (samples.empty()) return failure("mesh does not enclose the centre: a ray from there leaves through a hole");
  if (progress && !progress(0.9)) return failure("interrupted");
  samples = filtered(samples, fineSide, settings.side, Filter::box);
  for (int side = settings.side;; side /= 2) {
    RadiusLevel& level = field.levels.emplace_back();
    level.side = side;
    for (const Sample& s : samples)
      level.texel.push_back({static_cast<float>(s.mean * reach), static_cast<float>(s.variance * reach * reach), {}});
    if (side == 2) break;
    samples = filtered(samples, side, side / 2, Filter::tent);
  }
  derive(field);
  if (!isWhole(field)) return failure("the best centre is too close to the surface");
  field = asStored(std::move(field));
  if (!isWhole(field)) return failure("the best centre is too close to the surface");
  return field;
}

}  // namespace overcast
