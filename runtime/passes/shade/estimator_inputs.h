// EstimatorInputs: what every shader that includes sky_visibility.glsl is made with and reads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/passes/pyramid/pyramid_pass.h"
#include "runtime/passes/shade/sky_estimator.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/pipeline.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// Bindings of sky_visibility.glsl; a shader's own come before or after.
inline constexpr std::uint32_t kFirstEstimatorBinding = 4, kLastEstimatorBinding = kFirstEstimatorBinding + shared::kMaxPyramidLevels;

/// The shader in `file` with the estimator compiled in.
Shader estimatorShader(std::string file, const SkyEstimator& estimator);
std::vector<Binding> estimatorBindings();

/// A shared::SkyConstants.
Result<GpuBuffer> makeEstimatorConstants(const Device& device, const SkyEstimator& estimator);

/// Writes the levels of a pyramid, and repeats the last, to shared::kMaxPyramidLevels bindings from `first` on.
void writeLevels(const Device& device, const DescriptorSet& set, std::uint32_t first, const PyramidPass& pyramid);

/// Writes all of estimatorBindings(). The pyramid has at least SkyEstimator::levels levels; it and `constants` must outlive the set.
void writeEstimator(const Device& device, const DescriptorSet& set, const PyramidPass& pyramid, const GpuBuffer& constants);

}  // namespace overcast
