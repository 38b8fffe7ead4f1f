// Affine matrices as translation, rotation and scale, the only form that glTF allows (2.0, 3.5.3). Internal to formats.
#pragma once

#include <optional>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>

namespace overcast {

/// translation * rotation * scale * inner: `inner` is there only when the matrix shears, which no single glTF node can say.
struct Trs {
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};  ///< unit
  glm::dvec3 scale{1.0};                    ///< at most one is negative: x, when the matrix mirrors
  std::optional<glm::dquat> inner;          ///< unit
};

/// The parts of an affine matrix, by one-sided Jacobi rotations (Hestenes 1958). Columns that are orthogonal to a millionth of their
/// lengths, the rounding of single floats, count as free of shear. Singular matrices are fine.
Trs decompose(const glm::dmat4& matrix);

/// True when the Khronos validator accepts the matrix as it is: free of shear, not singular, equal to its parts to a millionth, and scaling
/// by at most 100 (it calculates in single floats with an absolute tolerance and refuses most matrices, exact ones too, beyond that).
bool isPlainTrs(const glm::dmat4& matrix, const Trs& parts);

}  // namespace overcast
