// `volume`: a signed-distance field on a regular grid over a padded box, stored as OpenVDB (DESIGN 4, 5.1).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/mesh.h"
#include "formats/result.h"
#include "formats/sandbox.h"

namespace overcast {

/// Signed distances at the points origin + voxelSize * (i, j, k), x fastest: distance[i + size.x * (j + size.y * k)].
/// Negative inside, positive outside, in the units of the mesh's local space.
struct Volume {
  glm::ivec3 size{0};      ///< samples along each axis, each at least 2
  glm::dvec3 origin{0.0};  ///< position of sample (0, 0, 0)
  double voxelSize = 0.0;  ///< spacing of samples, the same along all axes
  std::vector<float> distance;
  std::string signMethod;  ///< how inside was decided, e.g. "signed-crossings" or "winding-number" (bake/sign.h)
};

inline constexpr int kVolumeVersion = 1;     ///< version of the .vdb layout, stored as metadata `overcast_version`
inline constexpr int kMaxVolumeSide = 1024;  ///< larger grids are refused before anything is allocated

/// The box spanned by the outermost samples.
Box bounds(const Volume& volume);

/// Trilinear interpolation at `point` (local space). Outside the box of samples: with q the closest point of the box,
/// sqrt(|p - q|^2 + max(phi(q), 0)^2), the lower bound of DESIGN 5.1 (continuous at the box where phi(q) >= 0).
double sampleVolume(const Volume& volume, const glm::dvec3& point);

/// An upper bound of |grad| over the trilinear interpolant: for each cell the largest edge difference along every axis, combined
/// in the Euclidean norm. At most sqrt(3) for exact distances; what the composite's culling margin uses (DESIGN 5.2).
double lipschitzBound(const Volume& volume);

/// Precision of the values on disk.
enum class VolumeBits { automatic, half, single };

/// Writes one dense float grid named `distance`, class level set, metadata overcast_version and overcast_sign_method, UUID made from the
/// content: the same volume gives the same bytes. `automatic` takes half floats unless a distance would overflow them or the voxel size is
/// so small that a thousandth of a voxel would be subnormal; then single floats. Returns the bytes on disk.
Result<std::uint64_t> writeVolume(const std::filesystem::path& path, const Volume& volume, VolumeBits bits = VolumeBits::automatic);

/// Reads what writeVolume wrote (and any .vdb with a dense float or half grid `distance`). Parsed in a sandbox; size, transform and
/// finiteness are checked before anything large is allocated.
Result<Volume> readVolume(const std::filesystem::path& path, const SandboxLimits& limits = {});

}  // namespace overcast
