// Atlas: all local volumes in two 3D images, one of floats and one of 8 bits (there is no descriptor indexing on lavapipe).
//
// Floats are stored in local voxels (distance / voxelSize): half floats are then best near the surface at any scale. Volumes of 8 bits
// (VolumeBits::snorm8) are stored as they are, R8_SNORM: a stored 1 is 127 steps, and one byte a sample is all they take. Sampling is
// clamped between the centres of a volume's first and last samples, where trilinear weights of the next volume are zero, so volumes lie
// side by side without padding. The extent's sides are powers of two: dividing a texel coordinate by them is exact, so that zero stays
// zero.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "formats/result.h"
#include "formats/volume.h"
#include "runtime/vulkan/device.h"
#include "runtime/vulkan/resources.h"

namespace overcast {

/// Bits of the floats.
enum class AtlasBits { half, single };

/// What an atlas may take.
struct AtlasLimits {
  std::uint32_t maxSide = 0;   ///< texels
  std::uint64_t maxBytes = 0;  ///< of the whole image
  std::uint32_t texelBytes = 2;
};

/// Where everything goes.
struct AtlasLayout {
  glm::ivec3 extent{1};             ///< powers of two
  std::vector<glm::ivec3> offsets;  ///< first texel of every volume, in the order given
};

/// Packs boxes of `sizes` texels into layers of rows, the deepest first, choosing the width and height that need the fewest texels.
/// The same sizes give the same layout. No boxes: an extent of one texel. An Error names what does not fit and by how much.
Result<AtlasLayout> packAtlas(std::span<const glm::ivec3> sizes, const AtlasLimits& limits);

/// One packed volume, as the composite needs it.
struct AtlasEntry {
  glm::ivec3 offset{0};       ///< first texel
  glm::ivec3 size{0};         ///< samples
  glm::dvec3 origin{0.0};     ///< position of the first sample along the volume's axes
  double voxelSize = 0.0;     ///< local units
  float lipschitz = 1.0f;     ///< lipschitzBound() of the values as stored
  float lowestBorder = 0.0f;  ///< smallest stored value on the border of the box in local voxels, or 0 when that is positive
  float highest = 0.0f;       ///< largest stored value, local voxels
  bool snorm8 = false;        ///< in the image of 8 bits
  double unit = 1.0;          ///< local voxels that a stored 1 means
  glm::dmat3 axes{1.0};       ///< local from the volume's axes, orthonormal: of a volume that was baked they are those of local space
};

struct Atlas {
  GpuImage image;                      ///< R16F or R32F, always in the layout of kComputeSample; one texel where there is nothing to hold
  GpuImage snorm8;                     ///< R8_SNORM, the same
  VkSampler sampler = VK_NULL_HANDLE;  ///< trilinear, clamped to the edge
  std::vector<AtlasEntry> entries;     ///< one for each volume, in the order given
};

/// Packs and uploads; waits. `bits` is for volumes whose step is 0; values beyond the range of half floats are clamped to it. An Error when
/// the device cannot hold the atlas or does not filter its formats.
Result<Atlas> makeAtlas(const Device& device, std::span<const Volume* const> volumes, AtlasBits bits = AtlasBits::half);
void destroyAtlas(const Device& device, Atlas& atlas);

}  // namespace overcast
