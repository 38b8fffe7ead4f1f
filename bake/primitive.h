// `primitive`: the cuboid or the ellipsoid that is nearest to a mesh (DESIGN 5.1 no. 1).
#pragma once

#include "bake/progress.h"
#include "formats/mesh.h"
#include "formats/primitive.h"
#include "formats/result.h"

namespace overcast {

/// The primitive of this shape whose distance differs least from the mesh's, in the mean square over points on the surface and within a
/// twentieth of the diagonal of it. Starts from the axes of the box of least volume (bake/oriented_box.h), from those of inertia and from
/// the coordinate axes, and refines centre, rotation and half extents from each by Levenberg and Marquardt's method against exact
/// distances, signed by the winding number. A mesh that is a cuboid comes back to about 1e-9 of its diagonal, a finely tessellated
/// ellipsoid to within its tessellation. The triangles' order and thread count do not matter. An Error when the mesh has no triangle with
/// an area, is out of range, or `progress` asked to stop ("interrupted").
Result<Primitive> bakePrimitive(const Mesh& mesh, PrimitiveShape shape, const Progress& progress = {});

}  // namespace overcast
