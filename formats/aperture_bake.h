// What a mesh says of the bake of its apertures: the glTF extension OVERCAST_aperture_bake on the mesh. Schema:
// formats/schema/OVERCAST_aperture_bake.schema.json
#pragma once

#include <cstdint>

namespace overcast {

inline constexpr int kApertureBakeVersion = 1;

/// How the apertures at a mesh's vertices were baked, and how far they are from the truth: root mean squares over the surface of what is
/// interpolated between vertices against what `rays` rays see there, at `samples` points that `seed` draws (bake/aperture.h).
struct ApertureBake {
  std::uint32_t rays = 256;     ///< of each point
  bool sceneOccludes = false;   ///< all objects at rest hide the sky; else the mesh alone
  bool fitted = false;          ///< values were fitted to the surface, else taken at the vertices
  std::uint64_t samples = 0;    ///< points that were drawn; 0: not measured, and the errors mean nothing
  std::uint64_t seed = 0;       ///< of these points
  double radiusError = 0.0;     ///< radians
  double ambientError = 0.0;    ///< of the cosine-weighted visibility
  double directionError = 0.0;  ///< radians, over points that see something
};

}  // namespace overcast
