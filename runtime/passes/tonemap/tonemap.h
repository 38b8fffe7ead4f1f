// Tonemap: from linear radiance to a picture: backdrop, box filter, exposure, tone curve, sRGB, dither. Read by C++ and GLSL.
#ifndef RUNTIME_PASSES_TONEMAP_TONEMAP_H
#define RUNTIME_PASSES_TONEMAP_TONEMAP_H

#include "runtime/shared_types.h"

OVERCAST_SHARED_BEGIN

struct TonemapPush {
  vec4 cornerRay;  //  0: xyz: direction from the eye through the picture's top left corner, world axes, any length
  vec4 rightRay;   // 16: xyz: added across the whole width
  vec4 downRay;    // 32: xyz: added across the whole height
  vec4 sky;        // 48: rgb: linear radiance of the sky; w: exposure
  vec4 up;         // 64: xyz: unit vector to the zenith
  ivec4 size;      // 80: xy: pixels of the picture; z: samples per pixel along a side
};

/// Radiance of what lies behind the scene, for looking at only (the light comes from the uniform sky): a little deeper than the sky towards
/// the zenith, hazy at the horizon, and a soft floor below it that keeps dark undersides readable. `elevation` is the sine of the angle
/// above the horizon.
OVERCAST_INLINE vec3 backdrop(vec3 sky, float elevation) {
  float grey = dot(sky, vec3(0.2126f, 0.7152f, 0.0722f));
  vec3 zenith = sky * mix(sky / max(grey, 1.0e-6f), vec3(1.0f), 0.25f) * 0.34f;
  vec3 horizon = mix(sky, vec3(grey), 0.45f) * 0.56f;
  vec3 ground = mix(sky, vec3(grey), 0.75f) * 0.24f;
  vec3 above = mix(horizon, zenith, smoothstep(0.0f, 0.9f, elevation));
  return mix(above, ground, smoothstep(0.0f, 0.75f, -elevation));
}

/// Narkowicz's fit of the ACES reference curve (K. Narkowicz, "ACES Filmic Tone Mapping Curve", 2016), per channel: a toe that holds dark
/// creases together, 0.18 to 0.27, 0.8 to 0.75, and a shoulder to 1.
OVERCAST_INLINE vec3 toneCurve(vec3 x) {
  vec3 numerator = x * (2.51f * x + 0.03f);
  vec3 denominator = x * (2.43f * x + 0.59f) + 0.14f;
  return clamp(numerator / denominator, 0.0f, 1.0f);
}

/// IEC 61966-2-1, for one channel in [0, 1].
OVERCAST_INLINE float encodeSrgb(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * pow(x, 1.0f / 2.4f) - 0.055f;
}

/// Ordered dither: the 64 thresholds (b + 0.5) / 64 of the 8 x 8 Bayer matrix; the same pixel has the same one in every frame.
OVERCAST_INLINE float ditherThreshold(int x, int y) {
  int rank = 0;
  for (int bit = 0; bit < 3; ++bit) {
    int xBit = (x >> bit) & 1;
    int yBit = (y >> bit) & 1;
    rank = rank * 4 + (xBit ^ yBit) * 2 + yBit;
  }
  return (float(rank) + 0.5f) / 64.0f;
}

/// The 8-bit code of a display value in [0, 1], dithered, over 255.
OVERCAST_INLINE float quantise(float value, float threshold) {
  return min(floor(value * 255.0f + threshold), 255.0f) / 255.0f;
}

OVERCAST_SHARED_END

#endif
