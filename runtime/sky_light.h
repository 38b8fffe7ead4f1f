// Sky light for the device: the harmonics of a sky in the world, and in the axes of an object that turns under it.
#pragma once

#include <glm/mat4x4.hpp>

#include "formats/sky.h"
#include "runtime/passes/aperture/sky.h"

namespace overcast {

shared::SkyLight skyLight(const SkyHarmonics& sky);

/// As an object placed by `worldFromLocal` has it in its own axes: turned against its rotation (and mirrored against its reflection), which
/// is what is nearest to the matrix when its scale is taken off; singular matrices give one such rotation.
shared::SkyLight skyLight(const SkyHarmonics& sky, const glm::dmat4& worldFromLocal);

}  // namespace overcast
