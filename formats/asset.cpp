#include "formats/asset.h"

#include <type_traits>

#include "formats/files.h"
#include "formats/uri.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

/// How a kind that lives in a file of its own is sampled, read and written.
template <class T>
struct FileKind {
  Representation representation;
  const char* extension;
  double (*sample)(const T&, const glm::dvec3&);
  Result<T> (*read)(const fs::path&);
  Result<std::vector<std::byte>> (*encode)(const T&, VolumeBits);
};

// One function per kind. Primitives have no file and are treated apart.
template <class T>
constexpr FileKind<T> kindOf() = delete;
template <>
constexpr FileKind<Volume> kindOf() {
  return {Representation::volume, ".vdb", sampleVolume, [](const fs::path& path) { return readVolume(path); }, encodeVolume};
}
template <>
constexpr FileKind<RadiusField> kindOf() {
  return {Representation::radius, ".exr", [](const RadiusField& field, const glm::dvec3& point) { return sampleRadius(field, point); },
          readRadius, [](const RadiusField& field, VolumeBits) -> Result<std::vector<std::byte>> { return encodeRadius(field); }};
}

template <>
constexpr FileKind<HeightField> kindOf() {
  return {Representation::heightfield, ".exr", [](const HeightField& field, const glm::dvec3& p) { return sampleHeightField(field, p); },
          readHeightField, [](const HeightField& field, VolumeBits) -> Result<std::vector<std::byte>> { return encodeHeightField(field); }};
}

/// What only some kinds know of themselves.
void describe(const Volume& volume, VolumeBits bits, Occluder& occluder) {
  occluder.signMethod = volume.signMethod;
  occluder.inside = volume.inside;
  occluder.sheetThickness = volume.sheetThickness;
  occluder.bits = bitCount(chooseBits(volume, bits));
}
template <class T>
void describe(const T&, VolumeBits, Occluder& occluder) {
  occluder.bits = 0;
}

template <class T>
Result<EncodedAsset> encode(const T& asset, Occluder& occluder, VolumeBits bits) {
  auto bytes = kindOf<T>().encode(asset, bits);
  if (!bytes) return bytes.error();
  occluder.contentHash = contentHash(bytes.value());
  occluder.bytes = bytes.value().size();
  occluder.primitive.reset();
  describe(asset, bits, occluder);
  return EncodedAsset{kindOf<T>().extension, std::move(bytes).value()};
}

Result<EncodedAsset> encode(const Primitive& primitive, Occluder& occluder, VolumeBits) {
  if (!isWhole(primitive)) return Error{"", "", fmt::format("a {} that is out of range", name(primitive.shape))};
  occluder.contentHash.clear();
  occluder.bytes = kPrimitiveBytes;
  occluder.bits = 0;
  occluder.primitive = primitive;
  return EncodedAsset{};
}

template <class T>
Result<Asset> read(const fs::path& path) {
  Result<T> asset = kindOf<T>().read(path);
  if (!asset) return asset.error();
  return Asset(std::move(asset).value());
}

/// The kind of the variant that has this representation and a file.
template <std::size_t index = 0>
Result<Asset> readKind(const fs::path& path, Representation representation) {
  if constexpr (index < std::variant_size_v<Asset>) {
    using T = std::variant_alternative_t<index, Asset>;
    if constexpr (!std::is_same_v<T, Primitive>)
      if (kindOf<T>().representation == representation) return read<T>(path);
    return readKind<index + 1>(path, representation);
  }
  return Error{path.string(), "", fmt::format("this program cannot read the representation '{}'", name(representation))};
}

}  // namespace

Representation representationOf(const Asset& asset) {
  return std::visit(
      []<class T>(const T&) {
        if constexpr (std::is_same_v<T, Primitive>)
          return Representation::primitive;
        else
          return kindOf<T>().representation;
      },
      asset);
}

Box bounds(const Asset& asset) {
  return std::visit([](const auto& kind) { return bounds(kind); }, asset);
}

double sampleAsset(const Asset& asset, const glm::dvec3& point) {
  return std::visit(
      [&]<class T>(const T& kind) {
        if constexpr (std::is_same_v<T, Primitive>)
          return samplePrimitive(kind, point);
        else
          return kindOf<T>().sample(kind, point);
      },
      asset);
}

double lipschitzBound(const Asset& asset) {
  return std::visit([](const auto& kind) { return lipschitzBound(kind); }, asset);
}

Result<EncodedAsset> encodeAsset(const Asset& asset, Occluder& occluder, VolumeBits volumeBits) {
  auto encoded = std::visit([&](const auto& kind) { return encode(kind, occluder, volumeBits); }, asset);
  if (!encoded) return encoded;
  occluder.representation = representationOf(asset);
  occluder.bounds = bounds(asset);
  occluder.lipschitz = lipschitzBound(asset);
  return encoded;
}

Result<std::uint64_t> writeAsset(const fs::path& folder, const std::string& stem, const Asset& asset, Occluder& occluder,
                                 VolumeBits volumeBits) {
  const auto encoded = encodeAsset(asset, occluder, volumeBits);
  if (!encoded) return Error{(folder / stem).string(), encoded.error().place, encoded.error().reason};
  occluder.uri = encoded.value().extension.empty() ? "" : stem + encoded.value().extension;
  if (occluder.uri.empty()) return occluder.bytes;
  if (const auto written = writeFileAtomically(folder / occluder.uri, encoded.value().bytes); !written) return written.error();
  return occluder.bytes;
}

Result<Asset> readAsset(const fs::path& folder, const Occluder& occluder) {
  if (occluder.representation == Representation::primitive) {
    if (!occluder.primitive || !isWhole(*occluder.primitive)) return Error{"", "primitive", "is missing or out of range"};
    return Asset(*occluder.primitive);
  }
  const Result<fs::path> path = checkedFile(folder, occluder.uri, occluder.contentHash);
  if (!path) return path.error();
  return readKind(path.value(), occluder.representation);
}

}  // namespace overcast
