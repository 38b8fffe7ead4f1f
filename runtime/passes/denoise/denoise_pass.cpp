#include "runtime/passes/denoise/denoise_pass.h"

#include <cstddef>

#include <fmt/format.h>
#include <glm/matrix.hpp>

#include "runtime/passes/denoise/denoise.h"

namespace overcast {

static_assert(sizeof(shared::DenoisePush) == 80 && offsetof(shared::DenoisePush, sky) == 64);

namespace {

constexpr std::uint32_t kSkyBinding = kFirstScreenBinding + 1;

Result<Done> fill(const Device& device, const GeometryImages& images, const GpuImage& light, const GpuBuffer* sky, DenoisePass& pass) {
  Result<GpuImage> raw = makeLightImage(device, images);
  if (!raw) return raw.error();
  pass.raw = std::move(raw).value();
  Shader shader{"runtime/passes/denoise/denoise.comp.glsl", {}};
  std::vector<Binding> own{{kFirstScreenBinding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}};
  if (sky) {
    shader.defines.push_back({"OVERCAST_SKY", fmt::format("{}", kSkyBinding)});
    own.push_back({kSkyBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  }
  Result<ScreenPass> screen = makeScreenPass(device, images, light, shader, own, sizeof(shared::DenoisePush));
  if (!screen) return screen.error();
  pass.screen = std::move(screen).value();
  writeSampledImage(device, pass.screen.set, kFirstScreenBinding, pass.raw.view, pass.screen.nearest);
  if (sky) writeBuffer(device, pass.screen.set, kSkyBinding, *sky);
  return Done{};
}

}  // namespace

Result<DenoisePass> makeDenoisePass(const Device& device, const GeometryImages& images, const GpuImage& light, const GpuBuffer* sky) {
  DenoisePass pass;
  const Result<Done> filled = fill(device, images, light, sky, pass);
  if (filled) return pass;
  destroyDenoisePass(device, pass);
  return filled.error();
}

void destroyDenoisePass(const Device& device, DenoisePass& pass) {
  destroyScreenPass(device, pass.screen);
  destroyImage(device, pass.raw);
}

void recordDenoise(VkCommandBuffer commands, const DenoisePass& pass, const ScreenView& view) {
  recordScreenPass(commands, pass.screen,
                   shared::DenoisePush{glm::mat4(glm::inverse(view.clipFromRelative)), glm::vec4(view.skyColour, 0.0f)});
}

}  // namespace overcast
