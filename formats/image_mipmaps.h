// Mipmapped images: tiled OpenEXR files with all their levels, and numbers about them in the header. What cube maps and height fields are
// stored as.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/image.h"

namespace overcast {

/// Levels of one image and what the header says of it.
struct MipmappedImage {
  std::vector<Image> levels;              ///< level l has max(1, side >> l) pixels a side; down to 1 x 1; the same channels in all
  bool cube = false;                      ///< the OpenEXR attribute `envmap` says cube: six faces one above another (cubePixelDirections)
  std::map<std::string, double> numbers;  ///< attributes of type double
};

/// Levels that an image of this size has.
int mipmapLevels(int width, int height);

/// The bytes of a tiled EXR (ZIP, half floats) with mipmap levels, deterministic. `image` is whole: sides within 1 .. kMaxImageSide, every
/// level as above, values finite and within the range of half floats.
std::vector<std::byte> encodeMipmaps(const MipmappedImage& image);

/// Writes these bytes atomically and returns how many they are.
Result<std::uint64_t> writeMipmaps(const std::filesystem::path& path, const MipmappedImage& image);

/// Reads it back, channels in alphabetical order. Parsed in a sandbox. An Error for what readExr refuses and for files without mipmap
/// levels.
Result<MipmappedImage> readMipmaps(const std::filesystem::path& path);

/// Where OpenEXR keeps the cube-map texel that lies in a direction: for every pixel of one face above another (side x 6 side) its
/// direction, row by row, not normalised. Outermost texels lie on the edges of the cube (formats/shared/cube_map.h). `side` is at least 2.
std::vector<glm::dvec3> cubePixelDirections(int side);

}  // namespace overcast
