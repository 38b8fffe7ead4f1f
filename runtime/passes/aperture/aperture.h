// Aperture: light of the sun, of spherical lights and of the sky through a surface's cap of visibility (Oat and Sander 2006, section 8.4;
// DESIGN 5.5). Read by C++ and GLSL; caps.h has the geometry.
//
// A pixel's aperture is the cap of directions in which its own object leaves the sky free. A light is a cap too. Of what both have in
// common the surface gets radiance times cosine; what no light covers is filled with sky.
//
// Other objects take light away by the global distance volume. The cone of what a light sends through the aperture holds nothing of the
// object itself, so whatever the volume finds in it belongs to others: it is traced for each light, and what is clear of it multiplies in.
// Apertures that were baked with others leave lamps to the volume for the most part (lampShare).
// The sky goes by what the sky estimator says has changed since the bake (the hybrids of DESIGN 5.4): runtime/passes/shade/rest.h. Scenes
// of one object have no others and trace nothing.
#ifndef RUNTIME_PASSES_APERTURE_APERTURE_H
#define RUNTIME_PASSES_APERTURE_APERTURE_H

#include "formats/shared/aperture.h"
#include "runtime/passes/aperture/caps.h"
#include "runtime/passes/screen/screen.h"
#include "runtime/passes/shade/rest.h"

OVERCAST_SHARED_BEGIN

const int kMaxApertureLights = 17;  ///< the sun and 16 spherical lights

/// How light and aperture are intersected (FrameSettings::apertureMode).
const int kApertureExact = 0;       ///< exact area, cosine at the estimated centroid, which is that of a cap of this area
const int kApertureSmoothstep = 1;  ///< as published: smoothstep, cosine at the mean of both axes
const int kApertureFast = 2;        ///< our approximation of the area, cosine at the estimated centroid
const int kApertureAccurate = 3;    ///< the integral of the cosine over the intersection

/// One light as the pass sees it.
struct ApertureLight {
  vec4 place;     //  0: xyz: centre relative to the eye, w: radius; of the sun: unit direction to it, w: angular radius
  vec4 radiance;  // 16: rgb: linear; w: 1: the sun, 0: a sphere
};

struct AperturePush {
  mat4 relativeFromClip;  //  0: positions relative to the eye from clip space, before the division by w
  vec4 sky;               // 64: rgb: linear radiance of the sky
  vec4 voxel;             // 80: xyz: the eye in voxels of the volume from its corner, w: voxels per metre
  ivec4 lights;           // 96: x: how many
};

/// What a surface receives of one light.
struct ApertureShare {
  float area;    ///< solid angle of the light that is seen
  float cosine;  ///< its integral of the cosine to the normal
  float radius;  ///< of the cone of it
  vec3 centre;   ///< unit vector to its middle
};

/// Cap of a light as seen from a point relative to the eye: xyz axis, w radius. From within a sphere it is the hemisphere towards its
/// centre; a point at the centre takes `normal` for that.
OVERCAST_INLINE vec4 lightCap(ApertureLight light, vec3 point, vec3 normal) {
  if (light.radiance.w > 0.0f) return light.place;
  vec3 way = vec3(light.place) - point;
  float squared = dot(way, way);
  float radius = light.place.w;
  vec3 axis = squared > kCapTiny ? way / sqrt(squared) : normal;
  return vec4(axis, capAngle(radius, sqrt(max(squared - radius * radius, 0.0f))));
}

/// Steps of a cone through the distance volume, at most.
const int kConeSteps = 32;
/// Cones start so many voxels above the surface, out of reach of how much mesh and volume disagree.
const float kConeStart = 1.0f;
/// Of lampShare.
const float kLampKnown = 0.25f;
/// A cone is nowhere narrower than so many voxels, which the volume can tell.
const float kConeNarrowest = 0.5f;

/// Angle between the axis and the side of the cone of what a light sends through an aperture.
OVERCAST_INLINE float coneRadius(float aperture, float light, float d) {
  return clamp(0.5f * (aperture + light - d), 0.0f, min(aperture, light));
}

/// Half the width, in voxels, of a cone at distance t from its tip.
OVERCAST_INLINE float coneWidth(float t, float radius) {
  return max(t * capSine(radius), kConeNarrowest);
}

/// How much of a cone is clear where the nearest surface is `least` half widths from its axis (negative: beyond it), [0, 1]: the share of a
/// disc on one side of a chord, to 0.013.
OVERCAST_INLINE float coneClear(float least) {
  float x = clamp(least, -1.0f, 1.0f);
  return 0.5f + x * (0.625f - 0.125f * x * x);
}

