// Cube maps: which face a direction meets and where. Faces are ordered and turned as in Vulkan (and glTF viewers): +x, -x, +y, -y, +z, -z.
// Read by C++ and GLSL.
//
// Texels are placed as in OpenEXR's cube maps: the outermost lie on the edges of the cube, so that faces that meet there hold the same
// values and bilinear interpolation within a face is continuous across all edges and corners. Texel (i, j) of a face of `side` x `side`
// is at the coordinates 2 (i, j) / (side - 1) - 1 in [-1, 1]^2.
#ifndef FORMATS_SHARED_CUBE_MAP_H
#define FORMATS_SHARED_CUBE_MAP_H

#include "formats/shared/types.h"

OVERCAST_SHARED_BEGIN

const uint kCubeFaces = 6u;

/// The point of the cube [-1, 1]^3 at `coordinates` of a face: a direction, not normalised.
OVERCAST_INLINE vec3 cubeDirection(uint face, vec2 coordinates) {
  float a = coordinates.x;
  float b = coordinates.y;
  if (face == 0u) return vec3(1.0f, -b, -a);
  if (face == 1u) return vec3(-1.0f, -b, a);
  if (face == 2u) return vec3(a, 1.0f, b);
  if (face == 3u) return vec3(a, -1.0f, -b);
  if (face == 4u) return vec3(a, -b, 1.0f);
  return vec3(-a, -b, -1.0f);
}

/// The face that `direction` (of any length) meets; on edges the first axis of those that tie. The zero vector meets face 0.
OVERCAST_INLINE uint cubeFace(vec3 direction) {
  vec3 size = abs(direction);
  if (size.x >= size.y && size.x >= size.z) return direction.x < 0.0f ? 1u : 0u;
  if (size.y >= size.z) return direction.y < 0.0f ? 3u : 2u;
  return direction.z < 0.0f ? 5u : 4u;
}

/// Coordinates on `face`, which `direction` meets, in [-1, 1]^2; (0, 0) for the zero vector.
OVERCAST_INLINE vec2 cubeCoordinates(uint face, vec3 direction) {
  vec3 size = abs(direction);
  OVERCAST_PRECISE float scale = 1.0f / max(max(size.x, max(size.y, size.z)), 1.0e-37f);
  OVERCAST_PRECISE vec3 d = direction * scale;
  if (face == 0u) return vec2(-d.z, -d.y);
  if (face == 1u) return vec2(d.z, -d.y);
  if (face == 2u) return vec2(d.x, d.z);
  if (face == 3u) return vec2(d.x, -d.z);
  if (face == 4u) return vec2(d.x, -d.y);
  return vec2(-d.x, -d.y);
}

OVERCAST_SHARED_END

#endif
