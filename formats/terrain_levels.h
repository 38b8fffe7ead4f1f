// Levels of detail of a terrain's mesh: clusters of triangles over the same vertices, some of which together show the whole mesh more
// coarsely, with the error that this makes.
//
// Clusters are the patches of a tree of right triangles, each halved into two (Cignoni et al. 2003, "BDAM", section 3; the rule below is
// that of Lindstrom and Pascucci 2002, "Terrain Simplification Simplified", for patches). The two clusters on both sides of the edge that
// would be halved form a group and are refined together, so that whatever rule 1 picks meets without cracks.
//
// Rule 1: with any function f of groups that is never larger for a group than for the group it is refined from, the clusters with
// f(own) <= t < f(coarser) show the mesh once, for any t >= 0. f of the finest clusters' own is 0, f of the roots' coarser is infinite.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace overcast {

/// No group: of finest clusters as `own`, of roots as `coarser`.
inline constexpr std::uint32_t kNoLevelGroup = std::numeric_limits<std::uint32_t>::max();

/// One or two clusters that are refined together. Ball and error hold those of all groups they are refined into.
struct LevelGroup {
  glm::vec3 centre{0.0f};  ///< of a ball around the clusters, mesh space
  float radius = 0.0f;
  float error =
      0.0f;  ///< largest distance between the surface that is shown and the finest one, straight up and down where both have heights
};

struct LevelCluster {
  std::uint32_t firstTriangle = 0;  ///< Mesh::triangles go on in MeshLevels::triangles
  std::uint32_t triangleCount = 0;
  std::uint32_t own = kNoLevelGroup;      ///< what showing this cluster costs
  std::uint32_t coarser = kNoLevelGroup;  ///< what showing the one it is a half of would cost
};

struct MeshLevels {
  std::vector<LevelGroup> groups;
  std::vector<LevelCluster> clusters;  ///< the finest first: they are Mesh::triangles, in order
  std::vector<glm::uvec3> triangles;   ///< of the others, over Mesh::positions
};

/// What is wrong with the levels of a mesh of so many vertices and triangles; empty when nothing is: something of everything, indices
/// within range, clusters that follow each other, every number finite and not negative, groups that hold what they are refined into.
std::string brokenLevels(const MeshLevels& levels, std::size_t vertices, std::size_t triangles);

}  // namespace overcast
