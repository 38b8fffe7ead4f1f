#include "formats/mesh_reader.h"

namespace overcast {

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

}  // namespace overcast
