#include "bake/ray_scene.h"

#include <cmath>
#include <cstdint>

#include <embree3/rtcore.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>

namespace overcast {
namespace {

/// The mesh in the units of the scene, as Embree's one geometry.
void addGeometry(const RayScene& scene, const Mesh& mesh) {
  const RTCGeometry geometry = rtcNewGeometry(scene.device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions.size()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
  if (vertices != nullptr && indices != nullptr) {
    for (const glm::dvec3& position : mesh.positions) {
      const glm::dvec3 p = (position - scene.centre) * scene.scale;
      for (int axis = 0; axis < 3; ++axis) *vertices++ = static_cast<float>(p[axis]);
    }
    for (const glm::uvec3& t : mesh.triangles)
      for (int corner = 0; corner < 3; ++corner) *indices++ = t[corner];
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene.scene, geometry);
    rtcCommitScene(scene.scene);
  }
  rtcReleaseGeometry(geometry);
}

/// Position p of a scene's mesh is this times p in its units.
glm::dmat4 unitsFromMesh(const RayScene& scene) {
  return glm::translate(glm::scale(glm::dmat4(1.0), glm::dvec3(scene.scale)), -scene.centre);
}

/// Adds one instance; nothing for a neighbour that its transform flattens.
void addInstance(Surroundings& around, RTCDevice device, const RayScene& other, const glm::dmat4& hereFromThere) {
  const glm::dmat3 linear(hereFromThere);
  const double determinant = glm::determinant(linear);
  if (!(std::abs(determinant) > 0.0) || !std::isfinite(determinant)) return;
  const glm::mat4 transform(hereFromThere);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, other.scene);
  rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &transform[0][0]);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(around.scene, geometry);  // numbered from 0 in this order
  rtcReleaseGeometry(geometry);
  around.thereFromHere.push_back(glm::mat3(glm::inverse(linear)));
}

}  // namespace

void RaySceneRelease::operator()(RayScene* scene) const {
  if (scene->scene != nullptr) rtcReleaseScene(scene->scene);
  if (scene->device != nullptr) rtcReleaseDevice(scene->device);
  delete scene;
}

void SurroundingsRelease::operator()(Surroundings* around) const {
  if (around->scene != nullptr) rtcReleaseScene(around->scene);
  delete around;
}

Result<RayScenePointer> makeRayScene(const Mesh& mesh, const RayScene* family) {
  const Box box = bounds(mesh);
  if (!(diagonal(box) > 0.0)) return Error{"", "", "mesh has no extent"};
  RayScenePointer scene(new RayScene);
  scene->centre = centre(box);
  scene->scale = 1.0 / diagonal(box);
  scene->device = family != nullptr ? family->device : rtcNewDevice(nullptr);
  if (scene->device == nullptr) return Error{"", "", "Embree does not start"};
  if (family != nullptr) rtcRetainDevice(scene->device);
  // Without RTC_SCENE_FLAG_ROBUST, a third faster; traceVisibility looks after rays that pass between two triangles.
  scene->scene = rtcNewScene(scene->device);
  addGeometry(*scene, mesh);
  if (rtcGetDeviceError(scene->device) == RTC_ERROR_NONE) return scene;
  return Error{"", "", "Embree cannot hold the mesh"};
}

Result<SurroundingsPointer> surround(const RayScene& scene, std::span<const Neighbour> neighbours) {
  SurroundingsPointer around(new Surroundings);
  around->scene = rtcNewScene(scene.device);
  for (const Neighbour& neighbour : neighbours)
    addInstance(*around, scene.device, *neighbour.scene,
                unitsFromMesh(scene) * neighbour.hereFromThere * glm::inverse(unitsFromMesh(*neighbour.scene)));
  rtcCommitScene(around->scene);
  if (rtcGetDeviceError(scene.device) != RTC_ERROR_NONE) return Error{"", "", "Embree cannot hold the scene"};
  return around;
}

}  // namespace overcast
