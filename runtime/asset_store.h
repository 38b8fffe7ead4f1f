// AssetStore: all local occluders of a scene on the device: volumes in one 3D image (atlas.h), texels of radius and heightfield
// assets in one buffer (passes/composite/fields.h), primitives in their records alone.
#pragma once

#include <span>
#include <variant>
#include <vector>

#include <glm/vec2.hpp>

#include "formats/asset.h"
#include "runtime/atlas.h"
#include "runtime/passes/composite/composite_object.h"
#include "runtime/passes/composite/heightfield_object.h"
#include "runtime/passes/composite/radius_object.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// Where one asset is on the device, as its record needs it.
using AssetEntry = std::variant<AtlasEntry, Primitive, RadiusEntry, HeightFieldEntry>;

struct AssetStore {
  Atlas atlas;
  GpuBuffer fields;                 ///< vec2 texels of all fields, one asset after another; at least one texel
  std::uint32_t kinds = 0;          ///< bit shared::kKind... for each kind there is
  std::vector<AssetEntry> entries;  ///< one for each asset, in the order given
};

/// Packs and uploads; waits. `voxels` has for each asset the size of a global voxel in local units where it is placed largest
/// (finestVoxels): radius fields and heightfields become volumes of that detail (resample.h). Empty: everything stays what it is. An Error
/// when the device cannot hold all.
Result<AssetStore> makeAssetStore(const Device& device, std::span<const Asset> assets, AtlasBits bits = AtlasBits::half,
                                  std::span<const double> voxels = {});
void destroyAssetStore(const Device& device, AssetStore& store);

/// The record of an asset placed by `worldFromLocal` (composite_object.h).
shared::CompositeObject compositeObject(const AssetEntry& entry, const glm::dmat4& worldFromLocal, const GlobalGrid& grid);

}  // namespace overcast
