// What a header needs so that C++ (GLM) and GLSL both read it: put OVERCAST_SHARED_BEGIN after the includes and OVERCAST_SHARED_END at the
// end, mark functions OVERCAST_INLINE, and the same text gives the types and formulas to both, in C++ in namespace overcast::shared.
//
//   #ifndef RUNTIME_PASSES_X_X_H
//   #define RUNTIME_PASSES_X_X_H
//   #include "runtime/shared_types.h"
//   OVERCAST_SHARED_BEGIN
//   struct XPush { mat4 clipFromWorld; vec4 colour; };          // vec4, never vec3, before anything else: std430 equals C++
//   OVERCAST_INLINE float f(float x) { return max(x, 0.0f); }   // 1.0f; no bool in structs, no swizzles, no out parameters
//   OVERCAST_SHARED_END
//   #endif
//
// In C++ assert sizes and offsets once, in the pass's .cpp. vec2, vec3, vec4, ivec, uvec, mat3, mat4, uint and the usual functions are
// there.
#ifndef RUNTIME_SHARED_TYPES_H
#define RUNTIME_SHARED_TYPES_H

#include "formats/shared/types.h"

#endif
