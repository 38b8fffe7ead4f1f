#include "runtime/passes/shade/shade_pass.h"

#include <cstddef>

#include <fmt/format.h>

#include "runtime/passes/shade/estimator_inputs.h"

namespace overcast {

static_assert(sizeof(shared::ShadePush) == 96 && offsetof(shared::ShadePush, skew) == 64 && offsetof(shared::ShadePush, sky) == 80);

namespace {

static_assert(kFirstEstimatorBinding == kFirstScreenBinding);
constexpr std::uint32_t kSkyBinding = kLastEstimatorBinding + 1, kRestBinding = kSkyBinding + 1;

Shader shaderOf(const SkyEstimator& estimator, bool sky, bool rest) {
  Shader shader = estimatorShader("runtime/passes/shade/shade.comp.glsl", estimator);
  if (sky) shader.defines.push_back({"OVERCAST_SKY", fmt::format("{}", kSkyBinding)});
  if (rest) shader.defines.push_back({"OVERCAST_REST", "1"});
  return shader;
}

std::vector<Binding> bindingsOf(bool sky, bool rest) {
  std::vector<Binding> bindings = estimatorBindings();
  if (sky) bindings.push_back({kSkyBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  for (std::uint32_t binding = kRestBinding; rest && binding <= kRestBinding + shared::kMaxPyramidLevels; ++binding)
    bindings.push_back({binding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  return bindings;
}

}  // namespace

Result<ShadePass> makeShadePass(const Device& device, const GeometryImages& images, const GpuImage& light, const PyramidPass& pyramid,
                                const SkyEstimator& estimator, const GpuBuffer* sky, const PyramidPass* atRest) {
  OVERCAST_REQUIRE(static_cast<int>(pyramid.views.size()) >= estimator.levels, "{} levels for {}", pyramid.views.size(), estimator.levels);
  const bool rest = images.rest.image != VK_NULL_HANDLE;
  Result<ScreenPass> screen =
      makeScreenPass(device, images, light, shaderOf(estimator, sky, rest), bindingsOf(sky, rest), sizeof(shared::ShadePush));
  if (!screen) return screen.error();
  ShadePass pass{std::move(screen).value(), estimator, {}};
  const Result<GpuBuffer> constants = makeEstimatorConstants(device, estimator);
  if (!constants) {
    destroyShadePass(device, pass);
    return constants.error();
  }
  pass.constants = constants.value();
  writeEstimator(device, pass.screen.set, pyramid, pass.constants);
  if (sky) writeBuffer(device, pass.screen.set, kSkyBinding, *sky);
  if (!rest) return pass;
  writeSampledImage(device, pass.screen.set, kRestBinding, images.rest.view, pass.screen.nearest);
  writeLevels(device, pass.screen.set, kRestBinding + 1, atRest ? *atRest : pyramid);
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
