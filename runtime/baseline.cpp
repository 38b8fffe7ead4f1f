#include "runtime/baseline.h"

#include <algorithm>
#include <cstddef>

#include <glm/matrix.hpp>

#include "runtime/passes/cone_tracing/cone_tracing.h"
#include "runtime/passes/constant/constant.h"
#include "runtime/passes/gtao/gtao.h"
#include "runtime/passes/rays/rays.h"

namespace overcast {

static_assert(sizeof(shared::ConstantPush) == 16);
static_assert(sizeof(shared::ConeTracingPush) == 80 && offsetof(shared::ConeTracingPush, sky) == 64);
static_assert(sizeof(shared::GtaoPush) == 96 && offsetof(shared::GtaoPush, search) == 80);
static_assert(sizeof(shared::RaysPush) == 80 && offsetof(shared::RaysPush, sky) == 64);

namespace {

struct Program {
  Shader shader;
  std::uint32_t pushBytes = 0;
};

Program programOf(Technique technique) {
  switch (technique) {
    case Technique::overcast:
      break;
    case Technique::constant:
      return {{"runtime/passes/constant/constant.comp.glsl", {}}, sizeof(shared::ConstantPush)};
    case Technique::gtao:
      return {{"runtime/passes/gtao/gtao.comp.glsl", {}}, sizeof(shared::GtaoPush)};
    case Technique::coneTracing:
      return {{"runtime/passes/cone_tracing/cone_tracing.comp.glsl", {}}, sizeof(shared::ConeTracingPush)};
    case Technique::rays16:
      return {{"runtime/passes/rays/rays.comp.glsl", {{"OVERCAST_RAYS", "16"}}}, sizeof(shared::RaysPush)};
    case Technique::rays64:
      return {{"runtime/passes/rays/rays.comp.glsl", {{"OVERCAST_RAYS", "64"}}}, sizeof(shared::RaysPush)};
    case Technique::surfels:
      return {{"runtime/passes/surfels/surfels.comp.glsl", {}}, sizeof(shared::SurfelPush)};
  }
  OVERCAST_REQUIRE(false, "technique {} is no baseline", nameOf(technique));
}

/// GtaoPush::search. The default radius had the least error of sky visibility on our scenes.
glm::vec4 searchOf(const TechniqueSettings& settings, const GlobalGrid& grid) {
  constexpr double kRadiusShare = 2.0;
  const double longest = grid.voxelSize * std::max({grid.size.x, grid.size.y, grid.size.z});
  const auto radius = static_cast<float>(settings.gtaoRadius.value_or(kRadiusShare * longest));
  const GtaoSearch& search = settings.gtaoSearch;
  const auto steps = static_cast<float>(search.steps);
  return {radius, static_cast<float>(search.slices), steps, search.thickness / steps};
}

Result<Done> fill(const Device& device, const BaselineInputs& inputs, Baseline& baseline) {
  const Program program = programOf(baseline.settings.technique);
  const bool volume = readsVolume(baseline.settings.technique);
  const bool surfels = baseline.settings.technique == Technique::surfels;
  OVERCAST_REQUIRE(!surfels || inputs.surfels, "{} without their pass", nameOf(baseline.settings.technique));
  std::vector<Binding> own;
  if (surfels)
    for (std::uint32_t i = 0; i < 2; ++i) own.push_back({kFirstScreenBinding + i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  if (volume) own.push_back({kFirstScreenBinding, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  Result<ScreenPass> light = makeScreenPass(device, inputs.images, inputs.light, program.shader, own, program.pushBytes);
  if (!light) return light.error();
  baseline.light = std::move(light).value();
  if (surfels) {
    baseline.surfels = inputs.surfels->placedCount;
    writeBuffer(device, baseline.light.set, kFirstScreenBinding, inputs.surfels->placed);
    writeBuffer(device, baseline.light.set, kFirstScreenBinding + 1, inputs.surfels->lights);
  }
  if (!volume) return Done{};
  const Result<VkSampler> trilinear = makeSampler(device, VK_FILTER_LINEAR);
  if (!trilinear) return trilinear.error();
  baseline.trilinear = trilinear.value();
  writeSampledImage(device, baseline.light.set, kFirstScreenBinding, inputs.volume.view, baseline.trilinear, VK_IMAGE_LAYOUT_GENERAL);
  return Done{};
}

}  // namespace

Result<Baseline> makeBaseline(const Device& device, const TechniqueSettings& settings, const BaselineInputs& inputs) {
  Baseline baseline;
  baseline.settings = settings;
  const Result<Done> filled = fill(device, inputs, baseline);
  if (filled) return baseline;
  destroyBaseline(device, baseline);
  return filled.error();
}

void destroyBaseline(const Device& device, Baseline& baseline) {
  destroyScreenPass(device, baseline.light);
  if (baseline.trilinear) vkDestroySampler(device.device, baseline.trilinear, nullptr);
  baseline = {};
}

void recordBaseline(VkCommandBuffer commands, const Baseline& baseline, const GlobalGrid& grid, const ScreenView& view) {
  const auto sky = [&](float w) { return glm::vec4(view.skyColour, w); };
  const glm::mat4 fromClip = voxelFromClip(grid, view.clipFromRelative, view.eye);
  switch (baseline.settings.technique) {
    case Technique::constant:
      recordScreenPass(commands, baseline.light, shared::ConstantPush{sky(baseline.settings.constant)});
      break;
    case Technique::gtao:
      recordScreenPass(commands, baseline.light,
                       shared::GtaoPush{glm::mat4(glm::inverse(view.clipFromRelative)), sky(0.0f), searchOf(baseline.settings, grid)});
      break;
    case Technique::coneTracing: {
      const auto reach = static_cast<float>(std::max({grid.size.x, grid.size.y, grid.size.z}));
      recordScreenPass(commands, baseline.light, shared::ConeTracingPush{fromClip, sky(shared::tracedConeRatio(reach))});
      break;
    }
    case Technique::surfels:
      recordScreenPass(
          commands, baseline.light,
          surfelPush(baseline.surfels, baseline.settings.surfelNearness, glm::mat4(glm::inverse(view.clipFromRelative)), view.skyColour));
      break;
    default:
      recordScreenPass(commands, baseline.light, shared::RaysPush{fromClip, sky(0.0f)});
  }
}

}  // namespace overcast
