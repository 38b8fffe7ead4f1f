// Prepare: a mesh as distance and sign want it.
#pragma once

#include <glm/vec3.hpp>

#include "bake/repair.h"
#include "formats/mesh.h"

namespace overcast {

/// A repaired mesh whose box is centred at the origin; `middle` takes it back to where it was.
struct PreparedMesh {
  RepairedMesh repaired;
  glm::dvec3 middle{0.0};
};

/// Recentres in double, so that neither place nor scale of a mesh changes a result, then repairs (bake/repair.h) and, where the orientation
/// decides nothing, turns pieces outward (bake/outside.h). `mesh` has a triangle and finite positions.
PreparedMesh prepare(const Mesh& mesh);

}  // namespace overcast
