// Constant: the same sky visibility everywhere, the least that anything else must beat. Read by C++ and GLSL.
#ifndef RUNTIME_PASSES_CONSTANT_CONSTANT_H
#define RUNTIME_PASSES_CONSTANT_CONSTANT_H

#include "runtime/shared_types.h"

OVERCAST_SHARED_BEGIN

struct ConstantPush {
  vec4 sky;  // 0: rgb: linear radiance of the sky; w: visibility
};

OVERCAST_SHARED_END

#endif
