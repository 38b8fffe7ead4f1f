// GTAO: ground-truth ambient occlusion in screen space (Jimenez, Wu, Pesce and Jarabo 2016, Practical Real-Time Strategies for Accurate
// Indirect Occlusion, section 4 and algorithm 1). Read by C++ and GLSL.
//
// The hemisphere is cut into slices that hold the direction to the viewer. In each, the depth image is searched to both sides for the
// horizon, and the visible part of the slice, weighted by the cosine, is integrated in closed form. Slices and steps differ in a pattern of
// sixteen pixels that the denoise pass (denoise.h) averages: no noise, and no history.
//
// Ours, on top of it: visibility is divided by what the same slices give without occluders, so that open ground is exactly 1 at any angle
// and for any number of slices. The radius is wide, so that the technique competes as sky visibility; what lies outside the picture or
// behind what it shows stays unknown.
#ifndef RUNTIME_PASSES_GTAO_GTAO_H
#define RUNTIME_PASSES_GTAO_GTAO_H

#include "runtime/passes/screen/screen.h"

OVERCAST_SHARED_BEGIN

const float kGtaoHalfPi = 1.57079633f;
const float kGtaoRise = 0.02f;       ///< sine of the height above the surface from which occluders count in full
const float kGtaoFalloff = 0.4f;     ///< share of the radius over which occluders fade
const float kGtaoNearest = 1.5f;     ///< pixels to the first sample at least
const float kGtaoMostPixels = 0.5f;  ///< of the picture's longer side that a search may cross

struct GtaoPush {
  mat4 relativeFromClip;  //  0: positions relative to the eye from clip space, before the division by w
  vec4 sky;               // 64: rgb: linear radiance of the sky
  vec4 search;            // 80: x: radius in metres, y: slices, z: steps to each side, w: thickness per step
};

/// Distance in pixels of step `step` of `steps` of a search of `reach` pixels; `jitter` in [0, 1). Dense near the pixel.
OVERCAST_INLINE float gtaoStep(float step, float steps, float jitter, float reach) {
  float share = (step + jitter) / steps;
  return kGtaoNearest + share * share * max(reach - kGtaoNearest, 0.0f);
}

/// What an occluder `distance` away counts for, of 1.
OVERCAST_INLINE float gtaoWeight(float distance, float radius) {
  return clamp((radius - distance) / (kGtaoFalloff * radius), 0.0f, 1.0f);
}

/// The cosine of a horizon after a sample of cosine `found`: a lower one takes it back a little (section 4.3), by the share `thickness`.
OVERCAST_INLINE float gtaoHorizon(float horizon, float found, float thickness) {
  return found > horizon ? found : mix(horizon, found, thickness);
}

/// What a sample counts for by the sine of its height above the surface's plane: those of the plane itself lie beside the slice when a
/// pixel does, and would darken it where it is seen at a grazing angle.
OVERCAST_INLINE float gtaoRise(float sine) {
  return clamp(sine / kGtaoRise, 0.0f, 1.0f);
}

/// Angle from the direction to the viewer to the normal's projection into a slice; `along` is the slice's direction across the view.
OVERCAST_INLINE float gtaoNormalAngle(vec3 projected, vec3 along, vec3 viewer) {
  return atan(dot(projected, along), dot(projected, viewer));
}

/// Cosine-weighted integral of a slice from the viewer to the horizon angle h (equation 7, one side), the normal at angle n.
OVERCAST_INLINE float gtaoArc(float h, float n) {
  return 0.25f * (cos(n) + 2.0f * h * sin(n) - cos(2.0f * h - n));
}

/// The same for both sides: horizons at angles -low and high from the viewer, both cut to the hemisphere of the normal.
OVERCAST_INLINE float gtaoSlice(float low, float high, float n) {
  return gtaoArc(max(-low, n - kGtaoHalfPi), n) + gtaoArc(min(high, n + kGtaoHalfPi), n);
}

/// What gtaoSlice gives without occluders.
OVERCAST_INLINE float gtaoOpenSlice(float n) {
  return cos(n) + n * sin(n);
}

OVERCAST_SHARED_END

#endif
