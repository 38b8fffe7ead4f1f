// Primitives of a glTF mesh to triangles (glTF 2.0, 3.7.2).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include <tiny_gltf.h>

#include "formats/gltf_accessor.h"
#include "formats/gltf_reader.h"

namespace overcast {
namespace {

bool isFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Positions of one primitive: where they start in the mesh, and how many there are.
struct VertexRange {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// The accessors that make the vertices of a primitive; -1: it has none.
struct VertexAccessors {
  int position = -1;
  int normal = -1;
  int texCoord = -1;
  int aperture = -1;
  std::array<int, 3> transfer = {-1, -1, -1};

  auto operator<=>(const VertexAccessors&) const = default;
};

/// Vertices already in the mesh by their accessors, so that primitives which share vertices go on sharing them.
using SharedVertices = std::map<VertexAccessors, VertexRange>;

struct MeshUnderway {
  Mesh mesh;
  int texCoord = 0;  ///< set of texture coordinates that is read
  SharedVertices shared;
  std::vector<bool> finite;     ///< one per position
  VertexVisibility visibility;  ///< zeros where primitives have none
  // Of primitives with triangles:
  bool lacksNormals = false;
  bool lacksCoordinates = false;
  bool lacksApertures = false;
  bool mixesPackings = false;
  bool lacksTransfer = false;
};

/// A unit vector as it is (bit for bit), another one normalised, and zero when it has no direction.
glm::vec3 unitOrZero(const glm::dvec3& v) {
  const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
  if (!(length > 0.0) || !std::isfinite(length)) return glm::vec3(0.0f);
  return std::abs(length - 1.0) < 1e-5 ? glm::vec3(v) : glm::vec3(v / length);
}

int attribute(const tinygltf::Primitive& primitive, const char* name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

bool isAccessor(const tinygltf::Model& model, int accessor, int type) {
  return accessor >= 0 && static_cast<std::size_t>(accessor) < model.accessors.size() &&
         model.accessors[static_cast<std::size_t>(accessor)].type == type;
}

/// Which packing an _APERTURE accessor has; nothing when it is not one of ours, since any program may use that name.
std::optional<ApertureBits> packingOf(const tinygltf::Model& model, int accessor) {
  if (!isAccessor(model, accessor, TINYGLTF_TYPE_VEC4)) return std::nullopt;
  const tinygltf::Accessor& source = model.accessors[static_cast<std::size_t>(accessor)];
  if (source.normalized) return std::nullopt;
  if (source.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return ApertureBits::packed32;
  if (source.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return ApertureBits::packed64;
  return std::nullopt;
}

VertexAccessors accessorsOf(const tinygltf::Model& model, const tinygltf::Primitive& primitive, int texCoord, Tally& tally) {
  VertexAccessors accessors{attribute(primitive, "POSITION"),
                            attribute(primitive, "NORMAL"),
                            attribute(primitive, fmt::format("TEXCOORD_{}", texCoord).c_str()),
                            attribute(primitive, "_APERTURE"),
                            {}};
  if (!isAccessor(model, accessors.texCoord, TINYGLTF_TYPE_VEC2)) accessors.texCoord = -1;
  if (accessors.aperture >= 0 && !packingOf(model, accessors.aperture)) {
    accessors.aperture = -1;
    ++tally["attributes _APERTURE are not four unsigned bytes or shorts and were left out"];
  }
  bool whole = true;
  for (std::size_t i = 0; i < 3; ++i) {
    accessors.transfer[i] = attribute(primitive, fmt::format("_TRANSFER_{}", i).c_str());
    whole = whole && isAccessor(model, accessors.transfer[i], TINYGLTF_TYPE_VEC3);
  }
  if (!whole) accessors.transfer.fill(-1);
  return accessors;
}

/// Four numbers of an _APERTURE attribute as the code they spell, lowest first.
std::uint64_t codeOf(const double* numbers, ApertureBits bits) {
  const int width = bits == ApertureBits::packed32 ? 8 : 16;
  std::uint64_t code = 0;
  for (int c = 0; c < 4; ++c) code |= static_cast<std::uint64_t>(numbers[c]) << (c * width);
  return code;
}

Result<Done> addApertures(const tinygltf::Model& model, int accessor, const VertexRange& range, VertexVisibility& visibility) {
  auto read = readNumbers(model, accessor, 4);
  if (!read) return read.error();
  const std::vector<double>& numbers = read.value();
  if (numbers.size() != std::size_t{4} * range.count)
    return Error{"", "_APERTURE", fmt::format("has {} elements where POSITION has {}", numbers.size() / 4, range.count)};
  visibility.bits = *packingOf(model, accessor);
  for (std::size_t i = 0; i < range.count; ++i) {
    const std::uint64_t code = codeOf(&numbers[4 * i], visibility.bits);
    const bool wide = visibility.bits == ApertureBits::packed64;
    visibility.apertures[range.first + i] = wide ? unpackAperture64(code) : unpackAperture32(static_cast<std::uint32_t>(code));
    if (wide) visibility.ambient[range.first + i] = unpackAmbient64(code);
  }
  return Done{};
}

Result<Done> addTransfer(const tinygltf::Model& model, const std::array<int, 3>& accessors, const VertexRange& range,
                         VertexVisibility& visibility) {
  for (std::size_t k = 0; k < 3; ++k) {
    auto read = readNumbers(model, accessors[k], 3);
    if (!read) return read.error();
    const std::string place = fmt::format("_TRANSFER_{}", k);
    const std::vector<double>& numbers = read.value();
    if (numbers.size() != std::size_t{3} * range.count)
      return Error{"", place, fmt::format("has {} elements where POSITION has {}", numbers.size() / 3, range.count)};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto number = static_cast<float>(numbers[i]);
      if (!std::isfinite(number)) return Error{"", place, fmt::format("element {} is not a finite number", i / 3)};
      visibility.transfer[range.first + i / 3][3 * k + i % 3] = number;
    }
  }
  return Done{};
}

/// Room for the visibility of vertices that were just added, and what the primitive has of it.
Result<Done> addVisibility(const tinygltf::Model& model, const VertexAccessors& accessors, const VertexRange& range,
                           VertexVisibility& visibility) {
  const std::size_t count = std::size_t{range.first} + range.count;
  visibility.apertures.resize(count);
  visibility.ambient.resize(count);
  visibility.transfer.resize(count);
  if (accessors.aperture >= 0) {
    auto added = addApertures(model, accessors.aperture, range, visibility);
    if (!added) return added.error();
  }
  return accessors.transfer[0] >= 0 ? addTransfer(model, accessors.transfer, range, visibility) : Done{};
}

/// Room for the texture coordinates of vertices that were just added, and those the primitive has.
Result<Done> addCoordinates(const tinygltf::Model& model, int accessor, const VertexRange& range, Mesh& mesh) {
  mesh.textureCoordinates.resize(mesh.positions.size(), glm::vec2(0.0f));
  if (accessor < 0) return Done{};
  const auto read = readNumbers(model, accessor, 2);
  if (!read) return read.error();
  const std::vector<double>& numbers = read.value();
  if (numbers.size() != std::size_t{2} * range.count)
    return Error{"", "TEXCOORD", fmt::format("has {} elements where POSITION has {}", numbers.size() / 2, range.count)};
  for (std::size_t i = 0; i < range.count; ++i) mesh.textureCoordinates[range.first + i] = {numbers[2 * i], numbers[2 * i + 1]};
  return Done{};
}

Result<VertexRange> addVertices(const tinygltf::Model& model, const VertexAccessors& accessors, MeshUnderway& underway, Tally& tally) {
  const auto known = underway.shared.find(accessors);
  if (known != underway.shared.end()) return known->second;
  const int normal = accessors.normal;
  auto positions = readNumbers(model, accessors.position, 3);
  if (!positions) return positions.error();
  const std::vector<double>& p = positions.value();
  const std::size_t count = p.size() / 3;
  Mesh& mesh = underway.mesh;
  if (count > std::numeric_limits<std::uint32_t>::max() - mesh.positions.size()) return Error{"", "POSITION", "has too many vertices"};
  const VertexRange range{static_cast<std::uint32_t>(mesh.positions.size()), static_cast<std::uint32_t>(count)};
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dvec3 point{p[3 * i], p[3 * i + 1], p[3 * i + 2]};
    underway.finite.push_back(isFinite(point));
    mesh.positions.push_back(isFinite(point) ? point : glm::dvec3(0.0));
    if (!isFinite(point)) ++tally["vertices are not finite numbers; their triangles were left out"];
  }
  mesh.normals.resize(mesh.positions.size(), glm::vec3(0.0f));
  if (normal >= 0) {
    auto normals = readNumbers(model, normal, 3);
    if (!normals) return normals.error();
    const std::vector<double>& n = normals.value();
    if (n.size() != p.size()) return Error{"", "NORMAL", fmt::format("has {} elements where POSITION has {}", n.size() / 3, count)};
    for (std::size_t i = 0; i < count; ++i) mesh.normals[range.first + i] = unitOrZero({n[3 * i], n[3 * i + 1], n[3 * i + 2]});
  }
  auto mapped = addCoordinates(model, accessors.texCoord, range, mesh);
  if (!mapped) return mapped.error();
  auto added = addVisibility(model, accessors, range, underway.visibility);
  if (!added) return added.error();
  underway.shared.emplace(accessors, range);
  return range;
}

/// Corner numbers of triangle `i` in the order of glTF 2.0, 3.7.2.1, so that strips and fans keep their winding.
std::array<std::size_t, 3> corners(int mode, std::size_t i) {
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) return {i, i + 1 + i % 2, i + 2 - i % 2};
  if (mode == TINYGLTF_MODE_TRIANGLE_FAN) return {i + 1, i + 2, 0};
  return {3 * i, 3 * i + 1, 3 * i + 2};
}

Result<std::vector<std::uint32_t>> indicesOf(const tinygltf::Model& model, const tinygltf::Primitive& primitive, std::uint32_t vertices) {
  if (primitive.indices >= 0) return readIndices(model, primitive.indices);
  std::vector<std::uint32_t> all(vertices);
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

Result<Done> addPrimitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive, MeshUnderway& underway, Tally& tally) {
  const bool triangles = primitive.mode == TINYGLTF_MODE_TRIANGLES;
  if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
    return Error{"", "mode", fmt::format("{} is not a glTF 2.0 primitive mode", primitive.mode)};
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
    ++tally["primitives of points or lines were left out"];
    return Done{};
  }
  const VertexAccessors accessors = accessorsOf(model, primitive, underway.texCoord, tally);
  if (accessors.position < 0) {
    ++tally["primitives without positions were left out"];
    return Done{};
  }
  if (primitive.material >= 0 && static_cast<std::size_t>(primitive.material) >= model.materials.size())
    return Error{"", "material", fmt::format("{} does not exist", primitive.material)};
  if (!primitive.targets.empty()) ++tally["primitives with morph targets are undeformed"];
  auto range = addVertices(model, accessors, underway, tally);
  if (!range) return range.error();
  auto indices = indicesOf(model, primitive, range.value().count);
  if (!indices) return indices.error();
  const std::vector<std::uint32_t>& index = indices.value();
  for (const std::uint32_t i : index)
    if (i >= range.value().count) return Error{"", "indices", fmt::format("{} is outside the {} vertices", i, range.value().count)};

