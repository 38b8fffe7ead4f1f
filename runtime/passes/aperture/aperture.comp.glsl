// One thread per pixel: light through the aperture that the geometry pass left, over what the shade pass made of the pixel.
// OVERCAST_APERTURE_MODE: one of kAperture....
#version 460
#include "runtime/passes/aperture/aperture.h"
#include "runtime/passes/shade/shade.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant) uniform Push { AperturePush push; };
layout(set = 0, binding = 0) uniform sampler2D depthImage;
layout(set = 0, binding = 1) uniform sampler2D normalImage;
layout(set = 0, binding = 2) uniform sampler2D colourImage;
layout(set = 0, binding = 3) uniform usampler2D apertureImage;
layout(set = 0, binding = 4, rgba16f) uniform image2D lightImage;
layout(set = 0, binding = 5, std430) readonly buffer Lights { ApertureLight lights[]; };

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID);
  ivec2 size = imageSize(lightImage);
  if (any(greaterThanEqual(pixel, size))) return;
  float depth = texelFetch(depthImage, pixel, 0).r;
  if (depth <= 0.0f) return;
  uvec2 code = texelFetch(apertureImage, pixel, 0).rg;
  vec4 aperture = apertureFromWords(code.x, code.y);
  vec3 normal = normalize(texelFetch(normalImage, pixel, 0).xyz);
  vec4 p = push.relativeFromClip * vec4((vec2(pixel) + 0.5) / vec2(size) * 2.0 - 1.0, depth, 1.0);
  vec3 point = p.xyz / p.w;

  vec3 received = vec3(0.0);
  float covered = 0.0;
  for (int i = 0; i < push.lights.x; ++i) {
    ApertureShare share = apertureShare(OVERCAST_APERTURE_MODE, normal, aperture, lightCap(lights[i], point, normal));
    received += lights[i].radiance.rgb * share.cosine;
    covered += share.area;
  }
  // The volume holds the object itself too: where that alone shuts the sky out, its aperture says so better.
  float sky = min(ambientFromWord(code.y), imageLoad(lightImage, pixel).a);
  received = received / kCapPi + push.sky.rgb * sky * skyShare(aperture.w, covered);
  imageStore(lightImage, pixel, vec4(texelFetch(colourImage, pixel, 0).rgb * received, sky));
}
