// Sky image: what the sky radiates in each direction, by the pixels of a picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "formats/image.h"
#include "formats/result.h"

namespace overcast {

/// Latitude and longitude or the faces of a cube, in the layouts of formats/sky.h; each pixel has one radiance.
struct SkyImage {
  int width = 0;
  int height = 0;                   ///< six times the width: a cube
  std::vector<glm::vec3> radiance;  ///< linear, at least 0: row after row; of a cube by texelIndex (formats/radius.h)
  glm::dvec3 mean{0.0};             ///< over all directions
  std::string hash;                 ///< of the file
};

/// What skyHarmonics (formats/sky.h) takes and refuses.
Result<SkyImage> makeSkyImage(const Image& image);
Result<SkyImage> readSkyImage(const std::filesystem::path& path);

/// Of the pixel that a unit direction meets.
glm::dvec3 radianceFrom(const SkyImage& sky, const glm::dvec3& direction);

}  // namespace overcast
