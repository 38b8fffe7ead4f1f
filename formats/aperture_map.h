// `aperture` per texel: what a surface sees of the sky as spherical caps in a texture over the mesh's texture coordinates (Oat and Sander
// 2006, section 8.3; DESIGN 4), with mipmap levels. Stored as mipmapped OpenEXR.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "formats/aperture.h"
#include "formats/aperture_link.h"
#include "formats/image_mipmaps.h"
#include "formats/result.h"

namespace overcast {

/// What the surface under one texel sees.
struct ApertureTexel {
  Aperture aperture;     ///< local space of the mesh
  float ambient = 0.0f;  ///< cosine-weighted visibility, as VertexVisibility::ambient, [0, 1]
  float coverage =
      0.0f;  ///< share of the texel that lies on the surface, [0, 1]; 0: filled from texels nearby, so that filters may read it
};

/// Texel (i, j) of a level is levels[l][i + max(1, size.x >> l) * j] and covers u in [i, i + 1] / width and v in [j, j + 1] / height of the
/// texture coordinates, v down as in glTF. Beyond the border texels repeat (clamp to edge).
struct ApertureMap {
  glm::ivec2 size{0};
  std::vector<std::vector<ApertureTexel>> levels;  ///< mipmapLevels(size) of them, the last a single texel
  int usableLevels =
      1;  ///< how many levels, from the finest, a renderer may read: in coarser ones texels mix what lies apart on the surface
};

inline constexpr int kApertureMapVersion = 1;         ///< of the .exr layout, attribute `overcast_version`
inline constexpr int kLargestApertureMapSide = 4096;  ///< texels; larger ones are refused

/// Sizes within 1 .. kLargestApertureMapSide, all levels complete, directions unit, radii within [0, pi/2], ambient and coverage within
/// [0, 1], 1 .. all levels usable.
bool isWhole(const ApertureMap& map);

glm::ivec2 levelSize(const ApertureMap& map, int level);

/// Fills levels 1 and up from level 0, which is complete. A coarse texel is the mean of the fine texels under it (of any share of theirs,
/// where a side is odd) weighted by area and coverage, so that texels off the surface do not bleed; where none is on the surface, by area
/// alone. What is averaged are amounts of light: the solid angle that is visible, the visible directions weighted by it, and ambient
/// visibility.
void buildLevels(ApertureMap& map);

/// Bilinear, as the runtime samples `level`: components of direction (normalised after), radius and ambient visibility; clamps to edges.
/// `level` is one of the map's, `coordinate` finite.
ApertureTexel sampleApertureMap(const ApertureMap& map, const glm::dvec2& coordinate, int level = 0);

/// The map as readApertureMap gives it back after writeApertureMap: numbers rounded to half floats. Errors are measured on this.
ApertureMap asStored(ApertureMap map);

/// As the file's image and back. Channels `direction.X`, `.Y`, `.Z`; `radius` in units of pi/2, so that the whole hemisphere is exact;
/// `ambient`; `coverage`; attributes overcast_version and overcast_usable_levels. The way back is an Error that names `file` when a channel
/// or number is missing or out of range, or the version is a later one; directions are normalised.
MipmappedImage imageOf(const ApertureMap& map);
Result<ApertureMap> apertureMapOf(const MipmappedImage& image, const std::string& file);

/// The bytes of the file, deterministic. `map` is whole.
std::vector<std::byte> encodeApertureMap(const ApertureMap& map);

/// Writes these bytes atomically and returns how many they are.
Result<std::uint64_t> writeApertureMap(const std::filesystem::path& path, const ApertureMap& map);

/// Reads what writeApertureMap wrote. Parsed in a sandbox. Errors as apertureMapOf and readMipmaps.
Result<ApertureMap> readApertureMap(const std::filesystem::path& path);

/// Reads what `link` names, relative to `folder`. An Error when the file lies outside the folder, is missing or broken, or its content hash
/// is not the stored one.
Result<ApertureMap> readApertureMap(const std::filesystem::path& folder, const ApertureLink& link);

}  // namespace overcast
