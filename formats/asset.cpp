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
  Result<std::uint64_t> (*write)(const fs::path&, const T&, VolumeBits);
};

// One function per kind. Primitives have no file and are treated apart.
template <class T>
constexpr FileKind<T> kindOf() = delete;
template <>
constexpr FileKind<Volume> kindOf() {
  return {Representation::volume, ".vdb", sampleVolume, [](const fs::path& path) { return readVolume(path); },
          [](const fs::path& path, const Volume& volume, VolumeBits bits) { return writeVolume(path, volume, bits); }};
}
template <>
constexpr FileKind<RadiusField> kindOf() {
  return {Representation::radius, ".exr", [](const RadiusField& field, const glm::dvec3& point) { return sampleRadius(field, point); },
          readRadius, [](const fs::path& path, const RadiusField& field, VolumeBits) { return writeRadius(path, field); }};
}

template <>
constexpr FileKind<HeightField> kindOf() {
  return {Representation::heightfield, ".exr", [](const HeightField& field, const glm::dvec3& p) { return sampleHeightField(field, p); },
          readHeightField, [](const fs::path& path, const HeightField& field, VolumeBits) { return writeHeightField(path, field); }};
}

/// What only some kinds know of themselves.
void describe(const Volume& volume, VolumeBits bits, Occluder& occluder) {
  occluder.signMethod = volume.signMethod;
  occluder.bits = bitCount(chooseBits(volume, bits));
}
template <class T>
void describe(const T&, VolumeBits, Occluder& occluder) {
  occluder.bits = 0;
}

template <class T>
Result<std::uint64_t> write(const fs::path& folder, const std::string& stem, const T& asset, Occluder& occluder, VolumeBits bits) {
  const std::string uri = stem + kindOf<T>().extension;
  const Result<std::uint64_t> bytes = kindOf<T>().write(folder / uri, asset, bits);
  if (!bytes) return bytes.error();
  const auto content = readFile(folder / uri);
  if (!content) return content.error();
  occluder.uri = uri;
  occluder.contentHash = contentHash(content.value());
  occluder.primitive.reset();
  describe(asset, bits, occluder);
  return bytes;
}

Result<std::uint64_t> write(const fs::path&, const std::string& stem, const Primitive& primitive, Occluder& occluder, VolumeBits) {
  if (!isWhole(primitive)) return Error{stem, "", fmt::format("a {} that is out of range", name(primitive.shape))};
  occluder.uri.clear();
  occluder.contentHash.clear();
  occluder.bits = 0;
  occluder.primitive = primitive;
  return kPrimitiveBytes;
}

/// The file, when it holds what the scene says it does.
Result<fs::path> checkedFile(const fs::path& folder, const Occluder& occluder) {
  Result<fs::path> path = resolveInside(folder, uriFromPath(occluder.uri));
  if (!path) return path;
  const Result<std::vector<std::byte>> bytes = readFile(path.value());
  if (!bytes) return bytes.error();
  const std::string hash = contentHash(bytes.value());
  if (hash == occluder.contentHash) return path;
  return Error{path.value().string(), "",
               fmt::format("its content hash is {}, but the scene was baked with {}: bake the scene again", hash, occluder.contentHash)};
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

Result<std::uint64_t> writeAsset(const fs::path& folder, const std::string& stem, const Asset& asset, Occluder& occluder,
                                 VolumeBits volumeBits) {
  const auto bytes = std::visit([&](const auto& kind) { return write(folder, stem, kind, occluder, volumeBits); }, asset);
  if (!bytes) return bytes;
  occluder.representation = representationOf(asset);
  occluder.bytes = bytes.value();
  occluder.bounds = bounds(asset);
  occluder.lipschitz = lipschitzBound(asset);
  return bytes;
}

Result<Asset> readAsset(const fs::path& folder, const Occluder& occluder) {
  if (occluder.representation == Representation::primitive) {
    if (!occluder.primitive || !isWhole(*occluder.primitive)) return Error{"", "primitive", "is missing or out of range"};
    return Asset(*occluder.primitive);
  }
  const Result<fs::path> path = checkedFile(folder, occluder);
  if (!path) return path.error();
  return readKind(path.value(), occluder.representation);
}

}  // namespace overcast
