// Terrain mesh: a grid of heights becomes triangles with levels of detail.
#pragma once

#include <string>
#include <vector>

#include "formats/mesh.h"
#include "formats/scene.h"
#include "formats/terrain.h"

namespace overcast {

/// Gives heights to what has none inside the terrain (no way of empty samples, by side, leads from there to the border): the smooth surface
/// over the gap whose every height is the mean of its neighbours. Gaps that reach the border stay. Returns how many were filled.
std::uint64_t fillGaps(Terrain& terrain);

/// The mesh of a whole terrain: a vertex for every height that a triangle uses, row by row; x to the east and z to the south from the
/// middle of the grid, y up from the lowest height, metres; normals of the triangles around, weighted by area; texture coordinates at the
/// middle of its texel in a picture of a texel for each height. Triangles: two for each cell, cut along diagonals that alternate, without
/// those that lack a height; counter-clockwise from above; in the order of their clusters (Mesh::levels, formats/terrain_levels.h). One
/// part without material.
///
/// A cluster has at most kClusterTriangles triangles. An error is the largest difference of heights between a cluster and the finest
/// triangles under it, exact up to rounding; at the outline of what has heights, where one of them is missing, it is at least the size of
/// the triangle. Same bytes for any thread count. An Error when no triangle has its three heights.
Result<Mesh> terrainMesh(const Terrain& terrain);

inline constexpr std::uint32_t kClusterTriangles = 1024;

/// Both in one, as a scene of one node (formats/scene.h, sceneFromMesh); its notes say what was assumed, filled and left out.
Result<Scene> sceneFromTerrain(Terrain terrain, const std::string& name);

}  // namespace overcast
