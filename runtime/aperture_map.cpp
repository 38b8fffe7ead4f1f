#include "runtime/aperture_map.h"

#include <cstring>
#include <utility>
#include <vector>

#include <glm/gtc/packing.hpp>

#include "formats/shared/aperture.h"

namespace overcast {
namespace {

Result<GpuImage> makeMapImage(const Device& device, const ApertureMap& map, VkFormat format) {
  ImageSettings settings;
  settings.extent = {static_cast<std::uint32_t>(map.size.x), static_cast<std::uint32_t>(map.size.y), 1};
  settings.format = format;
  settings.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
  settings.mips = static_cast<std::uint32_t>(map.usableLevels);
  return makeImage(device, settings);
}

template <class T, class Texel>
std::vector<std::vector<std::byte>> levelsOf(const ApertureMap& map, Texel texel) {
  std::vector<std::vector<std::byte>> levels;
  for (int l = 0; l < map.usableLevels; ++l) {
    std::vector<T> values;
    for (const ApertureTexel& source : map.levels[static_cast<std::size_t>(l)]) values.push_back(texel(source));
    const std::span<const std::byte> bytes = std::as_bytes(std::span(values));
    levels.emplace_back(bytes.begin(), bytes.end());
  }
  return levels;
}

Result<Done> fill(const Device& device, const ApertureMap& map, ApertureMapImages& images) {
  auto cap = makeMapImage(device, map, VK_FORMAT_R16G16B16A16_SFLOAT);
  if (!cap) return cap.error();
  images.cap = std::move(cap).value();
  auto ambient = makeMapImage(device, map, VK_FORMAT_R16_SFLOAT);
  if (!ambient) return ambient.error();
  images.ambient = std::move(ambient).value();
  const auto caps = levelsOf<std::uint64_t>(map, [](const ApertureTexel& texel) {
    return glm::packHalf4x16(glm::vec4(texel.aperture.direction, texel.aperture.radius / shared::kApertureWidest));
  });
  if (auto done = uploadLevels(device, images.cap, caps, kFragmentSample); !done) return done;
  const auto ambients = levelsOf<std::uint16_t>(map, [](const ApertureTexel& texel) { return glm::packHalf1x16(texel.ambient); });
  return uploadLevels(device, images.ambient, ambients, kFragmentSample);
}

}  // namespace

Result<ApertureMapImages> uploadApertureMap(const Device& device, const ApertureMap& map) {
  ApertureMapImages images;
  const Result<Done> filled = fill(device, map, images);
  if (filled) return images;
  destroyApertureMap(device, images);
  return filled.error();
}

void destroyApertureMap(const Device& device, ApertureMapImages& images) {
  destroyImage(device, images.cap);
  destroyImage(device, images.ambient);
}

}  // namespace overcast
