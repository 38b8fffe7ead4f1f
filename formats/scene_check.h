// Whether a Scene keeps the invariants that formats/scene.h and formats/mesh.h promise. Internal to formats.
#pragma once

#include <string>

#include "formats/scene.h"

namespace overcast {

/// Empty when every index is in range, the nodes form trees whose links agree, parts cover the triangles, and numbers are finite;
/// otherwise the first thing that is wrong.
std::string brokenInvariant(const Scene& scene);

}  // namespace overcast
