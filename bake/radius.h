// `radius`: bakes a mesh into its radius over directions about a searched centre (DESIGN 5.1 no. 4; Evans 2006, section 9.8).
#pragma once

#include "bake/progress.h"
#include "formats/mesh.h"
#include "formats/radius.h"
#include "formats/result.h"

namespace overcast {

/// A centre and how well the mesh is seen from it.
struct StarCentre {
  glm::dvec3 centre{0.0};
  double margin = 0.0;   ///< starMargin (bake/kernel.h), local units; positive: star-shaped
  double visible = 0.0;  ///< share of the area that faces away from the centre; 1 when star-shaped
};

/// The best centre found: the kernel's Chebyshev centre where there is a kernel; else of it, the volume's and the area's centroid and the
/// middle of the box the one with the largest visible share. `mesh` is oriented outward and has at least one triangle.
StarCentre starCentre(const Mesh& mesh);

/// Rays along one side of a texel of the finest level.
inline constexpr int kRadiusRays = 4;

struct RadiusSettings {
  int side = 32;  ///< texels along a face of the finest level: a power of two, kSmallestRadiusSide .. kLargestRadiusSide
};

/// Repairs the mesh, searches the centre, casts kRadiusRays^2 rays per texel and filters them into all levels. Where a ray crosses the
/// surface more than once the outermost crossing counts. Levels are filtered over the whole cube, across edges and corners, weighted by
/// solid angle. The field comes as stored (asStored). Same bytes for any thread count. An Error when a setting is out of range, the mesh
/// has no triangle, no extent or values out of range, rays pass it by (it does not enclose the centre), the centre is too close to its
/// surface, or `progress` asked to stop ("interrupted").
Result<RadiusField> bakeRadius(const Mesh& mesh, const RadiusSettings& settings, const Progress& progress = {});

}  // namespace overcast
