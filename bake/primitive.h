// `primitive`: the cuboid or the ellipsoid that is nearest to a mesh (DESIGN 5.1 no. 1).
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "bake/progress.h"
#include "formats/mesh.h"
#include "formats/primitive.h"
#include "formats/result.h"

namespace overcast {

/// What the fits of all shapes to one mesh have in common. Lengths in diagonals about the middle of the mesh's box.
struct PrimitiveTarget {
  Box box;                         ///< of the mesh, local space
  std::vector<glm::dvec3> points;  ///< every second on the surface, the others within a twentieth of the diagonal of one
  std::vector<double> distance;    ///< there, signed by the winding number
  std::vector<Primitive> around;   ///< cuboids to start from: along the box of least volume, the axes of inertia, the coordinate axes
};

/// An Error when the mesh has no triangle with an area, or is out of range. The triangles' order and thread count do not matter.
Result<PrimitiveTarget> primitiveTarget(const Mesh& mesh);

/// The primitive of this shape whose distance differs least from the mesh's, in the mean square over points on the surface and within a
/// twentieth of the diagonal of it. Starts from the axes of the box of least volume (bake/oriented_box.h), from those of inertia and from
/// the coordinate axes, and refines centre, rotation and half extents from each by Levenberg and Marquardt's method against exact
/// distances, signed by the winding number; the best goes on. A mesh that is a cuboid comes back to about 1e-9 of its diagonal, a finely
/// tessellated ellipsoid to within its tessellation. An Error when nothing that fits is in range, or `progress` asked to stop
/// ("interrupted").
Result<Primitive> fitPrimitive(const PrimitiveTarget& target, PrimitiveShape shape, const Progress& progress = {});

/// Both in one.
Result<Primitive> bakePrimitive(const Mesh& mesh, PrimitiveShape shape, const Progress& progress = {});

}  // namespace overcast
