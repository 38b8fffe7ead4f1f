// Aperture map: visibility baked into a texture over a mesh (DESIGN 4, 5.5; Oat and Sander 2006, section 8.3).
#pragma once

#include <cstdint>

#include "bake/aperture.h"
#include "bake/progress.h"
#include "bake/visibility.h"
#include "formats/aperture_map.h"
#include "formats/mesh.h"
#include "formats/result.h"

namespace overcast {

inline constexpr int kDefaultTexels = 512;
inline constexpr int kFewestTexels = 4;

struct ApertureMapSettings {
  VisibilitySettings visibility;
  int texels = kDefaultTexels;        ///< a side, kFewestTexels .. kLargestApertureMapSide
  bool atlas = false;                 ///< texture coordinates of our own (bake/chart_atlas.h) in place of the mesh's
  std::uint64_t errorSamples = 4096;  ///< points of the surface at which the interpolated result is measured; 0: not measured
  std::uint64_t seed = 1;             ///< of these points
};

/// What was found and made.
struct ApertureMapReport {
  glm::ivec2 size{0};
  std::uint64_t traced = 0;       ///< texels that stand for a point of the surface
  std::uint64_t covered = 0;      ///< texels that triangles touch
  std::uint64_t overlapping = 0;  ///< of these, texels that two places on the surface claim: few, or there is no map
  std::uint64_t charts = 0;
  std::uint64_t interior = 0;  ///< texels in a solid, filled from those around them
  std::uint64_t shut = 0;      ///< texels that see nothing: normal and radius 0
  std::uint64_t rays = 0;      ///< traced in all
  double seconds = 0.0;
  std::uint64_t bytes = 0;    ///< of the file
  int levels = 0;             ///< of use
  std::uint64_t samples = 0;  ///< points of the measurement that lie outside of solids
  InterpolationError error;   ///< of what is stored, at its finest level
};

struct BakedApertureMap {
  ApertureMap map;  ///< as stored
  ApertureMapReport report;
};

/// Readies `mesh` for a map: gives it texture coordinates of our own where settings ask for them. Of others those that leave [0, 1] (tiles,
/// or charts beside it) are moved and, if they have to be, shrunk into it. An Error without a file when it has none, its charts overlap on
/// more than kMostOverlap of the texels that triangles touch (each says that --atlas helps), or an atlas of that size cannot hold its
/// triangles.
Result<Done> layOut(Mesh& mesh, const ApertureMapSettings& settings);
inline constexpr double kMostOverlap = 0.001;

/// Bakes what `mesh`, as layOut leaves it and with unit normals, sees past `occluders`, of which it is one. Every texel that bilinear
/// sampling reads looks from the nearest point of its chart (bake/chart_raster.h), on the smooth surface that the normals suggest
/// (surfacePoint), pulled kVertexPull of the diagonal away from the edges of its triangle. Texels in solids and all texels between charts
/// are filled from those around them, ring by ring. When `progress` stops the job, the result is of no use.
BakedApertureMap bakeApertureMap(const Mesh& mesh, const Occluders& occluders, const ApertureMapSettings& settings,
                                 const Progress& progress = {});

/// The same for a mesh by itself, all steps; `mesh` becomes what carries the map. Errors as layOut, or it has no extent, or there is no
/// memory.
Result<BakedApertureMap> bakeApertureMap(Mesh& mesh, const ApertureMapSettings& settings, const Progress& progress = {});

}  // namespace overcast
