// The walk over all placed nodes. OVERCAST_SURFEL_GATHER: 1: shadows alone, 2: light from fronts, 3: both, by accessibility.
// Include after the push constants.
#include "runtime/passes/surfels/surfels.h"

layout(set = 0, binding = 4, std430) readonly buffer Placed {
  Surfel placed[];
};
layout(set = 0, binding = 5, std430) buffer Lights {
  vec4 lights[];
};  // rgb: light from other discs, a: accessibility

struct Gathered {
  float first;   // shadows
  float second;  // shadows times accessibility
  vec3 light;    // of fronts, less what shadowing discs hold back of theirs
};

Gathered gather(vec3 point, vec3 normal, int self) {
  Gathered sum = Gathered(0.0f, 0.0f, vec3(0.0f));
  int node = 0;
  while (node < push.counts.x) {
    vec4 place = placed[node].place;
    vec4 facing = placed[node].normal;
    vec4 albedo = placed[node].albedo;
    vec3 way = place.xyz - point;
    float squared = dot(way, way);
    if (surfelEnters(squared, place.w, albedo.w, push.sky.w) != 0) {
      ++node;
      continue;
    }
    int next = int(facing.w);
    if (squared > 0.0f && node != self) {
      way *= inversesqrt(squared);
      float cosReceiver = dot(normal, way);
      float cosEmitter = dot(facing.xyz, way);
      float factor = surfelFactor(squared, place.w, cosReceiver, abs(cosEmitter));
      if (cosEmitter > 0.0f) {
        sum.first += factor;
#if OVERCAST_SURFEL_GATHER > 2
        sum.second += factor * lights[node].a;
        sum.light -= factor * lights[node].rgb;
#endif
#if OVERCAST_SURFEL_GATHER > 1
      } else {
        sum.light += factor * albedo.rgb * push.sky.rgb * lights[node].a;
#endif
      }
    }
    node = next;
  }
  return sum;
}
