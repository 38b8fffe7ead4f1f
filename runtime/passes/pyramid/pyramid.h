// Pyramid: low-passed copies of phi for the far taps (DESIGN 5.3; Evans 2006, 9.6). Read by C++ and GLSL.
//
// Level l has sides ceil(N / 2^l); its voxel (i, j, k) has its centre at 2^l (i + 0.5, ...) voxels of level 0 from the volume's corner.
// Each level is the one below filtered with [1 3 3 1] / 8 along every axis and decimated by two. A filter's variance adds up:
// 3/4 voxel^2 of its own level each, 4^j times that in voxels of level 0, so sigma_l^2 = (4^l - 1) / 4 voxels^2, width proportional to 2^l.
// The weights are the B-spline of order three: iterated, they tend to a bell, and no power of two of the grid survives as a pattern.
// Outside the volume the border voxel counts as its own neighbour: constants stay exact everywhere, linear fields wherever the kernel's
// 4 voxels lie inside. All levels are in voxels of level 0.
#ifndef RUNTIME_PASSES_PYRAMID_PYRAMID_H
#define RUNTIME_PASSES_PYRAMID_PYRAMID_H

#include "runtime/shared_types.h"

OVERCAST_SHARED_BEGIN

const int kMaxPyramidLevels = 8;  ///< level 0 included

/// A trilinear fetch this far from the output's centre, on either side of it along every axis, takes two voxels with weights 1 : 3 or 3 :
/// 1; the mean of the 8 fetches is the filter. Exact with filter weights of 8 bits (0.75 = 192 / 256).
const float kPyramidOffset = 0.75f;

struct PyramidPush {
  ivec4 size;  //  0: xyz: voxels of the level to write
  vec4 texel;  // 16: xyz: 1 / voxels of the level below
};

/// Texture coordinate, in the level below, of fetch `corner` (0 to 7) for output voxel `voxel`.
OVERCAST_INLINE vec3 pyramidFetch(ivec3 voxel, int corner, vec3 texel) {
  vec3 side = vec3(float(corner & 1), float((corner >> 1) & 1), float(corner >> 2)) * 2.0f - 1.0f;
  return (2.0f * vec3(voxel) + 1.0f + kPyramidOffset * side) * texel;
}

/// Standard deviation of level `level`'s filter, in voxels of level 0.
OVERCAST_INLINE float pyramidSigma(int level) {
  return sqrt((exp2(2.0f * float(level)) - 1.0f) / 4.0f);
}

OVERCAST_SHARED_END

#endif
