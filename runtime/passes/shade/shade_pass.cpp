#include "runtime/passes/shade/shade_pass.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace overcast {

static_assert(sizeof(shared::ShadePush) == 128 && offsetof(shared::ShadePush, skew) == 64 && offsetof(shared::ShadePush, weights) == 96);

namespace {

/// The resolution at which Estimator::taps counts (formats/lighting.h).
constexpr double kTapResolution = 128.0;

constexpr std::uint32_t kSkyBinding = kFirstScreenBinding + shared::kMaxPyramidLevels;

Shader shaderOf(const SkyTaps& taps) {
  std::string upper = taps.estimator;
  std::transform(upper.begin(), upper.end(), upper.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return {"runtime/passes/shade/shade.comp.glsl", {{"OVERCAST_ESTIMATOR_" + upper, "1"}, {"OVERCAST_TAPS", fmt::format("{}", taps.count)}}};
}

}  // namespace

Result<SkyTaps> skyTaps(const Estimator& estimator, int resolution) {
  if (estimator.name != "published")
    return Error{"", "estimator", fmt::format("unknown estimator '{}' (known: published)", estimator.name)};
  SkyTaps taps;
  taps.estimator = estimator.name;
  const int added = static_cast<int>(std::lround(std::log2(resolution / kTapResolution)));
  taps.count = std::clamp(estimator.taps + added, 1, shared::kMaxTaps);
  taps.skyWeight = estimator.skyWeight;
  taps.constant = estimator.k * estimator.skyWeight;
  float sum = 0.0f;
  for (int tap = 0; tap < taps.count; ++tap) sum += shared::tapDistance(tap);
  for (int tap = 0; tap < taps.count; ++tap) taps.weights[static_cast<std::size_t>(tap)] = estimator.k / sum;
  return taps;
}

Result<ShadePass> makeShadePass(const Device& device, const GeometryImages& images, const GpuImage& light, const PyramidPass& pyramid,
                                const SkyTaps& taps, const GpuBuffer* sky) {
  OVERCAST_REQUIRE(static_cast<int>(pyramid.views.size()) >= taps.count, "{} levels for {} taps", pyramid.views.size(), taps.count);
  std::vector<Binding> levels;
  for (std::uint32_t level = 0; level < shared::kMaxPyramidLevels; ++level)
    levels.push_back({kFirstScreenBinding + level, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  std::vector<Binding> own = levels;
  Shader shader = shaderOf(taps);
  if (sky) {
    shader.defines.push_back({"OVERCAST_SKY", "1"});
    own.push_back({kSkyBinding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  }
  Result<ScreenPass> screen = makeScreenPass(device, images, light, shader, own, sizeof(shared::ShadePush));
  if (!screen) return screen.error();
  ShadePass pass{std::move(screen).value(), taps};
  for (std::size_t level = 0; level < levels.size(); ++level)
    writeSampledImage(device, pass.screen.set, levels[level].binding, pyramid.views[std::min(level, pyramid.views.size() - 1)],
                      pyramid.sampler, VK_IMAGE_LAYOUT_GENERAL);
  if (sky) writeBuffer(device, pass.screen.set, kSkyBinding, *sky);
  return pass;
}

void destroyShadePass(const Device& device, ShadePass& pass) {
  destroyScreenPass(device, pass.screen);
  pass = {};
}

void recordShade(VkCommandBuffer commands, const ShadePass& pass, const GlobalGrid& grid, const ShadeView& view) {
  shared::ShadePush constants;
  constants.voxelFromClip = voxelFromClip(grid, view.clipFromRelative, view.eye);
  constants.skew = glm::vec4(pass.taps.skyWeight * view.up, pass.taps.constant);
  constants.sky = glm::vec4(view.skyColour, 0.0f);
  for (int half = 0; half < 2; ++half)
    for (int i = 0; i < 4; ++i) constants.weights[half][i] = pass.taps.weights[static_cast<std::size_t>(4 * half + i)];
  recordScreenPass(commands, pass.screen, constants);
}

}  // namespace overcast
