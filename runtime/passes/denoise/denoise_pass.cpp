#include "runtime/passes/denoise/denoise_pass.h"

#include <cstddef>
#include <vector>

#include <fmt/format.h>
#include <glm/matrix.hpp>

#include "runtime/passes/denoise/denoise.h"

namespace overcast {

static_assert(sizeof(shared::DenoisePush) == 80 && offsetof(shared::DenoisePush, sky) == 64);

namespace {

constexpr std::uint32_t kSkyBinding = kFirstScreenBinding + 1;
constexpr const char* kShader = "runtime/passes/denoise/denoise.comp.glsl";

/// What the steps define, in their order.
std::vector<std::vector<ShaderDefine>> stepsOf(const DenoiseSettings& settings) {
  std::vector<std::vector<ShaderDefine>> steps{{}};
  if (settings.wide) steps.insert(steps.end(), {{{"OVERCAST_CORNERS", "2"}}, {{"OVERCAST_CORNERS", "4"}}});
  steps.back().push_back({"OVERCAST_LAST", "1"});
  for (std::vector<ShaderDefine>& step : steps)
    if (settings.few) step.push_back({"OVERCAST_FEW", "1"});
  return steps;
}

/// A step from `from` into `into`; the last has the light of `sky`.
Result<ScreenPass> makeStep(const Device& device, const GeometryImages& images, const GpuImage& from, const GpuImage& into, Shader shader,
                            const GpuBuffer* sky) {
  std::vector<Binding> own{{kFirstScreenBinding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}};
  if (sky) {
    shader.defines.push_back({"OVERCAST_SKY", fmt::format("{}", kSkyBinding)});
    own.push_back({kSkyBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  }
  if (images.rest.image) shader.defines.push_back({"OVERCAST_REST", "1"});
  Result<ScreenPass> made = makeScreenPass(device, images, into, shader, own, sizeof(shared::DenoisePush));
  if (!made) return made;
  writeSampledImage(device, made.value().set, kFirstScreenBinding, from.view, made.value().nearest);
  if (sky) writeBuffer(device, made.value().set, kSkyBinding, *sky);
  return made;
}

Result<Done> fill(const Device& device, const GeometryImages& images, const GpuImage& light, const DenoiseSettings& settings,
                  DenoisePass& pass) {
  for (GpuImage* image : {&pass.raw, &pass.other}) {
    if (image == &pass.other && !settings.wide) continue;
    Result<GpuImage> made = makeLightImage(device, images);
    if (!made) return made.error();
    *image = std::move(made).value();
  }
  const std::vector<std::vector<ShaderDefine>> steps = stepsOf(settings);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const bool last = i + 1 == steps.size();
    const GpuImage &from = i % 2 == 0 ? pass.raw : pass.other, &into = i % 2 == 0 ? pass.other : pass.raw;
    Result<ScreenPass> made = makeStep(device, images, from, last ? light : into, {kShader, steps[i]}, last ? settings.sky : nullptr);
    if (!made) return made.error();
    pass.steps.push_back(std::move(made).value());
  }
  return Done{};
}

}  // namespace

Result<DenoisePass> makeDenoisePass(const Device& device, const GeometryImages& images, const GpuImage& light,
                                    const DenoiseSettings& settings) {
  DenoisePass pass;
  pass.rays = settings.rays;
  const Result<Done> filled = fill(device, images, light, settings, pass);
  if (filled) return pass;
  destroyDenoisePass(device, pass);
  return filled.error();
}

void destroyDenoisePass(const Device& device, DenoisePass& pass) {
  for (ScreenPass& step : pass.steps) destroyScreenPass(device, step);
  destroyImage(device, pass.other);
  destroyImage(device, pass.raw);
  pass = {};
}

void recordDenoise(VkCommandBuffer commands, const DenoisePass& pass, const ScreenView& view) {
  const shared::DenoisePush push{glm::mat4(glm::inverse(view.clipFromRelative)), glm::vec4(view.skyColour, static_cast<float>(pass.rays))};
  for (const ScreenPass& step : pass.steps) recordScreenPass(commands, step, push);
}

}  // namespace overcast
