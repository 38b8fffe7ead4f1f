// Chart raster: which point of a surface every texel of a texture over it stands for (DESIGN 5.5, per texel).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

#include "bake/aperture.h"
#include "formats/mesh.h"

namespace overcast {

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;

/// The point of the surface that a texel stands for, clamped into its chart.
struct TexelSite {
  SurfaceSample at{kNoTriangle, {1.0, 0.0, 0.0}};  ///< triangle kNoTriangle: no point of the surface reads this texel
  float coverage = 0.0f;                           ///< share of the texel that triangles cover, [0, 1]
};

struct ChartRaster {
  glm::ivec2 size{0};
  std::vector<TexelSite> sites;      ///< [i + size.x * j], row 0 at v = 0
  std::vector<std::uint32_t> chart;  ///< of each triangle: triangles whose edges meet both in space and in the texture are one chart
  std::uint32_t charts = 0;
  std::uint64_t covered = 0;      ///< texels that triangles touch
  std::uint64_t overlapping = 0;  ///< of these, texels of which two places on the surface claim the same part
};

/// Lays the texture coordinates of `mesh` over a texture. Every texel that bilinear sampling reads for some point of a triangle, those
/// around the ones a triangle touches, gets the nearest point of the nearest triangle (the first of equally near ones): conservative
/// coverage with positions clamped into the chart. Overlap is looked for at kOverlapSamples^2 points of each texel; triangles that lie in
/// the same place and face the same way do not count, nor do those that share an edge in the texture. `mesh` has texture coordinates. The
/// same result for any number of threads.
ChartRaster rasteriseCharts(const Mesh& mesh, const glm::ivec2& size);
inline constexpr int kOverlapSamples = 4;

/// How many levels of a map, from the finest, are of use: in those at most kMostMixed of the texels on the surface lie on more than one
/// chart.
int usableLevels(const ChartRaster& raster);
inline constexpr double kMostMixed = 0.05;

}  // namespace overcast
