// Kernel: the point from which a mesh is seen best, for `radius` (DESIGN 5.1 no. 4).
#pragma once

#include "formats/mesh.h"

namespace overcast {

/// The Chebyshev centre of the intersection of the half-spaces behind the faces, and what it is worth.
struct Kernel {
  glm::dvec3 centre{0.0};
  double margin = 0.0;  ///< smallest distance of the centre behind a face's plane, local units; positive: the mesh is star-shaped about it,
                        ///< negative: the largest violation is the least there is
  int steps = 0;        ///< exchanges of the linear programme
};

/// Maximises the margin m over centres c subject to n_i . c + m <= n_i . p_i for every face: a linear programme in four unknowns, solved by
/// exchange (dual simplex: the most violated face enters the four that hold the point) in double. Faces without area (lower than 1e-10 of
/// their edges) count for nothing. Depends neither on the order of faces beyond rounding nor on threads; 100,000 faces take a few
/// milliseconds. `mesh` has at least one triangle and is oriented outward (bake/repair.h). The centre of an open mesh may be far outside:
/// at most a diagonal from its box.
Kernel findKernel(const Mesh& mesh);

/// Smallest distance of `point` behind a face's plane (negative: in front of one), as findKernel measures it.
double starMargin(const Mesh& mesh, const glm::dvec3& point);

}  // namespace overcast
