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

/// Appends them to `readings`: the taps in voxels, along the skewed normal or cone after cone; of `calibrated`, for each place of the wide
/// pattern, what the taps miss and then what the gaps between them do. Not for traced cones, which choose where they read.
void readTaps(const SkyField& field, const SkyEstimator& estimator, const glm::vec3& up, const SurfacePoint& point,
              std::vector<float>& readings);

/// Sky visibility of a surface from these readings, as shade.comp.glsl makes it; of `calibrated`, the mean
/// over the pattern.
float visibilityOf(const SkyEstimator& estimator, std::span<const float> readings);

}  // namespace overcast
