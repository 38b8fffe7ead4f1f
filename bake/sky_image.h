// Sky image: what the sky radiates in each direction, by the pixels of a picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/image.h"
#include "formats/result.h"

namespace overcast {

/// Latitude and longitude, twice as wide as high, each pixel a cell of them of one radiance. The top row is up (+y); the middle of the
/// picture is +z, the middle of its left half +x, as OpenEXR has it.
struct SkyImage {
  int width = 0;
  int height = 0;
  std::vector<glm::vec3> radiance;  ///< linear, row after row, at least 0
  glm::dvec3 mean{0.0};             ///< over all directions
  std::string hash;                 ///< of the file
};

/// From channels R, G, B or Y alone; negative radiance counts as 0, infinite as the largest half float. An Error without a file for other
/// shapes and channels and for values that are not a number.
Result<SkyImage> makeSkyImage(const Image& image);
Result<SkyImage> readSkyImage(const std::filesystem::path& path);

/// Of the pixel that a unit direction meets.
glm::dvec3 radianceFrom(const SkyImage& sky, const glm::dvec3& direction);

}  // namespace overcast
