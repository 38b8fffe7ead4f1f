// SkyReadings: what the shade pass reads of a field at surface points, and what it makes of that, on the CPU.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/reference.h"
#include "runtime/calibrate/sky_field.h"
#include "runtime/passes/shade/sky_estimator.h"

namespace overcast {

/// A point of a reference.
struct SurfacePoint {
  glm::dvec3 position{0.0};            ///< world space
  glm::vec3 normal{0.0f, 1.0f, 0.0f};  ///< unit length
  float sky = 1.0f;                    ///< the truth: sky visibility
  int object = -1;                     ///< index into Scene::nodes
};

/// At most `most` points of a reference that has the channel "sky", spread evenly over its pixels with surfaces or its points.
std::vector<SurfacePoint> surfacePoints(const Reference& reference, std::size_t most);

/// How many values an estimator reads at a point.
std::size_t readingsOf(const SkyEstimator& estimator);

/// Appends them to `phi`: the taps in voxels, along the skewed normal or cone after cone. Not for traced cones, which choose where they
/// read.
void readTaps(const SkyField& field, const SkyEstimator& estimator, const glm::vec3& up, const SurfacePoint& point,
              std::vector<float>& phi);

/// Sky visibility of a surface with the unit vector `normal` from these readings, as shade.comp.glsl makes it.
float visibilityOf(const SkyEstimator& estimator, const glm::vec3& up, const glm::vec3& normal, std::span<const float> phi);

}  // namespace overcast
