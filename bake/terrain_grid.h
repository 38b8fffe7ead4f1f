// Terrain grid: heights by integer places, and the tree of right triangles over them. Internal to the terrain mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "formats/terrain.h"

namespace overcast {

/// A right triangle over places of the grid, its right angle last, clockwise as rows run south (counter-clockwise from above). Places
/// beyond the last column or row stand for the last one, so that a tree over powers of two fits any grid: what lies beyond is flat.
struct GridTriangle {
  std::array<glm::ivec2, 3> corner;
};

inline glm::ivec2 splitPlace(const GridTriangle& t) {
  return (t.corner[0] + t.corner[1]) / 2;
}

inline std::array<GridTriangle, 2> halves(const GridTriangle& t) {
  const glm::ivec2 mid = splitPlace(t);
  return {GridTriangle{{t.corner[2], t.corner[0], mid}}, GridTriangle{{t.corner[1], t.corner[2], mid}}};
}

/// Calls visit for the parts of a triangle halved `times` times, in order.
template <class Visit>
void forParts(const GridTriangle& t, int times, const Visit& visit) {
  if (times == 0) {
    visit(t);
    return;
  }
  for (const GridTriangle& half : halves(t)) forParts(half, times - 1, visit);
}

/// Heights by place.
struct TerrainGrid {
  const Terrain& terrain;

  glm::ivec2 last() const { return {terrain.columns - 1, terrain.rows - 1}; }
  glm::ivec2 clamped(const glm::ivec2& place) const { return {std::min(place.x, last().x), std::min(place.y, last().y)}; }
  std::size_t index(const glm::ivec2& place) const {
    return static_cast<std::size_t>(place.y) * static_cast<std::size_t>(terrain.columns) + static_cast<std::size_t>(place.x);
  }
  double height(const glm::ivec2& place) const { return double{terrain.heights[index(place)]}; }
  bool has(const glm::ivec2& place) const { return !std::isnan(terrain.heights[index(place)]); }
};

/// Both halves of squares of 2^power cells that cover the grid, row by row.
std::vector<GridTriangle> rootTriangles(const TerrainGrid& grid, int power);

/// The triangle with its corners within the grid; false when nothing is left of it.
bool withinGrid(const TerrainGrid& grid, const GridTriangle& t, GridTriangle& within);

/// How far the plane over `t` (within the grid) lies from the finest surface there; metres. Where a height is missing the size of the
/// triangle, where all are 0. `nested`: no corner was moved, so that `t` is made of finest triangles.
double deviation(const TerrainGrid& grid, const GridTriangle& t, bool nested);

}  // namespace overcast
