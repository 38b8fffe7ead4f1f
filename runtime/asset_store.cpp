#include "runtime/asset_store.h"

#include <optional>

#include <fmt/format.h>

#include "runtime/resample.h"

namespace overcast {
namespace {

/// What the assets put on the device.
struct Contents {
  std::vector<const Volume*> volumes;
  std::vector<glm::vec2> texels;
  std::uint32_t kinds = 0;  ///< AssetStore::kinds
};

// One function per kind: puts the asset into `contents` and says where.
AssetEntry add(const Volume& volume, Contents& contents) {
  contents.kinds |= 1u << (volume.step > 0.0f ? shared::kKindVolume8 : shared::kKindVolume);
  contents.volumes.push_back(&volume);
  return AtlasEntry{};  // known when all volumes are packed
}
AssetEntry add(const Primitive& primitive, Contents& contents) {
  contents.kinds |= 1u << (primitive.shape == PrimitiveShape::cuboid ? shared::kKindCuboid : shared::kKindEllipsoid);
  return primitive;
}
AssetEntry add(const RadiusField& radius, Contents& contents) {
  contents.kinds |= 1u << shared::kKindRadius;
  return packRadius(radius, contents.texels);
}

AssetEntry add(const HeightField& field, Contents& contents) {
  contents.kinds |= 1u << shared::kKindHeightField;
  return addHeightField(field, contents.texels);
}

Result<GpuBuffer> uploadTexels(const Device& device, std::vector<glm::vec2>& texels) {
  if (texels.empty()) texels.emplace_back(0.0f);  // a descriptor needs something to point at
  const std::uint64_t bytes = texels.size() * sizeof(glm::vec2), most = device.properties.limits.maxStorageBufferRange;
  if (bytes > most)
    return Error{"", "fields",
                 fmt::format("radius and heightfield assets need {} bytes in one buffer, this device allows {}", bytes, most)};
  return makeBufferWith(device, std::as_bytes(std::span(texels)), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
}

}  // namespace

Result<AssetStore> makeAssetStore(const Device& device, std::span<const Asset> assets, AtlasBits bits, std::span<const double> voxels) {
  AssetStore store;
  Contents contents;
  std::vector<std::optional<Resampled>> volumes(assets.size());
  if (!voxels.empty()) volumes = resampledAll(assets, voxels, static_cast<int>(device.properties.limits.maxImageDimension3D));
  for (std::size_t i = 0; i < assets.size(); ++i) {
    store.entries.push_back(volumes[i] ? add(volumes[i]->volume, contents)
                                       : std::visit([&](const auto& kind) { return add(kind, contents); }, assets[i]));
  }
  store.kinds = contents.kinds;
  Result<Atlas> atlas = makeAtlas(device, contents.volumes, bits);
  if (!atlas) return atlas.error();
  store.atlas = std::move(atlas).value();
  auto packed = store.atlas.entries.begin();
  for (std::size_t i = 0; i < store.entries.size(); ++i)
    if (std::holds_alternative<AtlasEntry>(store.entries[i])) {
      if (volumes[i]) packed->axes = volumes[i]->localFromVolume;
      store.entries[i] = *packed++;
    }
  Result<GpuBuffer> fields = uploadTexels(device, contents.texels);
  if (!fields) {
    destroyAssetStore(device, store);
    return fields.error();
  }
  store.fields = fields.value();
  return store;
}

void destroyAssetStore(const Device& device, AssetStore& store) {
  destroyBuffer(device, store.fields);
  destroyAtlas(device, store.atlas);
  store = {};
}

shared::CompositeObject compositeObject(const AssetEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid) {
  return std::visit([&](const auto& kind) { return compositeObject(kind, worldFromLocal, grid); }, entry);
}

}  // namespace overcast
