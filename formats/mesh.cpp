#include "formats/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <span>
#include <string_view>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "formats/files.h"
#include "formats/mesh_reader.h"

namespace overcast {
namespace {

using Parser = Result<RawMesh> (*)(std::string_view);

/// The reader for the extension of `path`, or null.
Parser parserOf(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (extension == ".obj") return parseObj;
  if (extension == ".ply") return parsePly;
  if (extension == ".stl") return parseStl;
  if (extension == ".off") return parseOff;
  return nullptr;
}

/// What crosses the pipe: this, then the positions, the triangles and the texture coordinates.
struct PackedHeader {
  std::uint64_t positions = 0;
  std::uint64_t triangles = 0;
  std::uint64_t coordinates = 0;
  MeshReadReport report;
};

std::vector<std::byte> packed(const MeshFile& file) {
  const PackedHeader header{file.mesh.positions.size(), file.mesh.triangles.size(), file.mesh.textureCoordinates.size(), file.report};
  const std::span<const std::byte> parts[] = {std::as_bytes(std::span(&header, 1)), std::as_bytes(std::span(file.mesh.positions)),
                                              std::as_bytes(std::span(file.mesh.triangles)),
                                              std::as_bytes(std::span(file.mesh.textureCoordinates))};
  std::vector<std::byte> bytes;
  bytes.reserve(parts[0].size() + parts[1].size() + parts[2].size() + parts[3].size());
  for (const auto& part : parts) bytes.insert(bytes.end(), part.begin(), part.end());
  return bytes;
}

/// Unpacks what a child sent that may have been led astray by the file it read: nothing is believed unchecked.
Result<MeshFile> unpacked(const std::vector<std::byte>& bytes) {
  const Error nonsense{"", "", "reader answered nonsense"};
  PackedHeader header;
  if (bytes.size() < sizeof header) return nonsense;
  std::memcpy(&header, bytes.data(), sizeof header);
  const std::size_t body = bytes.size() - sizeof header;
  if (header.positions > body / sizeof(glm::dvec3) || header.triangles > body / sizeof(glm::uvec3) ||
      (header.coordinates != 0 && header.coordinates != header.positions) ||
      header.positions * sizeof(glm::dvec3) + header.triangles * sizeof(glm::uvec3) + header.coordinates * sizeof(glm::vec2) != body) {
    return nonsense;
  }
  MeshFile file;
  file.report = header.report;
  file.mesh.positions.resize(header.positions);
  file.mesh.triangles.resize(header.triangles);
  const std::byte* at = bytes.data() + sizeof header;
  std::copy_n(at, header.positions * sizeof(glm::dvec3), reinterpret_cast<std::byte*>(file.mesh.positions.data()));
  at += header.positions * sizeof(glm::dvec3);
  std::copy_n(at, header.triangles * sizeof(glm::uvec3), reinterpret_cast<std::byte*>(file.mesh.triangles.data()));
  at += header.triangles * sizeof(glm::uvec3);
  file.mesh.textureCoordinates.resize(header.coordinates);
  std::copy_n(at, header.coordinates * sizeof(glm::vec2), reinterpret_cast<std::byte*>(file.mesh.textureCoordinates.data()));
  const auto inRange = [&](const glm::uvec3& t) { return std::max({t.x, t.y, t.z}) < header.positions; };
  if (!std::all_of(file.mesh.triangles.begin(), file.mesh.triangles.end(), inRange)) return nonsense;
  if (!std::all_of(file.mesh.positions.begin(), file.mesh.positions.end(), isFinite)) return nonsense;
  const auto isPlace = [](const glm::vec2& c) { return isFinite(glm::dvec3(c, 0.0)); };
  if (!std::all_of(file.mesh.textureCoordinates.begin(), file.mesh.textureCoordinates.end(), isPlace)) return nonsense;
  return file;
}

/// Why a file without a triangle has none.
std::string nothingUsable(const MeshReadReport& report) {
  if (report.polygons == 0) return "holds no faces";
  return fmt::format("holds no usable triangle: of {} faces {} have bad indices, {} coordinates that are not finite, {} too few corners",
                     report.polygons, report.badIndexFaces, report.nonFiniteFaces, report.shortFaces);
}

}  // namespace

bool isEmpty(const Box& box) {
  return box.min.x > box.max.x || box.min.y > box.max.y || box.min.z > box.max.z;
}

glm::dvec3 centre(const Box& box) {
  return box.min * 0.5 + box.max * 0.5;
}

glm::dvec3 extent(const Box& box) {
  return isEmpty(box) ? glm::dvec3(0.0) : box.max - box.min;
}

double diagonal(const Box& box) {
  const glm::dvec3 size = extent(box);
  return std::hypot(size.x, size.y, size.z);
}

void include(Box& box, const glm::dvec3& point) {
  box.min = glm::min(box.min, point);
  box.max = glm::max(box.max, point);
}

void include(Box& box, const Box& other) {
  if (isEmpty(other)) return;
  include(box, other.min);
  include(box, other.max);
}

Box bounds(const Mesh& mesh) {
  Box box;
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int corner = 0; corner < 3; ++corner) include(box, mesh.positions[triangle[corner]]);
  }
  return box;
}

bool isMeshFile(const std::filesystem::path& path) {
  return parserOf(path) != nullptr;
}

Result<MeshFile> readMesh(const std::filesystem::path& path, const SandboxLimits& limits) {
  const auto named = [&](Error error) {
    error.file = path.string();
    return error;
  };
  const Parser parse = parserOf(path);
  if (parse == nullptr) return named({"", "", "is not a mesh file (.obj, .ply, .stl, .off)"});
  const Result<std::vector<std::byte>> answer = runSandboxed(path, limits, [&]() -> Result<std::vector<std::byte>> {
    Result<std::vector<std::byte>> bytes = readFile(path);
    if (!bytes) return bytes.error();
    Result<RawMesh> raw = parse({reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size()});
    if (!raw) return raw.error();
    bytes = std::vector<std::byte>();  // the memory limit is for the largest step, not for the sum of all
    const Result<MeshFile> file = finishMesh(std::move(raw).value());
    if (!file) return file.error();
    return packed(file.value());
  });
  if (!answer) return named(answer.error());
  Result<MeshFile> file = unpacked(answer.value());
  if (!file) return named(file.error());
  Mesh& mesh = file.value().mesh;
  if (mesh.triangles.empty()) return named({"", "", nothingUsable(file.value().report)});
  mesh.name = path.stem().string();
  mesh.parts.push_back({0, static_cast<std::uint32_t>(mesh.triangles.size()), -1});
  return file;
}

Result<Done> writeOff(const std::filesystem::path& path, const Mesh& mesh) {
  std::string text = fmt::format("OFF\n{} {} 0\n", mesh.positions.size(), mesh.triangles.size());
  for (const glm::dvec3& p : mesh.positions) fmt::format_to(std::back_inserter(text), "{:.17g} {:.17g} {:.17g}\n", p.x, p.y, p.z);
  for (const glm::uvec3& t : mesh.triangles) fmt::format_to(std::back_inserter(text), "3 {} {} {}\n", t.x, t.y, t.z);
  return writeFileAtomically(path, std::string_view(text));
}

}  // namespace overcast
