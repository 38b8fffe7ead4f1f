#include "runtime/asset_store.h"

#include <fmt/format.h>

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

Result<AssetStore> makeAssetStore(const Device& device, std::span<const Asset> assets, AtlasBits bits) {
  AssetStore store;
  Contents contents;
  for (const Asset& asset : assets) store.entries.push_back(std::visit([&](const auto& kind) { return add(kind, contents); }, asset));
  store.kinds = contents.kinds;
  Result<Atlas> atlas = makeAtlas(device, contents.volumes, bits);
  if (!atlas) return atlas.error();
  store.atlas = std::move(atlas).value();
  auto packed = store.atlas.entries.begin();
  for (AssetEntry& entry : store.entries)
    if (std::holds_alternative<AtlasEntry>(entry)) entry = *packed++;
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
