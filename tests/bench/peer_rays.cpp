#include "tests/bench/peer_rays.h"

#include <ctime>
#include <limits>

#include <embree3/rtcore.h>

namespace overcast::bench {

struct StreamPeer {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  glm::dvec3 centre{0.0};
  double scale = 1.0;
};

void StreamPeerRelease::operator()(StreamPeer* peer) const {
  rtcReleaseScene(peer->scene);
  rtcReleaseDevice(peer->device);
  delete peer;
}

StreamPeerPointer makeStreamPeer(const Mesh& mesh, bool watertight) {
  StreamPeerPointer peer(new StreamPeer);
  peer->centre = centre(bounds(mesh));
  peer->scale = 1.0 / diagonal(bounds(mesh));
  peer->device = rtcNewDevice(nullptr);
  peer->scene = rtcNewScene(peer->device);
  if (watertight) rtcSetSceneFlags(peer->scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(peer->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<glm::vec3*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), mesh.positions.size()));
  auto* indices = static_cast<glm::uvec3*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) vertices[i] = glm::vec3((mesh.positions[i] - peer->centre) * peer->scale);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) indices[i] = glm::uvec3(mesh.triangles[i]);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(peer->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(peer->scene);
  return peer;
}

StreamResult streamRays(const StreamPeer& peer, const std::vector<PeerRay>& rays) {
  std::vector<RTCRay> stream(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const glm::vec3 start((rays[i].start - peer.centre) * peer.scale), direction(rays[i].direction);
    RTCRay& ray = stream[i];
    ray = {};
    ray.org_x = start.x;
    ray.org_y = start.y;
    ray.org_z = start.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = ~0u;
  }
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  StreamResult result;
  const std::clock_t from = std::clock();
  rtcOccluded1M(peer.scene, &context, stream.data(), static_cast<unsigned>(stream.size()), sizeof(RTCRay));
  result.cpuSeconds = static_cast<double>(std::clock() - from) / CLOCKS_PER_SEC;
  for (const RTCRay& ray : stream) result.hits += ray.tfar < 0.0f;
  return result;
}

}  // namespace overcast::bench
