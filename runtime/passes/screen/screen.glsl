// What shaders of screen passes (screen_pass.h) have in common: bindings 0 to 3, and the pixel of a thread. OVERCAST_OVER_LIGHT: the shader
// reads what an earlier pass left in the light image.
#include "runtime/passes/screen/screen.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D depthImage;
layout(set = 0, binding = 1) uniform sampler2D normalImage;
layout(set = 0, binding = 2) uniform sampler2D colourImage;
#ifdef OVERCAST_OVER_LIGHT
layout(set = 0, binding = 3, rgba16f) uniform image2D lightImage;
#else
layout(set = 0, binding = 3, rgba16f) uniform writeonly image2D lightImage;
#endif

// The point at `depth` of a pixel of a picture of `size`, in the space that `fromClip` leads to.
vec3 pointOfPixel(mat4 fromClip, ivec2 pixel, ivec2 size, float depth) {
  vec4 p = fromClip * vec4((vec2(pixel) + 0.5f) / vec2(size) * 2.0f - 1.0f, depth, 1.0f);
  return p.xyz / p.w;
}

// Whether there is a surface in a pixel, and where that is. A pixel without one is written.
bool surfaceOfPixel(mat4 fromClip, ivec2 pixel, out vec3 point) {
  point = vec3(0.0f);
  ivec2 size = imageSize(lightImage);
  if (any(greaterThanEqual(pixel, size))) return false;
  float depth = texelFetch(depthImage, pixel, 0).r;
  if (depth <= 0.0f) {
    imageStore(lightImage, pixel, vec4(0.0f, 0.0f, 0.0f, kNoSurface));
    return false;
  }
  point = pointOfPixel(fromClip, pixel, size, depth);
  return true;
}

// The same of the pixel that this thread has.
bool surfaceOfThread(mat4 fromClip, out ivec2 pixel, out vec3 point) {
  pixel = ivec2(gl_GlobalInvocationID);
  return surfaceOfPixel(fromClip, pixel, point);
}

// Leaves a pixel with the light it receives (irradiance / pi) and its sky visibility.
void writeLight(ivec2 pixel, vec3 received, float sky) {
  imageStore(lightImage, pixel, vec4(texelFetch(colourImage, pixel, 0).rgb * received, sky));
}
