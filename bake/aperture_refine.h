// Aperture refine: more vertices where what is seen bends between those a mesh has, so that apertures at vertices follow contact shadows on
// floors and walls of a few triangles.
#pragma once

#include <cstddef>

#include "bake/progress.h"
#include "bake/visibility.h"
#include "formats/mesh.h"

namespace overcast {

struct RefineSettings {
  std::size_t vertices = 0;  ///< a mesh gets no more than so many, but for those that shut cracks; fewer than it has: it stays as it is
  VisibilitySettings visibility;
};

/// `mesh`, with unit normals, cut by longest-edge bisection (bake/mesh_bisect.h) until ambient visibility nowhere differs by more than
/// kRefineError from what is interpolated between vertices, as far as looking at four points of each triangle tells, or edges are shorter
/// than kRefineEdge of the diagonal, or there are as many vertices as allowed: triangles that err most over the largest area come first.
/// The surface stays what it is. When `progress` stops the job, the result is of no use.
Mesh refined(Mesh mesh, const Occluders& occluders, const RefineSettings& settings, const Progress& progress = {});

inline constexpr int kMostRefinedVertices = 1 << 20;
inline constexpr double kRefineError = 0.03;
inline constexpr double kRefineEdge = 1.0 / 256.0;

}  // namespace overcast
