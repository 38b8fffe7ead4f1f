// One thread per pixel: light through the aperture that the geometry pass left.
// OVERCAST_APERTURE_MODE: one of kAperture....; OVERCAST_OTHERS: the scene has more than one object;
// OVERCAST_SKY: the sky is not uniform; OVERCAST_TRANSFER: some meshes bring their own sky light.
#version 460
#include "runtime/passes/aperture/aperture.h"
#include "runtime/passes/aperture/sky.h"
#include "runtime/passes/screen/screen.glsl"

layout(push_constant) uniform Push {
  AperturePush push;
};
layout(set = 0, binding = 4) uniform usampler2D apertureImage;
layout(set = 0, binding = 5, std430) readonly buffer Lights {
  ApertureLight lights[];
};

#ifdef OVERCAST_SKY
layout(set = 0, binding = 7, std430) readonly buffer Sky {
  SkyLight skyLight;
};
#endif
#ifdef OVERCAST_TRANSFER
layout(set = 0, binding = 8) uniform sampler2D skyLightImage;
#endif

// What comes through the aperture from the whole sky, over pi.
vec3 lightOfSky(ivec2 pixel, vec3 normal, vec4 aperture, float ambient) {
#ifdef OVERCAST_TRANSFER
  vec4 own = texelFetch(skyLightImage, pixel, 0);
  if (own.a > 0.5) return own.rgb;
#endif
#ifdef OVERCAST_SKY
  return skyThrough(skyLight, normal, aperture) * ambient;
#else
  return push.sky.rgb * ambient;
#endif
}

#ifdef OVERCAST_OTHERS
layout(set = 0, binding = 6) uniform sampler3D volume;

// What other objects leave of a cone from `from` (voxels) in `direction`, up to `far` voxels.
float clearOfOthers(vec3 from, vec3 direction, float radius, float far) {
  vec3 size = vec3(textureSize(volume, 0));
  float clear = 1.0;
  float t = 0.0;
  for (int i = 0; i < kConeSteps && t < far && clear > 0.0; ++i) {
    vec3 p = from + t * direction;
    if (any(lessThan(p, vec3(0.0))) || any(greaterThan(p, size))) break;
    float phi = textureLod(volume, p / size, 0.0).r;
    float width = coneWidth(t, radius);
    clear = min(clear, coneClear(phi, width));
    t += coneStep(phi, width);
  }
  return clear;
}

// Share of the sky of an aperture that other objects leave.
float skyOfOthers(vec3 from, vec3 normal, vec4 aperture) {
  float sum = 0.0;
  float whole = 0.0;
  for (int i = 0; i < kSkyCones; ++i) {
    vec3 axis = skyConeAxis(aperture, i);
    float weight = dot(axis, normal);
    if (weight <= 0.0) continue;
    whole += weight;
    sum += weight * clearOfOthers(from, axis, kSkyConeRadius * aperture.w, 1.0e6);
  }
  return whole > 0.0 ? sum / whole : 1.0;
}

// Voxels from a point to the surface of a light, beyond which nothing stands before it.
float distanceOf(ApertureLight light, vec3 point) {
  return light.radiance.w > 0.0 ? 1.0e6 : max(distance(light.place.xyz, point) - light.place.w, 0.0) * push.voxel.w;
}
#endif

void main() {
  ivec2 pixel;
  vec3 point;
  if (!surfaceOfThread(push.relativeFromClip, pixel, point)) return;
  uvec2 code = texelFetch(apertureImage, pixel, 0).rg;
  vec4 aperture = apertureFromWords(code.x, code.y);
  vec3 normal = normalize(texelFetch(normalImage, pixel, 0).xyz);

#ifdef OVERCAST_OTHERS
  vec3 from = push.voxel.xyz + point * push.voxel.w + kConeStart * normal;
#endif
  vec3 received = vec3(0.0);
  float covered = 0.0;
  for (int i = 0; i < push.lights.x; ++i) {
    ApertureShare share = apertureShare(OVERCAST_APERTURE_MODE, normal, aperture, lightCap(lights[i], point, normal));
    covered += share.area;
    if (share.cosine <= 0.0) continue;
#ifdef OVERCAST_OTHERS
    share.cosine *= clearOfOthers(from, share.centre, share.radius, distanceOf(lights[i], point));
#endif
    received += lights[i].radiance.rgb * share.cosine;
  }
  float ambient = ambientFromWord(code.y);
  float others = 1.0;
#ifdef OVERCAST_OTHERS
  if (ambient > 0.0) others = skyOfOthers(from, normal, aperture);
#endif
  received = received / kCapPi + lightOfSky(pixel, normal, aperture, ambient) * (others * skyShare(aperture.w, covered));
  writeLight(pixel, received, ambient * others);
}
