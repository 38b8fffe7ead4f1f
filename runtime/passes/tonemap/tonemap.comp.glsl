// OVERCAST_SKY: the sky is not uniform.
#version 460
#include "runtime/passes/aperture/sky.h"
#include "runtime/passes/screen/screen.h"
#include "runtime/passes/tonemap/tonemap.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant) uniform Push {
  TonemapPush push;
};
layout(binding = 0) uniform sampler2D light;  // rgb: radiance, a: sky visibility or kNoSurface
layout(binding = 1, rgba32f) writeonly uniform image2D resolved;
layout(binding = 2, rgba8) writeonly uniform image2D display;

#ifdef OVERCAST_SKY
layout(binding = 3, std430) readonly buffer Sky {
  SkyLight skyLight;
};
#endif

// What lies behind the scene towards `way`.
vec3 behind(vec3 way) {
#ifdef OVERCAST_SKY
  return skyRadiance(skyLight, way);
#else
  return backdrop(push.sky.rgb, dot(way, push.up.xyz));
#endif
}

void main() {
  const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (pixel.x >= push.size.x || pixel.y >= push.size.y) return;
  const int side = push.size.z;
  vec4 sum = vec4(0.0);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const ivec2 texel = pixel * side + ivec2(x, y);
      const vec4 lit = texelFetch(light, texel, 0);
      if (lit.a != kNoSurface) {
        sum += lit;
        continue;
      }
      const vec2 place = (vec2(texel) + 0.5) / vec2(push.size.xy * side);
      const vec3 ray = push.cornerRay.xyz + place.x * push.rightRay.xyz + place.y * push.downRay.xyz;
      sum += vec4(behind(normalize(ray)), 1.0);
    }
  }
  const vec4 mean = sum / float(side * side);
  imageStore(resolved, pixel, mean);
  const vec3 shown = toneCurve(max(mean.rgb, 0.0) * push.sky.w);
  const float threshold = ditherThreshold(pixel.x, pixel.y);
  imageStore(display, pixel,
             vec4(quantise(encodeSrgb(shown.r), threshold), quantise(encodeSrgb(shown.g), threshold),
                  quantise(encodeSrgb(shown.b), threshold), 1.0));
}
