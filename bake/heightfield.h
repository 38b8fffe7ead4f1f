// `heightfield`: from which side a mesh is a height field, and its heights, by parallel lines in double (formats/heightfield.h).
#pragma once

#include <glm/mat3x3.hpp>

#include "formats/heightfield.h"
#include "formats/mesh.h"

namespace overcast {

/// How a mesh is seen as a height field.
struct HeightView {
  glm::dmat3 localFromField{1.0};  ///< orthonormal, right-handed; the third column is the direction the heights are measured along
  bool pair = false;               ///< two layers back to back
  double seen = 0.0;      ///< share of the surface that is a highest (for a pair: or lowest) point; walls along the axis do not count
  double flatness = 0.0;  ///< projected area over surface area of the front layer
};

/// Share of the surface that must be seen. The rest, hidden under overhangs, is lost.
inline constexpr double kLeastSeen = 0.98;

/// The best side to see the mesh from: of the six axes and the two directions along each eigenvector of the normals' covariance, those from
/// which kLeastSeen of the surface is seen, and of these the flattest; nearly as flat ones (2 %) in the order given, +y first. One side is
/// preferred to a pair and, if the mesh is oriented, the side its triangles face. Within the plane the rectangle is turned to where it is
/// smallest. The same for any order of triangles and any thread count. An Error when the mesh has no triangle, no extent,
/// or no such side; its reason names the best side and share.
Result<HeightView> bestHeightView(const Mesh& mesh);

/// The height field of `mesh` in this view, `resolution` texels along the longer side of its rectangle (a power of two,
/// kMinHeightFieldSide to kMaxHeightFieldSide), the other side the power of two that makes texels squarest. Each texel has mean and
/// variance of 4 x 4 lines. The box is the mesh's, with two texels more below and above. Where no line meets the mesh: a hole of a single
/// layer gets the height of the nearest texel; all else, beyond the outline, falls off from it at 45 degrees (for a pair both layers, from
/// their middle), which keeps the distance between 0.7 and 1 of the true one there. As stored (asStored). An Error when the resolution is
/// not allowed.
Result<HeightField> bakeHeightField(const Mesh& mesh, const HeightView& view, int resolution = 64);

/// Both in one.
Result<HeightField> bakeHeightField(const Mesh& mesh, int resolution = 64);

}  // namespace overcast
