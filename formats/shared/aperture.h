// Apertures: how a cap of visible directions is packed into 4 or 8 bytes, and the way back (Oat and Sander 2006; DESIGN 4, 5.5). Read by
// C++ and GLSL; the way there is formats/aperture.h.
//
// 4 bytes, as one word, lowest bits first: octahedral x (11 bits), octahedral y (11), radius (10).
// 8 bytes, as two words, lowest bits first: octahedral x (16 bits), octahedral y (16); radius (16), ambient visibility (16).
// In glTF they are four unsigned bytes or four unsigned shorts, in this order (little-endian): a vertex buffer holds the words as they are.
//
// An octahedral coordinate of b bits is code / (2^(b-1) - 1) - 1, so that the axes are exact; the largest code, 2^b - 1, is not used and
// reads as the one below. A radius is linear in its angle: code / largest code * pi/2. Code 0 is shut, the largest one is the whole
// hemisphere. Ambient visibility is code / 65535.
#ifndef FORMATS_SHARED_APERTURE_H
#define FORMATS_SHARED_APERTURE_H

#include "formats/shared/types.h"

OVERCAST_SHARED_BEGIN

const float kApertureWidest = 1.57079633f;  ///< radians: the cap of a whole hemisphere

/// The unit vector at `point` of the octahedral map, [-1, 1]^2, z up (Cigolle et al. 2014, "A Survey of Efficient Representations for
/// Independent Unit Vectors", section 3.1).
OVERCAST_INLINE vec3 octahedralDirection(vec2 point) {
  float z = 1.0f - abs(point.x) - abs(point.y);
  float fold = max(-z, 0.0f);
  float x = point.x >= 0.0f ? point.x - fold : point.x + fold;
  float y = point.y >= 0.0f ? point.y - fold : point.y + fold;
  return normalize(vec3(x, y, z));
}

/// Coordinate of `code`, of which `middle` is the middle one: 2^(b-1) - 1 for b bits.
OVERCAST_INLINE float octahedralCoordinate(uint code, uint middle) {
  return float(min(code, 2u * middle)) / float(middle) - 1.0f;
}

/// Direction (xyz, unit, local space) and radius (w, radians in [0, pi/2]) of the 4-byte packing.
OVERCAST_INLINE vec4 apertureFromWord(uint word) {
  vec2 point = vec2(octahedralCoordinate(word & 2047u, 1023u), octahedralCoordinate((word >> 11) & 2047u, 1023u));
  return vec4(octahedralDirection(point), float(word >> 22) / 1023.0f * kApertureWidest);
}

/// The same of the 8-byte packing.
OVERCAST_INLINE vec4 apertureFromWords(uint first, uint second) {
  vec2 point = vec2(octahedralCoordinate(first & 65535u, 32767u), octahedralCoordinate(first >> 16, 32767u));
  return vec4(octahedralDirection(point), float(second & 65535u) / 65535.0f * kApertureWidest);
}

/// Cosine-weighted visibility of the hemisphere, [0, 1], from the second word of the 8-byte packing.
OVERCAST_INLINE float ambientFromWord(uint second) {
  return float(second >> 16) / 65535.0f;
}

OVERCAST_SHARED_END

#endif
