#include "formats/mesh_reader.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "formats/mesh_triangulate.h"

namespace overcast {
namespace {

constexpr std::uint64_t kMaxTriangles = 200'000'000;

}  // namespace

bool isFinite(const glm::dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

std::uint32_t toCorner(std::int64_t index) {
  return index < 0 || index >= kBadIndex ? kBadIndex : static_cast<std::uint32_t>(index);
}

void endFace(RawMesh& mesh) {
  const std::uint64_t begin = mesh.faceEnds.empty() ? 0 : mesh.faceEnds.back();
  if (mesh.corners.size() - begin < 3) {
    mesh.corners.resize(begin);
    ++mesh.shortFaces;
  } else {
    mesh.faceEnds.push_back(mesh.corners.size());
  }
}

Result<MeshFile> finishMesh(RawMesh raw) {
  MeshFile file;
  MeshReadReport& report = file.report;
  report.polygons = raw.faceEnds.size() + raw.shortFaces;
  report.shortFaces = raw.shortFaces;
  if (raw.positions.size() >= kBadIndex) return Error{"", "", "has more vertices than 32-bit indices can name"};
  std::uint64_t begin = 0;
  for (const std::uint64_t end : raw.faceEnds) {
    const std::span<const std::uint32_t> face(raw.corners.data() + begin, end - begin);
    begin = end;
    if (!std::all_of(face.begin(), face.end(), [&](std::uint32_t i) { return i < raw.positions.size(); })) {
      ++report.badIndexFaces;
    } else if (!std::all_of(face.begin(), face.end(), [&](std::uint32_t i) { return isFinite(raw.positions[i]); })) {
      ++report.nonFiniteFaces;
    } else {
      if (face.size() > 3) ++report.triangulated;
      triangulate(raw.positions, face, file.mesh.triangles);
    }
    if (file.mesh.triangles.size() > kMaxTriangles) return Error{"", "", fmt::format("has more than {} triangles", kMaxTriangles)};
  }
  for (glm::dvec3& position : raw.positions) {
    if (isFinite(position)) continue;
    ++report.nonFiniteVertices;
    position = glm::dvec3(0.0);
  }
  file.mesh.positions = std::move(raw.positions);
  file.mesh.textureCoordinates = std::move(raw.textureCoordinates);
  return file;
}

}  // namespace overcast
