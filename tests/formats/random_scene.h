// Random scenes that keep every invariant of formats/scene.h and hold only what survives on disk bit for bit: positions and keys that
// are single floats, normals of unit length, every mesh shown by a node.
#pragma once

#include <cstdint>

#include "formats/scene.h"

namespace overcast::test {

Scene randomScene(std::uint64_t seed);
Occluder randomOccluder(std::uint64_t seed);
ApertureLink randomApertureLink(std::uint64_t seed);
ApertureBake randomApertureBake(std::uint64_t seed);
Lighting randomLighting(std::uint64_t seed);

}  // namespace overcast::test
