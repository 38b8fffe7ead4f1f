// The intersection of two caps as textbooks have it: what `./run caps` shows the stable form beside. Read by C++ and GLSL.
#ifndef TESTS_BENCH_TEXTBOOK_CAPS_H
#define TESTS_BENCH_TEXTBOOK_CAPS_H

#include "runtime/shared_types.h"

OVERCAST_SHARED_BEGIN

/// Oat and Sander 2006, 8.4.1, with the sign of the third term put right (DESIGN 6).
OVERCAST_INLINE float naiveIntersection(float r0, float r1, float d) {
  float small = min(r0, r1);
  if (small <= max(r0, r1) - d) return 6.28318531f - 6.28318531f * cos(small);
  if (r0 + r1 <= d) return 0.0f;
  return 6.28318531f - 2.0f * acos((cos(d) - cos(r0) * cos(r1)) / (sin(r0) * sin(r1))) -
         2.0f * cos(r0) * acos((cos(r1) - cos(d) * cos(r0)) / (sin(d) * sin(r0))) -
         2.0f * cos(r1) * acos((cos(r0) - cos(d) * cos(r1)) / (sin(d) * sin(r1)));
}

/// The same with its cosines kept in [-1, 1] and its result between nothing and the smaller cap.
OVERCAST_INLINE float clampedIntersection(float r0, float r1, float d) {
  float small = min(r0, r1);
  float whole = 6.28318531f - 6.28318531f * cos(small);
  if (small <= max(r0, r1) - d) return whole;
  if (r0 + r1 <= d) return 0.0f;
  float corner = acos(clamp((cos(d) - cos(r0) * cos(r1)) / (sin(r0) * sin(r1)), -1.0f, 1.0f));
  float angle0 = acos(clamp((cos(r1) - cos(d) * cos(r0)) / (sin(d) * sin(r0)), -1.0f, 1.0f));
  float angle1 = acos(clamp((cos(r0) - cos(d) * cos(r1)) / (sin(d) * sin(r1)), -1.0f, 1.0f));
  return clamp(6.28318531f - 2.0f * (corner + cos(r0) * angle0 + cos(r1) * angle1), 0.0f, whole);
}

OVERCAST_SHARED_END

#endif
