// `volume`: a signed-distance field on a regular grid over a padded box, stored as OpenVDB (DESIGN 4, 5.1).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/inside.h"
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
  Inside inside = Inside::unstated;
  double sheetThickness = 0.0;  ///< local units; of the sheets that have two sides instead of an inside (bake/sheets.h), 0 without any
  std::string signMethod;       ///< how inside was decided, e.g. "signed-crossings" or "winding-number" (bake/sign.h)
  float step = 0.0f;  ///< positive: every distance is q * step, q whole, -127 .. 127 (VolumeBits::snorm8); 0: distances are any floats
};

inline constexpr int kVolumeVersion = 1;     ///< version of the .vdb layout, stored as metadata `overcast_version`
inline constexpr int kMaxVolumeSide = 1024;  ///< larger grids are refused before anything is allocated

/// Place of sample (i, j, k) in `distance`.
std::size_t sampleIndex(const Volume& volume, int i, int j, int k);

/// Every side within 2 .. kMaxVolumeSide, as many distances as these say, voxel size positive and finite, origin and distances finite, and
/// `step`, where it is not 0, positive and what it says.
bool isWhole(const Volume& volume);

/// The box spanned by the outermost samples.
Box bounds(const Volume& volume);

/// Trilinear interpolation at `point` (local space, finite). Outside the box of samples, with q the closest point of the box and g the gap
/// |p - q|: sqrt(g^2 + phi(q)^2 + 2 g phi(q) c) where phi(q) >= 0. c is the slope of phi at q towards p, the difference over one sample
/// (along the longest component of p - q) inwards, clamped to 0 .. 1: the closest point lies at phi from q against the gradient, so that
/// above a plane the distance is exact. c = 0 and c = 1 are the lower and the upper bound of DESIGN 5.1. g + phi(q) where phi(q) < 0 (the
/// inside of an open mesh may reach the border). Continuous everywhere.
double sampleVolume(const Volume& volume, const glm::dvec3& point);

/// A Lipschitz constant over all of space of sampleVolume's lower bound: sampleVolume itself within the box, c = 0 beyond it, where c's own
/// slope has no useful bound. The composite's culling margin uses it (DESIGN 5.2); the upper bound, c = 1, has sqrt(1 + L^2).
/// L is the largest norm of the gradient over all cells, at most sqrt(3) for exact distances. Outside the box the gradient joins 1 along p
/// - q with the one at q, at a right angle: max(1, L) suffices where phi(q) >= 0, sqrt(1 + L^2) is needed when a sample of the border is
/// negative. Never below 1.
double lipschitzBound(const Volume& volume);

/// Precision of the values, on disk and on the device.
/// `snorm8` is 8-bit signed normalised: distances are whole multiples, -127 .. 127, of a step of the volume's own, the smallest of 4
/// significant bits with which the largest distance is within reach: no distance is clamped, and none is off by more than half a step,
/// 1/254 to 1/225 of the largest. The scale is linear so that what the device filters, the stored numbers, is the distance everywhere.
enum class VolumeBits { automatic, snorm8, half, single };

/// What `automatic` means for this volume (any other value comes back as it is): snorm8 where it is that already (its step is positive),
/// else half floats unless a distance would overflow them, or the voxel size is so small that their smallest step (2^-24) exceeds a
/// thousandth of a voxel.
VolumeBits chooseBits(const Volume& volume, VolumeBits bits = VolumeBits::automatic);

/// Bits of a stored value, 8, 16 or 32, and how it is called, "snorm8", "half" or "single". `bits` is not automatic.
int bitCount(VolumeBits bits);
const char* name(VolumeBits bits);

/// The volume as readVolume gives it back after writeVolume: distances rounded to the chosen precision and `step` as it says, all else
/// untouched. Errors of a baked volume are measured on this. Distances that half floats cannot hold become infinite.
Volume asStored(Volume volume, VolumeBits bits = VolumeBits::automatic);

/// The bytes of the file: one dense float grid named `distance`, class level set, with metadata overcast_version, overcast_sign_method,
/// overcast_size and, where they are stated, overcast_inside and overcast_sheet_thickness, UUID made from the content: the same volume
/// gives the same bytes, for any thread count. snorm8 adds overcast_step; the grid then holds the distances as any reader expects them,
/// deflated to about a byte each. An Error without a file when `bits` is half and a distance overflows it. `volume` is whole (isWhole).
Result<std::vector<std::byte>> encodeVolume(const Volume& volume, VolumeBits bits = VolumeBits::automatic);

/// Writes these bytes atomically and returns how many they are; an Error also when the disk fails.
Result<std::uint64_t> writeVolume(const std::filesystem::path& path, const Volume& volume, VolumeBits bits = VolumeBits::automatic);

/// Reads what writeVolume wrote, bit for bit, and the float grid `distance` of any other .vdb over the box of its active voxels (inactive
/// ones within give the tree's value). Parsed in a sandbox. An Error when there is no such grid, its transform is not a positive uniform
/// scale and a translation, a side is outside 2 .. kMaxVolumeSide, a value is not finite or no multiple of overcast_step, or its
/// overcast_version is a later one.
Result<Volume> readVolume(const std::filesystem::path& path, const SandboxLimits& limits = {});

}  // namespace overcast
