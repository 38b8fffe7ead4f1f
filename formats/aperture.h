// `aperture`: what a surface point sees of the sky as a spherical cap (Oat and Sander 2006, section 8.3; DESIGN 4, 5.5), per vertex of a
// mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace overcast {

/// The cap that stands for the directions in which nothing is hit: as large as they are, about their mean.
struct Aperture {
  glm::vec3 direction{0.0f, 1.0f, 0.0f};  ///< unit vector, local space; the normal where nothing is visible
  float radius = 0.0f;                    ///< radians, 0 (shut) to pi/2 (the whole hemisphere)
};

/// How apertures are stored (formats/shared/aperture.h): in 4 bytes each (direction within 0.1 degrees, radius within 0.0008 rad), or in 8
/// for lights as small as the sun (0.004 degrees, 0.000012 rad, and ambient visibility within 0.000008).
enum class ApertureBits : std::uint8_t { packed32, packed64 };

/// Visibility at the vertices of a mesh. Each vector is empty or holds one entry per position. Stored as the glTF attributes `_APERTURE`
/// and
/// `_TRANSFER_0` to `_TRANSFER_2`.
struct VertexVisibility {
  ApertureBits bits = ApertureBits::packed32;
  std::vector<Aperture> apertures;
  /// Cosine-weighted visibility, (1/pi) times the integral of V cos over the hemisphere, [0, 1]: 1 minus ambient occlusion. Stored with the
  /// apertures by packed64, which needs it; not stored by packed32.
  std::vector<float> ambient;
  /// Order-2 spherical harmonics of the cosine-weighted visibility, (1/pi) times the integral of V cos Y_i over the hemisphere, local
  /// space, i = l (l + 1) + m, Y_i real and orthonormal (Y_0 = 1 / sqrt(4 pi), Y_1 = sqrt(3 / 4 pi) y, then z, x; Sloan 2008, "Stupid
  /// Spherical Harmonics Tricks", appendix A2). Under a sky of radiance sum_i L_i Y_i the surface reflects albedo * sum_i L_i transfer_i.
  std::vector<std::array<float, 9>> transfer;
};

/// Why `visibility` cannot belong to a mesh of that many positions, for messages; empty when it can.
std::string brokenVisibility(const VertexVisibility& visibility, std::size_t positions);

/// As the glTF file gives it back: apertures and ambient visibility rounded to their codes, ambient dropped where it is not stored.
VertexVisibility asStored(VertexVisibility visibility);

/// Radius of the cap as large as the share `visible` of the hemisphere's solid angle, [0, 1] (which is clamped): 2 asin(sqrt(visible / 2)).
float capRadius(double visible);

/// The codes of formats/shared/aperture.h, of which these are the inverse: the octahedral code whose direction is nearest (of the nine
/// around the rounded one), radius and ambient visibility rounded to nearest. `direction` need not be of unit length but has one.
std::uint32_t packAperture32(const Aperture& aperture);
std::uint64_t packAperture64(const Aperture& aperture, float ambient);
Aperture unpackAperture32(std::uint32_t code);
Aperture unpackAperture64(std::uint64_t code);
float unpackAmbient64(std::uint64_t code);

}  // namespace overcast
