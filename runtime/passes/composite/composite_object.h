// From a placed local volume to the record the composite's shaders read.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "runtime/atlas.h"
#include "runtime/passes/composite/composite.h"
#include "runtime/passes/composite/global_grid.h"

namespace overcast {

/// Singular values in descending order, by one-sided Jacobi rotations in double: also the small ones to full relative precision.
/// Any finite matrix, singular ones too.
glm::dvec3 singularValues(const glm::dmat3& matrix);

/// The record of a volume placed by `worldFromLocal` (affine). Distances are scaled by the smallest singular value: exact for rigid and
/// uniform transforms, a lower bound of |phi| otherwise (DESIGN 5.1). Gaps beyond the box are exact when the transform keeps the box's
/// axes orthogonal (any translation, rotation and scale of one node), else scaled by the same value.
/// A transform that is not finite, or singular, or so extreme that single floats cannot follow it, gives a record with present = 0.
shared::CompositeObject compositeObject(const AtlasEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid);

}  // namespace overcast
