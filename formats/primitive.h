// `primitive`: an oriented cuboid or ellipsoid with its exact distance (DESIGN 5.1 no. 1). Its numbers are in the JSON extension.
#pragma once

#include <cstdint>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>

#include "formats/mesh.h"

namespace overcast {

enum class PrimitiveShape { cuboid, ellipsoid };

/// The points centre + rotation * (halfExtents * u) with u in [-1, 1]^3 (cuboid) or |u| <= 1 (ellipsoid), local space.
struct Primitive {
  PrimitiveShape shape = PrimitiveShape::cuboid;
  glm::dvec3 centre{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};  ///< w, x, y, z; unit
  glm::dvec3 halfExtents{0.5};              ///< along the primitive's own axes, local units
};

/// What a primitive may be, so that single floats can follow it: half extents within kSmallestHalfExtent .. kLargestHalfExtent, the
/// smallest at least kThinnestPrimitive of the largest; the centre no further than kLargestHalfExtent along any axis.
inline constexpr double kSmallestHalfExtent = 1e-30;
inline constexpr double kLargestHalfExtent = 1e30;
inline constexpr double kThinnestPrimitive = 1e-6;
inline constexpr std::uint64_t kPrimitiveBytes = 80;  ///< what a primitive costs: its ten numbers as doubles

/// "cuboid" or "ellipsoid".
const char* name(PrimitiveShape shape);

/// Within the limits above, rotation of unit length to 1e-9.
bool isWhole(const Primitive& primitive);

/// The smallest axis-aligned box around it.
Box bounds(const Primitive& primitive);

/// Exact signed distance at `point` (local space, finite) to rounding: the cuboid in closed form; the ellipsoid by the root of the secular
/// equation of its closest point (Eberly, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid", section 4, with a
/// Newton iteration that converges monotonically). Its Lipschitz constant is 1.
double samplePrimitive(const Primitive& primitive, const glm::dvec3& point);

double lipschitzBound(const Primitive& primitive);  ///< 1

}  // namespace overcast
