// Peer for rays: Embree's own stream call, for the bench to compare with.
#pragma once

#include <memory>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast::bench {

/// A ray in the space of the mesh.
struct PeerRay {
  glm::dvec3 start;
  glm::dvec3 direction;
};

struct StreamPeer;
struct StreamPeerRelease {
  void operator()(StreamPeer* peer) const;
};
using StreamPeerPointer = std::unique_ptr<StreamPeer, StreamPeerRelease>;

/// Embree's tree over the mesh, recentred and scaled to a diagonal of 1; `watertight`: with RTC_SCENE_FLAG_ROBUST.
StreamPeerPointer makeStreamPeer(const Mesh& mesh, bool watertight);

/// What one call of rtcOccluded1M over all rays found and took; laying out the rays is not in the time.
struct StreamResult {
  std::size_t hits = 0;
  double cpuSeconds = 0.0;
};
StreamResult streamRays(const StreamPeer& peer, const std::vector<PeerRay>& rays);

}  // namespace overcast::bench
