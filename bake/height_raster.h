// HeightRaster: the highest and lowest point of a mesh along parallel lines in z, exact in double. Private to bake.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast {

/// Lines at origin + step * (i + 0.5, j + 0.5), 0 <= i < size.x, that run along z.
struct LineGrid {
  glm::ivec2 size{0};
  glm::dvec2 origin{0.0};
  glm::dvec2 step{0.0};
};

/// Per line, x fastest: the largest and smallest z of the mesh on it; -infinity and +infinity where the line misses.
struct HeightRaster {
  std::vector<double> top;
  std::vector<double> bottom;
};

/// How much of a mesh its highest and lowest points along z are. Weighs each crossing of a line with the area of surface that it
/// stands for, 1 / |cosine|; surfaces parallel to z weigh nothing: they are the steps of the heights.
struct HeightShares {
  double top = 0.0;       ///< share that is seen from +z
  double either = 0.0;    ///< share that is seen from +z or -z
  double facing = 0.0;    ///< share of what is seen from +z whose front side is
  double flatness = 0.0;  ///< projected area over seen area, at most 1; 0 when no line meets the mesh
};

/// `points` are the mesh's positions in a frame where the lines run along z; triangles without projected area are left out. The outcome
/// does not depend on the order of triangles.
HeightRaster rasterHeights(std::span<const glm::dvec3> points, const std::vector<glm::uvec3>& triangles, const LineGrid& grid);

/// Shares over the lines of `grid`; points within `tolerance` of the highest one count as it.
HeightShares measureShares(std::span<const glm::dvec3> points, const std::vector<glm::uvec3>& triangles, const LineGrid& grid,
                           double tolerance);

}  // namespace overcast
