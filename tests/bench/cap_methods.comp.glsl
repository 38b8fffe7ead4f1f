// One thread per pair of caps: OVERCAST_METHOD, OVERCAST_REPEATS times (their sum) for the bench.
#version 460
#include "tests/bench/cap_methods.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) readonly buffer Pairs { CapPair pairs[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Results { float results[]; };

void main() {
  if (gl_GlobalInvocationID.x >= pairs.length()) return;
  CapPair caps = pairs[gl_GlobalInvocationID.x];
  float sum = evaluatePair(OVERCAST_METHOD, caps);
  for (int i = 1; i < OVERCAST_REPEATS; ++i) {
    caps.normal.w += 1.0e-7;
    sum += evaluatePair(OVERCAST_METHOD, caps);
  }
  results[gl_GlobalInvocationID.x] = sum;
}
