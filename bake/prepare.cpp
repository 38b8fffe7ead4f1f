#include "bake/prepare.h"

#include <glm/common.hpp>

#include "bake/outside.h"

namespace overcast {

PreparedMesh prepare(const Mesh& mesh) {
  const Box box = bounds(mesh);
  PreparedMesh prepared;
  prepared.middle = centre(box);
  Mesh centred;
  centred.name = mesh.name;
  centred.triangles = mesh.triangles;
  centred.positions.reserve(mesh.positions.size());
  // Vertices that no triangle uses may lie anywhere: they must not reach the lattice of the sign.
  for (const glm::dvec3& p : mesh.positions) centred.positions.push_back(glm::clamp(p, box.min, box.max) - prepared.middle);
  prepared.repaired = repair(centred);
  orientByOutside(prepared.repaired);
  return prepared;
}

}  // namespace overcast
