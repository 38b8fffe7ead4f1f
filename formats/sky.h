// Sky: what a sky dome radiates, as order-2 spherical harmonics (Ramamoorthi and Hanrahan 2001, "An Efficient Representation for Irradiance
// Environment Maps"; Oat and Sander 2006, section 8.4: the sky along an aperture's axis).
#pragma once

#include <array>
#include <filesystem>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "formats/image.h"
#include "formats/result.h"

namespace overcast {

/// Linear radiance sum_i coefficients[i] Y_i(w) from direction w, in the basis of VertexVisibility::transfer (formats/aperture.h). Of a
/// non-negative sky it may be negative in places: order 2 rings beside what is small and bright.
struct SkyHarmonics {
  std::array<glm::vec3, 9> coefficients{};
};

SkyHarmonics uniformSky(const glm::vec3& radiance);

/// The harmonics of a sky image in world space, +y up: each pixel's radiance times the integral of Y_i over its solid angle.
/// - Twice as wide as high: latitude and longitude, each pixel a cell of them. The top row is up; the middle of the picture is +z, the
///   middle of its left half +x (as OpenEXR has it). Integrals in closed form: a uniform image has no coefficient but the first.
/// - Six times as high as wide: the faces of a cube as OpenEXR stores them (cubePixelDirections), texels on the edges shared. Y_i at the
///   pixel's direction times its solid angle, which is in closed form; at least 2 pixels wide.
/// Channels R, G and B, or Y alone; others are ignored. Negative radiance counts as 0, infinite as the largest half float. An Error
/// without a file for other shapes and channels and for values that are not a number.
Result<SkyHarmonics> skyHarmonics(const Image& image);

/// Reads an EXR and projects it. Errors name the file.
Result<SkyHarmonics> readSky(const std::filesystem::path& path);

/// Over all directions.
glm::dvec3 meanRadiance(const SkyHarmonics& sky);

/// Places of the channels that an image's radiance is in: R, G and B, or Y three times; the first is negative where it has neither.
std::array<int, 3> radianceChannels(const Image& image);

/// Radiance that readers of sky images take, 0 to kBrightestSky: what is outside is clamped.
inline constexpr double kBrightestSky = 65504.0;  ///< the largest half float

/// Where the sky image of a scene is whose file lies in `folder`: `skyImage` is Lighting::skyImage. An Error when it leaves the folder.
Result<std::filesystem::path> skyFile(const std::filesystem::path& folder, const std::string& skyImage);

/// The same sky told in axes of which `localFromWorld` (orthogonal, reflections too) makes the local directions: the result at M w is the
/// sky at w.
SkyHarmonics turned(const SkyHarmonics& sky, const glm::dmat3& localFromWorld);

/// Every coefficient times `tint`, channel by channel.
SkyHarmonics tinted(const SkyHarmonics& sky, const glm::vec3& tint);

}  // namespace overcast
