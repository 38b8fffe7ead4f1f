// Types and marks of headers that C++ and GLSL both read (runtime/shared_types.h says how to write one).
#ifndef FORMATS_SHARED_TYPES_H
#define FORMATS_SHARED_TYPES_H

#ifdef __cplusplus
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/integer.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#define OVERCAST_SHARED_BEGIN  \
  namespace overcast::shared { \
  using namespace glm;
#define OVERCAST_SHARED_END }
#define OVERCAST_INLINE inline
#define OVERCAST_PRECISE
#else
#define OVERCAST_SHARED_BEGIN
#define OVERCAST_SHARED_END
#define OVERCAST_INLINE
#define OVERCAST_PRECISE precise  // no contraction: shaders that compute the same must agree to the last bit
#endif

#endif
