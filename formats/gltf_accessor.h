// The one way from a glTF accessor to numbers: every range is checked, and nothing else in formats touches a glTF buffer.
// Internal to formats. Runs inside the sandbox.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/result.h"

namespace tinygltf {
class Model;
}

namespace overcast {

/// All elements of an accessor as doubles, `components` per element: count * components numbers. Integers marked `normalized` become
/// [0, 1] or [-1, 1] (glTF 2.0, 3.11); strides, sparse values and accessors without bufferView (zeros) are followed. An Error whose
/// place names the accessor when an index, offset, stride, type, or range is wrong, or its type does not have `components`.
Result<std::vector<double>> readNumbers(const tinygltf::Model& model, int accessor, int components);

/// All elements of a scalar accessor of unsigned integers (vertex indices). Errors as above.
Result<std::vector<std::uint32_t>> readIndices(const tinygltf::Model& model, int accessor);

}  // namespace overcast