/// The least value near three samples (x: place, growing, y: value): that of the last, or where the second is the lowest, of the parabola
/// through them. Steps alone draw rings into shadows.
OVERCAST_INLINE float coneLeast(vec2 first, vec2 second, vec2 third) {
  float fall = (second.y - first.y) / (second.x - first.x);
  float rise = (third.y - second.y) / (third.x - second.x);
  float bend = (rise - fall) / (third.x - first.x);
  if (fall > 0.0f || rise < 0.0f || !(bend > 0.0f)) return third.y;
  float place = 0.5f * (first.x + second.x - fall / bend);
  return first.y + (place - first.x) * (fall + bend * (place - second.x));
}

/// How far the next step goes: to where something can be that is not seen from here, but on through what half blocks the cone.
OVERCAST_INLINE float coneStep(float phi, float width) {
  return max(phi, 0.5f * width);
}

/// What comes through `aperture` (xyz axis, w radius) of the cap `light`.
OVERCAST_INLINE ApertureShare apertureShare(int mode, vec3 normal, vec4 aperture, vec4 light) {
  vec3 axis = vec3(aperture);
  vec3 way = vec3(light);
  float d = capDistance(axis, way);
  ApertureShare share;
  share.centre = capCentroid(axis, aperture.w, way, light.w, d);
  share.radius = coneRadius(aperture.w, light.w, d);
  if (mode == kApertureSmoothstep) {
    vec3 sum = axis + way;
    share.area = capIntersectionSmoothstep(aperture.w, light.w, d);
    share.cosine = share.area * max(dot(normal, sum) / max(length(sum), kCapTiny), 0.0f);
    return share;
  }
  share.area = mode == kApertureFast ? capIntersectionFast(aperture.w, light.w, d) : capIntersection(aperture.w, light.w, d);
  if (mode == kApertureAccurate) {
    share.cosine = capIntersectionCosine(normal, axis, aperture.w, way, light.w, d, share.area);
  } else {
    // The mean of a cap's directions is shorter than one by its share of the sphere.
    float length = 1.0f - share.area / (4.0f * kCapPi);
    share.cosine = share.area * length * max(dot(normal, share.centre), 0.0f);
  }
  return share;
}

/// What a lamp sends to a surface whose aperture other objects narrow too, before the cone of the whole lamp through the volume, which
/// finds them again. Such an aperture tells what is left of the sky: it takes walls behind the lamp for walls before it. `share`, what
/// comes through it, counts for kLampKnown, for what the object's own shape hides and volumes are too coarse to tell.
OVERCAST_INLINE ApertureShare lampShare(int mode, vec3 normal, vec4 lamp, ApertureShare share) {
  ApertureShare whole = apertureShare(mode, normal, vec4(normal, kApertureWidest), lamp);
  whole.cosine = mix(whole.cosine, share.cosine, kLampKnown);
  return whole;
}

/// Share of an aperture that lights which cover `covered` of it (a solid angle) leave to the sky.
OVERCAST_INLINE float skyShare(float radius, float covered) {
  float whole = capArea(radius);
  return whole > 0.0f ? clamp(1.0f - covered / whole, 0.0f, 1.0f) : 1.0f;
}

/// The 8-byte packing of formats/shared/aperture.h of an aperture (xyz unit axis, w radius) and its ambient visibility. Rounds each
/// coordinate by itself: between passes the nearest of all codes is not worth its search.
OVERCAST_INLINE uvec2 aperturePacked(vec4 aperture, float ambient) {
  vec3 size = abs(vec3(aperture));
  vec2 point = vec2(aperture.x, aperture.y) / (size.x + size.y + size.z);
  if (aperture.z < 0.0f) {
    vec2 folded = vec2(1.0f) - abs(vec2(point.y, point.x));
    point = vec2(point.x < 0.0f ? -folded.x : folded.x, point.y < 0.0f ? -folded.y : folded.y);
  }
  uvec2 coordinates = uvec2(clamp((point + 1.0f) * 32767.0f + 0.5f, 0.0f, 65534.0f));
  vec2 shares = clamp(vec2(aperture.w / kApertureWidest, ambient), 0.0f, 1.0f);
  uvec2 codes = uvec2(shares * 65535.0f + 0.5f);
  return uvec2(coordinates.x | (coordinates.y << 16), codes.x | (codes.y << 16));
}

OVERCAST_SHARED_END

#endif
