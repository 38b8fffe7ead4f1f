#include "runtime/passes/denoise/denoise_pass.h"

#include <cstddef>

#include <fmt/format.h>
#include <glm/matrix.hpp>

#include "runtime/passes/denoise/denoise.h"

namespace overcast {

static_assert(sizeof(shared::DenoisePush) == 80 && offsetof(shared::DenoisePush, sky) == 64);

namespace {

constexpr std::uint32_t kSkyBinding = kFirstScreenBinding + 1;

/// A step from `from` into `into`.
Result<Done> addStep(const Device& device, const GeometryImages& images, const GpuImage& from, const GpuImage& into, Shader shader,
                     const GpuBuffer* sky, ScreenPass& step) {
  std::vector<Binding> own{{kFirstScreenBinding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}};
  if (sky) {
    shader.defines.push_back({"OVERCAST_SKY", fmt::format("{}", kSkyBinding)});
    own.push_back({kSkyBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  }
  if (images.rest.image) shader.defines.push_back({"OVERCAST_REST", "1"});
  Result<ScreenPass> made = makeScreenPass(device, images, into, shader, own, sizeof(shared::DenoisePush));
  if (!made) return made.error();
  step = std::move(made).value();
  writeSampledImage(device, step.set, kFirstScreenBinding, from.view, step.nearest);
  if (sky) writeBuffer(device, step.set, kSkyBinding, *sky);
  return Done{};
}

Result<Done> fill(const Device& device, const GeometryImages& images, const GpuImage& light, const DenoiseSettings& settings,
                  DenoisePass& pass) {
  const char* const path = "runtime/passes/denoise/denoise.comp.glsl";
  for (GpuImage* image : {&pass.raw, &pass.mean}) {
    if (image == &pass.mean && !settings.wide) continue;
    Result<GpuImage> made = makeLightImage(device, images);
    if (!made) return made.error();
    *image = std::move(made).value();
  }
  if (!settings.wide) return addStep(device, images, pass.raw, light, {path, {}}, settings.sky, pass.screen);
  const Result<Done> first = addStep(device, images, pass.raw, pass.mean, {path, {{"OVERCAST_FIRST", "1"}}}, nullptr, pass.screen);
  return first ? addStep(device, images, pass.mean, light, {path, {{"OVERCAST_WIDEN", "1"}}}, settings.sky, pass.widen) : first;
}

}  // namespace

Result<DenoisePass> makeDenoisePass(const Device& device, const GeometryImages& images, const GpuImage& light,
                                    const DenoiseSettings& settings) {
  DenoisePass pass;
  const Result<Done> filled = fill(device, images, light, settings, pass);
  if (filled) return pass;
  destroyDenoisePass(device, pass);
  return filled.error();
}

void destroyDenoisePass(const Device& device, DenoisePass& pass) {
  destroyScreenPass(device, pass.widen);
  destroyImage(device, pass.mean);
  destroyScreenPass(device, pass.screen);
  destroyImage(device, pass.raw);
}

void recordDenoise(VkCommandBuffer commands, const DenoisePass& pass, const ScreenView& view) {
  const shared::DenoisePush push{glm::mat4(glm::inverse(view.clipFromRelative)), glm::vec4(view.skyColour, 0.0f)};
  recordScreenPass(commands, pass.screen, push);
  if (pass.widen.light.image) recordScreenPass(commands, pass.widen, push);
}

}  // namespace overcast
