// Asset: any baked representation, and where each kind is read, written and sampled. A kind lives in its own formats/<stem>.h; what
// has to be said about it here is one line in the variant and one in asset.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "formats/heightfield.h"
#include "formats/occluder.h"
#include "formats/primitive.h"
#include "formats/radius.h"
#include "formats/result.h"
#include "formats/volume.h"

namespace overcast {

using Asset = std::variant<Volume, Primitive, RadiusField, HeightField>;

Representation representationOf(const Asset& asset);

/// The box within which the representation is defined, local space.
Box bounds(const Asset& asset);

/// The distance as the runtime evaluates it (in double), local units, at any finite point; beyond the asset's box continued as DESIGN 5.1
/// says, continuous there.
double sampleAsset(const Asset& asset, const glm::dvec3& point);

/// A Lipschitz constant over all of space of sampleAsset, or of its lower bound beyond the box (volume.h).
double lipschitzBound(const Asset& asset);

/// An asset as its file: both empty for a primitive, which has none.
struct EncodedAsset {
  std::string extension;  ///< with the dot: ".vdb"
  std::vector<std::byte> bytes;
};

/// The asset as the bytes that writeAsset puts on disk, and their description: fills representation, contentHash, bytes (kPrimitiveBytes
/// for a primitive), bounds, lipschitz, a volume's signMethod and bits and a primitive's numbers, and leaves the rest of `occluder` alone.
/// `volumeBits` is for volumes alone. Deterministic. An Error without a file when the values do not fit the format.
Result<EncodedAsset> encodeAsset(const Asset& asset, Occluder& occluder, VolumeBits volumeBits = VolumeBits::automatic);

/// Writes the asset as folder/<stem>.<its extension> (atomically; nothing for a primitive) and describes it as encodeAsset does; fills uri
/// too. `stem` may hold folders ("assets/bunny-0123"). Returns the bytes it costs on disk. An Error when the disk fails or the values do
/// not fit the format.
Result<std::uint64_t> writeAsset(const std::filesystem::path& folder, const std::string& stem, const Asset& asset, Occluder& occluder,
                                 VolumeBits volumeBits = VolumeBits::automatic);

/// Reads what `occluder` names, relative to `folder`. An Error when the file lies outside the folder, is missing or broken, its content
/// hash is not the stored one, or this program cannot read the representation.
Result<Asset> readAsset(const std::filesystem::path& folder, const Occluder& occluder);

}  // namespace overcast
