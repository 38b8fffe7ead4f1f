#include "formats/terrain_levels.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace overcast {
namespace {

bool isWhole(const LevelGroup& group) {
  const bool finite = std::isfinite(group.centre.x) && std::isfinite(group.centre.y) && std::isfinite(group.centre.z);
  return finite && std::isfinite(group.radius) && group.radius >= 0.0f && std::isfinite(group.error) && group.error >= 0.0f;
}

}  // namespace

std::string brokenLevels(const MeshLevels& levels, std::size_t vertices, std::size_t triangles) {
  if (levels.groups.empty() || levels.triangles.empty()) return "has levels without groups or triangles";
  for (const LevelGroup& group : levels.groups)
    if (!isWhole(group)) return "has a group of levels that is out of range";
  for (const glm::uvec3& t : levels.triangles)
    if (std::max({t.x, t.y, t.z}) >= vertices) return "has levels with an index out of range";
  std::size_t next = 0, finest = 0;
  for (const LevelCluster& cluster : levels.clusters) {
    if (cluster.firstTriangle != next) return "has clusters that do not follow each other";
    next += cluster.triangleCount;
    if (cluster.own == kNoLevelGroup) finest += cluster.triangleCount;
    if ((cluster.own == kNoLevelGroup) != (next <= triangles)) return "has clusters across the end of its finest triangles";
    for (const std::uint32_t group : {cluster.own, cluster.coarser})
      if (group != kNoLevelGroup && group >= levels.groups.size()) return "has a cluster of an unknown group";
    if (cluster.own == kNoLevelGroup || cluster.coarser == kNoLevelGroup) continue;
    const LevelGroup &own = levels.groups[cluster.own], &coarser = levels.groups[cluster.coarser];
    if (own.error > coarser.error) return "has a group whose error is below that of its halves";
  }
  if (next != triangles + levels.triangles.size() || finest != triangles) return "has levels that do not cover its triangles";
  return "";
}

}  // namespace overcast
