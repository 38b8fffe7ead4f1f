#include "runtime/passes/shade/estimator_inputs.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include <fmt/format.h>

namespace overcast {

using shared::SkyConstants;

static_assert(sizeof(shared::SkyTap) == 16 && offsetof(shared::SkyTap, level) == 8);
static_assert(offsetof(SkyConstants, taps) == 16 && offsetof(SkyConstants, directions) == 144);
static_assert(sizeof(shared::SkyStep) == 80 && offsetof(shared::SkyStep, shape) == 64 && offsetof(SkyConstants, steps) == 1168);

Shader estimatorShader(std::string file, const SkyEstimator& estimator) {
  Shader shader{std::move(file), {{"OVERCAST_TAPS", fmt::format("{}", estimator.taps.size())}}};
  if (!estimator.directions.empty()) shader.defines.push_back({"OVERCAST_CONES", fmt::format("{}", estimator.directions.size())});
  if (!estimator.steps.empty()) shader.defines.push_back({"OVERCAST_STEPS", fmt::format("{}", estimator.steps.size())});
  if (takesTurns(estimator)) shader.defines.push_back({"OVERCAST_TURNS", "1"});
  if (estimator.traced > 0) shader.defines.push_back({"OVERCAST_TRACED", fmt::format("{}", estimator.traced)});
  return shader;
}

std::vector<Binding> estimatorBindings() {
  std::vector<Binding> bindings;
  for (std::uint32_t binding = kFirstEstimatorBinding; binding < kLastEstimatorBinding; ++binding)
    bindings.push_back({binding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  bindings.push_back({kLastEstimatorBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  return bindings;
}

Result<GpuBuffer> makeEstimatorConstants(const Device& device, const SkyEstimator& estimator) {
  SkyConstants constants{};
  constants.cone = glm::vec4(estimator.cone, 0.0f);
  std::copy(estimator.taps.begin(), estimator.taps.end(), constants.taps);
  std::copy(estimator.steps.begin(), estimator.steps.end(), constants.steps);
  for (std::size_t i = 0; i < estimator.directions.size(); ++i) constants.directions[i] = glm::vec4(estimator.directions[i], 0.0f);
  return makeBufferWith(device, std::as_bytes(std::span(&constants, 1)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
}

void writeLevels(const Device& device, const DescriptorSet& set, std::uint32_t first, const PyramidPass& pyramid) {
  for (std::uint32_t level = 0; level < shared::kMaxPyramidLevels; ++level)
    writeSampledImage(device, set, first + level, pyramid.views[std::min<std::size_t>(level, pyramid.views.size() - 1)], pyramid.sampler,
                      VK_IMAGE_LAYOUT_GENERAL);
}

void writeEstimator(const Device& device, const DescriptorSet& set, const PyramidPass& pyramid, const GpuBuffer& constants) {
  writeLevels(device, set, kFirstEstimatorBinding, pyramid);
  writeBuffer(device, set, kLastEstimatorBinding, constants);
}

}  // namespace overcast
