// Brute-force composite in double: what the global volume should hold (DESIGN 5.1, 5.2). Shares no code with the runtime.
#pragma once

#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/volume.h"

namespace overcast::reference {

/// Smallest singular value of a 3x3 matrix: the square root of the smallest eigenvalue of its Gram matrix, by bisection of the
/// characteristic polynomial's sign changes (Sturm sequence) in long double. 0 for singular matrices.
double smallestSingularValue(const glm::dmat3& matrix);

/// A local volume placed in the world, and what follows from its transform.
struct PlacedVolume {
  const Volume* volume = nullptr;
  glm::dmat4 worldFromLocal{1.0};
  glm::dmat4 localFromWorld{1.0};
  double sigmaMin = 1.0;
  bool keepsCuboids = true;  ///< the transform leaves the box's axes orthogonal
};

/// `volume` must outlive the result; the transform is regular.
PlacedVolume place(const Volume& volume, const glm::dmat4& worldFromLocal);

/// Distance of one object at a world-space point by DESIGN 5.1 (trilinear inside the box of samples; beyond it, with q the closest point of
/// the box in the object's own axes, the gap |p - q| measured in the world when the box stays a cuboid, else in local space, and everything
/// local times the smallest singular value; where phi(q) >= 0 the closest surface point is taken to lie phi(q) from q at the angle whose
/// cosine is phi's slope towards p, a difference over one sample inwards, clamped to 0 .. 1), metres.
double objectDistance(const PlacedVolume& object, const glm::dvec3& point);

/// Minimum over objects; `farAway` without any.
double compositeDistance(const std::vector<PlacedVolume>& objects, const glm::dvec3& point, double farAway);

}  // namespace overcast::reference
