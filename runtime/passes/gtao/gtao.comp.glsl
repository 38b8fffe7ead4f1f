// One thread per pixel: horizons in push.search.y slices of the depth image, those of its place in the pattern of denoise.h.
#version 460
#include "runtime/passes/denoise/denoise.h"
#include "runtime/passes/gtao/gtao.h"
#include "runtime/passes/screen/screen.glsl"

layout(push_constant) uniform Push {
  GtaoPush push;
};

// Cosine to the viewer of the horizon on one side of a slice: `across` is a pixel's step in the picture, `lowest` the cosine of the
// surface's own horizon.
float horizonOf(ivec2 pixel, vec3 point, vec3 normal, vec3 viewer, vec2 across, float reach, float jitter, float lowest) {
  ivec2 size = imageSize(lightImage);
  float horizon = lowest;
  for (float step = 0.0f; step < push.search.z; step += 1.0f) {
    ivec2 other = ivec2(floor(vec2(pixel) + 0.5f + across * gtaoStep(step, push.search.z, jitter, reach)));
    if (any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, size))) break;
    float depth = texelFetch(depthImage, other, 0).r;
    if (depth <= 0.0f) continue;
    vec3 way = pointOfPixel(push.relativeFromClip, other, size, depth) - point;
    float distance = length(way);
    if (distance <= 0.0f) continue;
    float found = mix(lowest, dot(way, viewer) / distance, gtaoWeight(distance, push.search.x) * gtaoRise(dot(way, normal) / distance));
    horizon = gtaoHorizon(horizon, found, push.search.w);
  }
  return horizon;
}

void main() {
  ivec2 pixel;
  vec3 point;
  if (!surfaceOfThread(push.relativeFromClip, pixel, point)) return;
  ivec2 size = imageSize(lightImage);
  float depth = texelFetch(depthImage, pixel, 0).r;
  vec3 normal = texelFetch(normalImage, pixel, 0).xyz;
  vec3 viewer = -normalize(point);
  int place = patternPlace(pixel);
  float jitter = (float((7 * place) & 15) + 0.5f) / 16.0f;
  float seen = 0.0f;
  float whole = 0.0f;
  for (float slice = 0.0f; slice < push.search.y; slice += 1.0f) {
    float turn = 2.0f * kGtaoHalfPi * (slice + (float(place) + 0.5f) / 16.0f) / push.search.y;
    vec2 across = vec2(cos(turn), sin(turn));
    vec4 aside = push.relativeFromClip * vec4((vec2(pixel) + 0.5f + across) / vec2(size) * 2.0f - 1.0f, depth, 1.0f);
    vec3 way = aside.xyz / aside.w - point;
    float reach = min(push.search.x / length(way), kGtaoMostPixels * float(max(size.x, size.y)));
    vec3 along = normalize(way - dot(way, viewer) * viewer);
    vec3 axis = cross(along, viewer);
    vec3 projected = normal - dot(normal, axis) * axis;
    float weight = length(projected);
    float n = gtaoNormalAngle(projected, along, viewer);
    float high = horizonOf(pixel, point, normal, viewer, across, reach, jitter, cos(n + kGtaoHalfPi));
    float low = horizonOf(pixel, point, normal, viewer, -across, reach, jitter, cos(n - kGtaoHalfPi));
    seen += weight * gtaoSlice(acos(clamp(low, -1.0f, 1.0f)), acos(clamp(high, -1.0f, 1.0f)), n);
    whole += weight * gtaoOpenSlice(n);
  }
  float sky = whole > 0.0f ? clamp(seen / whole, 0.0f, 1.0f) : 1.0f;
  writeLight(pixel, push.sky.rgb * sky, sky);
}
