// The sky points pass: what the sky estimator says at points of the global volume, for setting up.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "runtime/passes/pyramid/pyramid_pass.h"
#include "runtime/passes/shade/sky_estimator.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

struct SkyPointsPass {
  Pipeline pipeline;
  DescriptorSet set;
  GpuBuffer constants;
  GpuBuffer points;  ///< shared::SkyPoint, mapped
  GpuBuffer seen;    ///< vec2, mapped
  float skyWeight = 0.0f;
};

/// What a point sees.
struct SkySeen {
  float visibility;  ///< of the sky, by the estimator
  float above;       ///< signed distance in voxels a voxel above the point: negative within something else than what it lies on
};

/// A pass of the estimator over the pyramid, which must outlive it.
Result<SkyPointsPass> makeSkyPointsPass(const Device& device, const PyramidPass& pyramid, const SkyEstimator& estimator);
void destroySkyPointsPass(const Device& device, SkyPointsPass& pass);

/// What each point sees in the pyramid as it is, under a sky whose zenith is `up`. Waits.
Result<std::vector<SkySeen>> seenAt(const Device& device, const SkyPointsPass& pass, std::span<const shared::SkyPoint> points,
                                    const glm::vec3& up);

}  // namespace overcast
