// All ways to intersect two caps by number, for tests and the bench. Read by C++ and GLSL.
#ifndef TESTS_BENCH_CAP_METHODS_H
#define TESTS_BENCH_CAP_METHODS_H

#include "runtime/passes/aperture/caps.h"
#include "tests/bench/textbook_caps.h"

OVERCAST_SHARED_BEGIN

struct CapPair {
  vec4 normal;  //  0: xyz: of the surface; w: distance of the axes
  vec4 first;   // 16: xyz: axis; w: radius
  vec4 second;  // 32
};

const int kMethodNaive = 0;
const int kMethodClamped = 1;
const int kMethodStable = 2;
const int kMethodSmoothstep = 3;
const int kMethodOurs = 4;
const int kMethodCosine = 5;  ///< not an area: the cosine integral over it

OVERCAST_INLINE float evaluatePair(int method, CapPair caps) {
  float r0 = caps.first.w;
  float r1 = caps.second.w;
  float d = caps.normal.w;
  if (method == kMethodNaive) return naiveIntersection(r0, r1, d);
  if (method == kMethodClamped) return clampedIntersection(r0, r1, d);
  if (method == kMethodSmoothstep) return capIntersectionSmoothstep(r0, r1, d);
  if (method == kMethodOurs) return capIntersectionFast(r0, r1, d);
  float area = capIntersection(r0, r1, d);
  if (method == kMethodStable) return area;
  return capIntersectionCosine(vec3(caps.normal), vec3(caps.first), r0, vec3(caps.second), r1, d, area);
}

OVERCAST_SHARED_END

#endif
