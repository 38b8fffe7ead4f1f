#include "runtime/calibrate/sky_field.h"

#include <array>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

#include "runtime/passes/screen/screen.h"

namespace overcast {
namespace {

Result<FieldLevel> readLevel(const Device& device, const GpuImage& image) {
  const auto texels = readImage(device, image, kComputeWrite);
  if (!texels) return texels.error();
  FieldLevel level{{image.extent.width, image.extent.height, image.extent.depth}, {}};
  std::vector<std::uint16_t> halves(texels.value().size() / sizeof(std::uint16_t));
  std::memcpy(halves.data(), texels.value().data(), halves.size() * sizeof(std::uint16_t));
  level.values.reserve(halves.size());
  for (const std::uint16_t half : halves) level.values.push_back(glm::unpackHalf1x16(half));
  return level;
}

float interpolate(const FieldLevel& level, const glm::vec3& at) {
  const glm::ivec3 last = level.size - 1;
  const glm::vec3 low = glm::floor(at - 0.5f), part = at - 0.5f - low;
  const std::array<glm::ivec3, 2> corner{glm::clamp(glm::ivec3(low), glm::ivec3(0), last),
                                         glm::clamp(glm::ivec3(low) + 1, glm::ivec3(0), last)};
  const auto value = [&](std::size_t x, std::size_t y, std::size_t z) {
    const auto row = static_cast<std::size_t>(corner[z].z) * static_cast<std::size_t>(level.size.y) + static_cast<std::size_t>(corner[y].y);
    return level.values[row * static_cast<std::size_t>(level.size.x) + static_cast<std::size_t>(corner[x].x)];
  };
  std::array<float, 2> planes{};
  for (std::size_t z = 0; z < 2; ++z)
    planes[z] = glm::mix(glm::mix(value(0, 0, z), value(1, 0, z), part.x), glm::mix(value(0, 1, z), value(1, 1, z), part.x), part.y);
  return glm::mix(planes[0], planes[1], part.z);
}

Result<Done> fill(const Device& device, const RuntimeScene& scene, int resolution, FieldMaker& maker) {
  auto store = makeAssetStore(device, scene.assets);
  if (!store) return store.error();
  maker.store = std::move(store).value();
  const GlobalGrid grid = globalGrid(scene.lighting.globalVolume.bounds.value_or(scene.bounds), resolution);
  auto composite = makeCompositePass(device, grid, maker.store, static_cast<std::uint32_t>(scene.objects.size()));
  if (!composite) return composite.error();
  maker.composite = std::move(composite).value();
  auto pyramid = makePyramidPass(device, maker.composite.volume, shared::kMaxPyramidLevels);
  if (!pyramid) return pyramid.error();
  maker.pyramid = std::move(pyramid).value();
  return Done{};
}

}  // namespace

float fieldAt(const SkyField& field, int level, const glm::vec3& p) {
  const glm::vec3 inside = shared::insideLevel(p, glm::vec3(field.levels[0].size), level);
  return interpolate(field.levels[static_cast<std::size_t>(level)], inside / std::exp2(static_cast<float>(level))) +
         glm::distance(p, inside);
}

Result<FieldMaker> makeFieldMaker(const Device& device, const RuntimeScene& scene, int resolution) {
  FieldMaker maker;
  const auto filled = fill(device, scene, resolution, maker);
  if (filled) return maker;
  destroyFieldMaker(device, maker);
  return filled.error();
}

void destroyFieldMaker(const Device& device, FieldMaker& maker) {
  destroyPyramidPass(device, maker.pyramid);
  destroyCompositePass(device, maker.composite);
  destroyAssetStore(device, maker.store);
}

Result<SkyField> readField(const Device& device, FieldMaker& maker, const RuntimeScene& scene, double time) {
  const std::vector<glm::dmat4> nodes = worldFromLocal(scene.scene, time);
  std::vector<shared::CompositeObject> objects;
  for (const SceneObject& object : scene.objects)
    objects.push_back(compositeObject(maker.store.entries[object.asset], nodes[object.node], maker.composite.grid));
  const auto done = runCommands(device, [&](VkCommandBuffer commands) {
    if (recordComposite(commands, maker.composite, objects)) recordPyramid(commands, maker.pyramid);
  });
  if (!done) return done.error();
  SkyField field{maker.composite.grid, {}};
  std::vector<const GpuImage*> images{&maker.composite.volume};
  for (const GpuImage& image : maker.pyramid.built) images.push_back(&image);
  for (const GpuImage* image : images) {
    auto level = readLevel(device, *image);
    if (!level) return level.error();
    field.levels.push_back(std::move(level).value());
  }
  return field;
}

}  // namespace overcast
