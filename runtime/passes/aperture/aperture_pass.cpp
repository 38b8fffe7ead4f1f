#include "runtime/passes/aperture/aperture_pass.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace overcast {

using shared::ApertureLight;
using shared::AperturePush;

static_assert(sizeof(ApertureLight) == 32 && offsetof(ApertureLight, radiance) == 16);
static_assert(sizeof(AperturePush) == 112 && offsetof(AperturePush, sky) == 64 && offsetof(AperturePush, lights) == 96);
static_assert(static_cast<int>(ApertureMode::exact) == shared::kApertureExact &&
              static_cast<int>(ApertureMode::smoothstep) == shared::kApertureSmoothstep &&
              static_cast<int>(ApertureMode::fast) == shared::kApertureFast &&
              static_cast<int>(ApertureMode::accurate) == shared::kApertureAccurate);

namespace {

/// Suns smaller than this are made as large, with the same light: what a single float keeps of the distance to them.
constexpr double kSmallestSun = 1e-4;

bool shines(const glm::vec3& colour) {
  return std::max({colour.x, colour.y, colour.z}) > 0.0f;
}

Result<Done> fill(const Device& device, const ApertureInputs& inputs, ApertureMode mode, AperturePass& pass) {
  constexpr std::uint32_t kAperture = kFirstScreenBinding, kLights = kAperture + 1, kVolume = kAperture + 2, kSky = kAperture + 3,
                          kSkyLight = kAperture + 4, kRest = kAperture + 5;
  const Result<GpuBuffer> lights =
      makeBuffer(device, shared::kMaxApertureLights * sizeof(ApertureLight), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, MemoryUse::upload);
  if (!lights) return lights.error();
  pass.lights = lights.value();
  Shader shader{"runtime/passes/aperture/aperture.comp.glsl", {{"OVERCAST_APERTURE_MODE", fmt::format("{}", static_cast<int>(mode))}}};
  std::vector<Binding> own{{kAperture, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER}, {kLights, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
  if (inputs.others) {
    shader.defines.push_back({"OVERCAST_OTHERS", "1"});
    own.push_back({kVolume, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  }
  if (inputs.images.rest.image) {
    shader.defines.push_back({"OVERCAST_REST", "1"});
    shader.defines.push_back({"OVERCAST_OVER_LIGHT", "1"});
    own.push_back({kRest, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  }
  if (inputs.sky) {
    shader.defines.push_back({"OVERCAST_SKY", "1"});
    own.push_back({kSky, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  }
  const GpuImage& skyLight = inputs.images.skyLight;
  if (skyLight.image) {
    shader.defines.push_back({"OVERCAST_TRANSFER", "1"});
    own.push_back({kSkyLight, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER});
  }
  Result<ScreenPass> screen = makeScreenPass(device, inputs.images, inputs.light, shader, own, sizeof(AperturePush));
  if (!screen) return screen.error();
  pass.screen = std::move(screen).value();
  writeSampledImage(device, pass.screen.set, kAperture, inputs.images.aperture.view, pass.screen.nearest);
  writeBuffer(device, pass.screen.set, kLights, pass.lights);
  if (inputs.sky) writeBuffer(device, pass.screen.set, kSky, *inputs.sky);
  if (skyLight.image) writeSampledImage(device, pass.screen.set, kSkyLight, skyLight.view, pass.screen.nearest);
  pass.overLight = inputs.images.rest.image != VK_NULL_HANDLE;
  if (pass.overLight) writeSampledImage(device, pass.screen.set, kRest, inputs.images.rest.view, pass.screen.nearest);
  if (inputs.others)
    writeSampledImage(device, pass.screen.set, kVolume, inputs.others->views[0], inputs.others->sampler, VK_IMAGE_LAYOUT_GENERAL);
  return Done{};
}

}  // namespace

Result<AperturePass> makeAperturePass(const Device& device, const ApertureInputs& inputs, ApertureMode mode) {
  OVERCAST_REQUIRE(inputs.images.aperture.image != VK_NULL_HANDLE, "the geometry images have no apertures");
  AperturePass pass;
  const Result<Done> filled = fill(device, inputs, mode, pass);
  if (filled) return pass;
  destroyAperturePass(device, pass);
  return filled.error();
}

void destroyAperturePass(const Device& device, AperturePass& pass) {
  destroyScreenPass(device, pass.screen);
  destroyBuffer(device, pass.lights);
  pass = {};
}

std::vector<ApertureLight> apertureLights(const Lighting& lighting, std::span<const glm::dmat4> worldFromNode, const glm::dvec3& eye) {
  std::vector<ApertureLight> lights;
  if (lighting.sun && shines(lighting.sun->colour)) {
    const double radius = std::clamp(static_cast<double>(lighting.sun->angularRadius), kSmallestSun, 1.5);
    const double half = std::sin(0.5 * radius);
    const glm::dvec3 radiance = glm::dvec3(lighting.sun->colour) / (4.0 * std::numbers::pi * half * half);
    lights.push_back({glm::vec4(glm::normalize(lighting.sun->direction), radius), glm::vec4(radiance, 1.0)});
  }
  for (const AreaLight& light : lighting.areaLights) {
    if (lights.size() == shared::kMaxApertureLights) break;
    if (!shines(light.colour) || light.radius <= 0.0f) continue;
    glm::dvec3 place(light.position);
    if (light.node >= 0) place = glm::dvec3(worldFromNode[static_cast<std::size_t>(light.node)] * glm::dvec4(place, 1.0));
    lights.push_back({glm::vec4(place - eye, light.radius), glm::vec4(light.colour, 0.0f)});
  }
  return lights;
}

void recordAperture(VkCommandBuffer commands, AperturePass& pass, const GlobalGrid& grid, const std::vector<ApertureLight>& lights,
                    const ApertureView& view) {
  OVERCAST_REQUIRE(lights.size() <= shared::kMaxApertureLights, "{} lights, room for {}", lights.size(), shared::kMaxApertureLights);
  if (!lights.empty()) std::memcpy(pass.lights.mapped, lights.data(), lights.size() * sizeof(ApertureLight));
  AperturePush constants;
  constants.relativeFromClip = glm::mat4(glm::inverse(view.clipFromRelative));
  constants.sky = glm::vec4(view.skyColour, 0.0f);
  constants.voxel = glm::vec4((view.eye - grid.origin) / grid.voxelSize, 1.0 / grid.voxelSize);
  constants.lights = glm::ivec4(static_cast<int>(lights.size()), 0, 0, 0);
  recordScreenPass(commands, pass.screen, constants, pass.overLight);
}

}  // namespace overcast
