// One thread per pixel: light through the aperture that the geometry pass left.
// OVERCAST_APERTURE_MODE: one of kAperture....; OVERCAST_OTHERS: the scene has more than one object; OVERCAST_REST: what the sky estimator
// says at rest and now is known; OVERCAST_SKY: the sky is not uniform; OVERCAST_TRANSFER: some meshes bring their own sky light.
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
#ifdef OVERCAST_REST
layout(set = 0, binding = 9) uniform sampler2D restImage;
#endif
#ifdef OVERCAST_TRANSFER
layout(set = 0, binding = 8) uniform sampler2D skyLightImage;
#endif

// What comes from the whole sky, over pi, where `visible` of it is left and the aperture alone leaves `ambient`.
vec3 lightOfSky(ivec2 pixel, vec3 normal, vec4 aperture, float ambient, float visible) {
#ifdef OVERCAST_TRANSFER
  vec4 own = texelFetch(skyLightImage, pixel, 0);
  if (own.a > 0.5 && ambient > 0.0) return own.rgb * (visible / ambient);
#endif
#ifdef OVERCAST_SKY
  return skyThrough(skyLight, normal, aperture) * visible;
#else
  return push.sky.rgb * visible;
#endif
}

// Sky visibility: the baked one, corrected by what has changed since.
float skyVisible(ivec2 pixel, float ambient) {
#ifdef OVERCAST_REST
  vec2 rest = texelFetch(restImage, pixel, 0).rg;
  return correctedVisibility(ambient, rest.x, imageLoad(lightImage, pixel).a, rest.y);
#else
  return ambient;
#endif
}

#ifdef OVERCAST_OTHERS
layout(set = 0, binding = 6) uniform sampler3D volume;

// What other objects leave of a cone from `from` (voxels) in `direction`, up to `far` voxels.
float clearOfOthers(vec3 from, vec3 direction, float radius, float far) {
  vec3 size = vec3(textureSize(volume, 0));
  float least = 1.0;
  vec2 first = vec2(0.0), second = vec2(0.0);  // the two samples before: x: t, y: phi / width
  float t = 0.0;
  for (int i = 0; i < kConeSteps && t < far && least > -1.0; ++i) {
    vec3 p = from + t * direction;
    if (any(lessThan(p, vec3(0.0))) || any(greaterThan(p, size))) break;
    float phi = textureLod(volume, p / size, 0.0).r;
    float width = coneWidth(t, radius);
    vec2 third = vec2(t, phi / width);
    least = min(least, i > 1 ? coneLeast(first, second, third) : third.y);
    first = second;
    second = third;
    t += coneStep(phi, width);
  }
  return coneClear(least);
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
#ifdef OVERCAST_REST
  bool knowsOthers = restKnowsOthers(texelFetch(restImage, pixel, 0).g);
#else
  bool knowsOthers = true;  // else something could change
#endif
#endif
  vec3 received = vec3(0.0);
  float covered = 0.0;
  for (int i = 0; i < push.lights.x; ++i) {
    vec4 cap = lightCap(lights[i], point, normal);
    ApertureShare share = apertureShare(OVERCAST_APERTURE_MODE, normal, aperture, cap);
    covered += share.area;
#ifdef OVERCAST_OTHERS
    if (knowsOthers && lights[i].radiance.w == 0.0) share = lampShare(OVERCAST_APERTURE_MODE, normal, cap, share);
#endif
    if (share.cosine <= 0.0) continue;
#ifdef OVERCAST_OTHERS
    share.cosine *= clearOfOthers(from, share.centre, share.radius, distanceOf(lights[i], point));
#endif
    received += lights[i].radiance.rgb * share.cosine;
  }
  float ambient = ambientFromWord(code.y);
  float visible = skyVisible(pixel, ambient);
  received = received / kCapPi + lightOfSky(pixel, normal, aperture, ambient, visible) * skyShare(aperture.w, covered);
  writeLight(pixel, received, visible);
}