  Mesh& mesh = underway.mesh;
  MeshPart part{static_cast<std::uint32_t>(mesh.triangles.size()), 0, primitive.material};
  const std::size_t count = triangles ? index.size() / 3 : index.size() < 3 ? 0 : index.size() - 2;
  if (count > std::numeric_limits<std::uint32_t>::max() - mesh.triangles.size()) return Error{"", "indices", "hold too many triangles"};
  if (triangles && index.size() % 3 != 0) ++tally["primitives end in an incomplete triangle, which was left out"];
  for (std::size_t i = 0; i < count; ++i) {
    glm::uvec3 triangle;
    bool finite = true;
    for (int c = 0; c < 3; ++c) {
      triangle[c] = range.value().first + index[corners(primitive.mode, i)[static_cast<std::size_t>(c)]];
      finite = finite && underway.finite[triangle[c]];
    }
    if (finite) mesh.triangles.push_back(triangle);
  }
  part.triangleCount = static_cast<std::uint32_t>(mesh.triangles.size()) - part.firstTriangle;
  if (part.triangleCount == 0) return Done{};
  underway.lacksNormals |= accessors.normal < 0;
  underway.lacksCoordinates |= accessors.texCoord < 0;
  underway.lacksApertures |= accessors.aperture < 0;
  underway.mixesPackings |= accessors.aperture >= 0 && packingOf(model, accessors.aperture) != underway.visibility.bits;
  underway.lacksTransfer |= accessors.transfer[0] < 0;
  mesh.parts.push_back(part);
  return Done{};
}

/// Texture coordinates are kept where all primitives of a mesh have them.
void finishCoordinates(MeshUnderway& underway, Tally& tally) {
  std::vector<glm::vec2>& coordinates = underway.mesh.textureCoordinates;
  const bool finite = std::all_of(coordinates.begin(), coordinates.end(), [](const glm::vec2& c) { return isFinite(glm::dvec3(c, 0.0)); });
  if (!finite) ++tally["meshes have texture coordinates that are not finite numbers; these were left out"];
  if (!finite || underway.lacksCoordinates || underway.mesh.parts.empty()) coordinates.clear();
}

/// Visibility is kept where all primitives of a mesh have it, in the same packing, and normals beside it.
void finishVisibility(MeshUnderway& underway, Tally& tally) {
  VertexVisibility& visibility = underway.visibility;
  const auto someHave = [&](auto has) {
    return std::any_of(underway.shared.begin(), underway.shared.end(), [&](const auto& entry) { return has(entry.first); });
  };
  const bool apertures = someHave([](const VertexAccessors& a) { return a.aperture >= 0; });
  const bool transfer = someHave([](const VertexAccessors& a) { return a.transfer[0] >= 0; });
  const bool useless = underway.mesh.normals.empty();
  const bool dropsApertures = useless || underway.lacksApertures || underway.mixesPackings;
  const bool dropsTransfer = useless || underway.lacksTransfer;
  if ((apertures && dropsApertures) || (transfer && dropsTransfer))
    ++tally["meshes have visibility on some primitives only, or no normals beside it; it was left out"];
  if (dropsApertures) visibility.apertures.clear();
  if (dropsApertures || visibility.bits == ApertureBits::packed32) visibility.ambient.clear();
  if (dropsApertures) visibility.bits = ApertureBits::packed32;
  if (dropsTransfer) visibility.transfer.clear();
  if (!visibility.apertures.empty() || !visibility.transfer.empty()) underway.mesh.visibility = std::move(visibility);
}

}  // namespace

Result<Mesh> readGltfMesh(const tinygltf::Model& model, int mesh, int texCoord, Tally& tally) {
  const tinygltf::Mesh& source = model.meshes[static_cast<std::size_t>(mesh)];
  MeshUnderway underway;
  underway.mesh.name = source.name;
  underway.texCoord = texCoord;
  for (std::size_t i = 0; i < source.primitives.size(); ++i) {
    auto added = addPrimitive(model, source.primitives[i], underway, tally);
    if (added) continue;
    const Error& error = added.error();
    return Error{"", fmt::format("meshes/{}/primitives/{}", mesh, i), error.place + ": " + error.reason};
  }
  if (underway.lacksNormals) {
    const bool someHave = std::any_of(underway.shared.begin(), underway.shared.end(), [](const auto& e) { return e.first.normal >= 0; });
    if (someHave) ++tally["meshes have normals on some primitives only; these were left out"];
    underway.mesh.normals.clear();
  }
  if (underway.mesh.parts.empty()) underway.mesh.normals.clear();
  finishCoordinates(underway, tally);
  finishVisibility(underway, tally);
  return std::move(underway.mesh);
}

}  // namespace overcast
