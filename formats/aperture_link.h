// What a mesh says of its aperture map: the glTF extension OVERCAST_aperture on the mesh. Schema:
// formats/schema/OVERCAST_aperture.schema.json
#pragma once

#include <cstdint>
#include <string>

namespace overcast {

inline constexpr int kApertureLinkVersion = 1;

/// The map lies over Mesh::textureCoordinates. Root mean squares over the surface of what is interpolated between texels against what is
/// visible there; negative: not measured.
struct ApertureLink {
  std::string uri;               ///< file beside the glTF (formats/aperture_map.h)
  std::string contentHash;       ///< of that file (formats/files.h)
  std::uint64_t bytes = 0;       ///< of that file
  int texCoord = 0;              ///< which set of the file's, n of TEXCOORD_n; 0 in memory, where a mesh has one set
  bool sceneOccludes = false;    ///< all objects at rest hide the sky; else the mesh alone
  double radiusError = -1.0;     ///< radians
  double ambientError = -1.0;    ///< of the cosine-weighted visibility
  double directionError = -1.0;  ///< radians, over points that see something
};

}  // namespace overcast
