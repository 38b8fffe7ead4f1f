#include "runtime/passes/shade/shade_pass.h"

#include <algorithm>
#include <cstddef>
#include <span>

#include <fmt/format.h>

namespace overcast {

using shared::SkyConstants;

static_assert(sizeof(shared::SkyTap) == 16 && offsetof(shared::SkyTap, level) == 8);
static_assert(offsetof(SkyConstants, taps) == 16 && offsetof(SkyConstants, directions) == 144);
static_assert(sizeof(shared::SkyStep) == 48 && offsetof(SkyConstants, steps) == 1168);
static_assert(sizeof(shared::ShadePush) == 96 && offsetof(shared::ShadePush, skew) == 64 && offsetof(shared::ShadePush, sky) == 80);

namespace {

constexpr std::uint32_t kConstantsBinding = kFirstScreenBinding + shared::kMaxPyramidLevels, kSkyBinding = kConstantsBinding + 1;

Shader shaderOf(const SkyEstimator& estimator, bool sky) {
  Shader shader{"runtime/passes/shade/shade.comp.glsl", {{"OVERCAST_TAPS", fmt::format("{}", estimator.taps.size())}}};
  if (!estimator.directions.empty()) shader.defines.push_back({"OVERCAST_CONES", fmt::format("{}", estimator.directions.size())});
  if (!estimator.steps.empty()) shader.defines.push_back({"OVERCAST_STEPS", fmt::format("{}", estimator.steps.size())});
  if (estimator.traced > 0) shader.defines.push_back({"OVERCAST_TRACED", fmt::format("{}", estimator.traced)});
  if (sky) shader.defines.push_back({"OVERCAST_SKY", fmt::format("{}", kSkyBinding)});
  return shader;
}

std::vector<Binding> bindingsOf(bool sky) {
  std::vector<Binding> bindings;
  for (std::uint32_t level = 0; level < shared::kMaxPyramidLevels; ++level)
    bindings.push_back({kFirstScreenBinding + level, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  bindings.push_back({kConstantsBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  if (sky) bindings.push_back({kSkyBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  return bindings;
}

SkyConstants constantsOf(const SkyEstimator& estimator) {
  SkyConstants constants{};
  constants.cone = glm::vec4(estimator.cone, 0.0f);
  std::copy(estimator.taps.begin(), estimator.taps.end(), constants.taps);
  std::copy(estimator.steps.begin(), estimator.steps.end(), constants.steps);
  for (std::size_t i = 0; i < estimator.directions.size(); ++i) constants.directions[i] = glm::vec4(estimator.directions[i], 0.0f);
  return constants;
}

}  // namespace

Result<ShadePass> makeShadePass(const Device& device, const GeometryImages& images, const GpuImage& light, const PyramidPass& pyramid,
                                const SkyEstimator& estimator, const GpuBuffer* sky) {
  OVERCAST_REQUIRE(static_cast<int>(pyramid.views.size()) >= estimator.levels, "{} levels for {}", pyramid.views.size(), estimator.levels);
  Result<ScreenPass> screen =
      makeScreenPass(device, images, light, shaderOf(estimator, sky != nullptr), bindingsOf(sky != nullptr), sizeof(shared::ShadePush));
  if (!screen) return screen.error();
  ShadePass pass{std::move(screen).value(), estimator, {}};
  const SkyConstants constants = constantsOf(estimator);
  const Result<GpuBuffer> buffer = makeBufferWith(device, std::as_bytes(std::span(&constants, 1)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  if (!buffer) {
    destroyShadePass(device, pass);
    return buffer.error();
  }
  pass.constants = buffer.value();
  for (std::uint32_t level = 0; level < shared::kMaxPyramidLevels; ++level)
    writeSampledImage(device, pass.screen.set, kFirstScreenBinding + level,
                      pyramid.views[std::min<std::size_t>(level, pyramid.views.size() - 1)], pyramid.sampler, VK_IMAGE_LAYOUT_GENERAL);
  writeBuffer(device, pass.screen.set, kConstantsBinding, pass.constants);
  if (sky) writeBuffer(device, pass.screen.set, kSkyBinding, *sky);
  return pass;
}

void destroyShadePass(const Device& device, ShadePass& pass) {
  destroyBuffer(device, pass.constants);
  destroyScreenPass(device, pass.screen);
  pass = {};
}

void recordShade(VkCommandBuffer commands, const ShadePass& pass, const GlobalGrid& grid, const ShadeView& view) {
  shared::ShadePush constants;
  constants.voxelFromClip = voxelFromClip(grid, view.clipFromRelative, view.eye);
  constants.skew = glm::vec4(pass.estimator.skyWeight * view.up, pass.estimator.skyWeight);
  constants.sky = glm::vec4(view.skyColour, 0.0f);
  recordScreenPass(commands, pass.screen, constants);
}

}  // namespace overcast
