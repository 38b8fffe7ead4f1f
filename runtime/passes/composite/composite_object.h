// From a placed local occluder to the record the composite's shaders read.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/mesh.h"
#include "formats/primitive.h"
#include "runtime/atlas.h"
#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/global_grid.h"

namespace overcast {

/// U * Sigma of a singular value decomposition: `matrix` times a rotation that makes the columns orthogonal, by one-sided Jacobi rotations
/// in double, small columns to full relative precision. Columns are in no order. Any finite matrix, singular ones too.
glm::dmat3 orthogonalColumns(const glm::dmat3& matrix);

/// Singular values in descending order, from orthogonalColumns.
glm::dvec3 singularValues(const glm::dmat3& matrix);

/// A record in the making.
struct PlacedObject {
  shared::CompositeObject object{};  ///< all zero, present = 0, when the transform is out of range
  double sigmaMin = 0.0;             ///< smallest singular value of the transform, global voxels per unit
  double rounding = 0.0;             ///< bound of the error of a local point by rounding of coordinates, global voxels
};

/// What the records of all kinds share: rows, axisScale, box and present of an object whose distance is known within `box`, in units of the
/// kind's choice; `worldFromUnits` (affine) places them. Distances are to be scaled by the smallest singular value: exact for rigid and
/// uniform transforms, a lower bound of |phi| otherwise (DESIGN 5.1). Gaps beyond the box are exact when the transform keeps the box's axes
/// orthogonal (any translation, rotation and scale of one node), else scaled by the same value. Nothing is present when the transform is
/// not finite, or singular, or so extreme that single floats cannot follow it.
PlacedObject placeObject(const Box& box, const glm::dmat4& worldFromUnits, const GlobalGrid& grid);

/// The record of a volume placed by `worldFromLocal` (affine).
shared::CompositeObject compositeObject(const AtlasEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid);

/// The record of a primitive placed by `worldFromLocal` (affine). An ellipsoid is exact under any transform, since it stays one; a cuboid
/// wherever it stays one, else scaled by the smallest singular value, a lower bound.
shared::CompositeObject compositeObject(const Primitive& primitive, const glm::dmat4& worldFromLocal, const GlobalGrid& grid);

}  // namespace overcast
