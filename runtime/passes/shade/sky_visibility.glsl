// Sky visibility at a point by the scene's estimator (shade.h), which is bindings 4 to 12:
//   float visibility(vec3 p, vec3 normal, vec4 skew)   p in voxels, unit normal, ShadePush::skew
// OVERCAST_TAPS taps of the estimator, along the skewed normal or along each of OVERCAST_CONES cones.
// OVERCAST_TURNS: visibilityOfPlace has what one place of the wide pattern sees, by OVERCAST_TRACED rays, of whose places a point takes a
// sixteenth, or by taps along one direction and OVERCAST_STEPS soft steps, of whose places it takes kPointPlaces.
#include "runtime/passes/shade/shade.h"

// Levels that no tap reads repeat the last one.
layout(set = 0, binding = 4) uniform sampler3D level0;
layout(set = 0, binding = 5) uniform sampler3D level1;
layout(set = 0, binding = 6) uniform sampler3D level2;
layout(set = 0, binding = 7) uniform sampler3D level3;
layout(set = 0, binding = 8) uniform sampler3D level4;
layout(set = 0, binding = 9) uniform sampler3D level5;
layout(set = 0, binding = 10) uniform sampler3D level6;
layout(set = 0, binding = 11) uniform sampler3D level7;

#ifdef OVERCAST_REST
// The same of the volume at rest, which is what `field` reads while this is set.
bool atRest = false;
layout(set = 0, binding = 15) uniform sampler3D rest0;
layout(set = 0, binding = 16) uniform sampler3D rest1;
layout(set = 0, binding = 17) uniform sampler3D rest2;
layout(set = 0, binding = 18) uniform sampler3D rest3;
layout(set = 0, binding = 19) uniform sampler3D rest4;
layout(set = 0, binding = 20) uniform sampler3D rest5;
layout(set = 0, binding = 21) uniform sampler3D rest6;
layout(set = 0, binding = 22) uniform sampler3D rest7;
#endif

layout(set = 0, binding = 12, std430) readonly buffer Constants {
  SkyConstants estimator;
};

#define OVERCAST_SAMPLE(name) return textureLod(name, at / vec3(textureSize(name, 0)), 0.0f).r
#define OVERCAST_LEVELS(name)   \
  switch (level) {              \
    case 0:                     \
      OVERCAST_SAMPLE(name##0); \
    case 1:                     \
      OVERCAST_SAMPLE(name##1); \
    case 2:                     \
      OVERCAST_SAMPLE(name##2); \
    case 3:                     \
      OVERCAST_SAMPLE(name##3); \
    case 4:                     \
      OVERCAST_SAMPLE(name##4); \
    case 5:                     \
      OVERCAST_SAMPLE(name##5); \
    case 6:                     \
      OVERCAST_SAMPLE(name##6); \
    default:                    \
      OVERCAST_SAMPLE(name##7); \
  }

// phi of a level at a point inside it, both in voxels of level 0.
float sampleLevel(int level, vec3 inside) {
  vec3 at = inside / exp2(float(level));
#ifdef OVERCAST_REST
  if (atRest) OVERCAST_LEVELS(rest)
#endif
  OVERCAST_LEVELS(level)
}

float field(int level, vec3 p) {
  vec3 inside = insideLevel(p, vec3(textureSize(level0, 0)), level);
  return sampleLevel(level, inside) + distance(p, inside);
}

#ifdef OVERCAST_TRACED
// phi of level 0 at a point of the volume, whose sides are 1.
float sharpField(vec3 at) {
#ifdef OVERCAST_REST
  if (atRest) return textureLod(rest0, at, 0.0f).r;
#endif
  return textureLod(level0, at, 0.0f).r;
}

// Radii of the balls over `from`, 0 of those that are not in the volume. Less than the field says by what makes no ray over open ground
// leave them where it starts.
float[kBalls] ballsOver(vec3 from, vec3 normal, vec3 size) {
  float radii[kBalls];
  for (int i = 0; i < kBalls; ++i) {
    vec3 middle = from + ballHeight(i) * normal;
    radii[i] = clamp(middle, vec3(0.0f), size) == middle ? max(sharpField(middle / size) - 0.5f * kRayStart, 0.0f) : 0.0f;
  }
  return radii;
}

float fieldAt(vec3 p) {
  return field(0, p);
}
#include "runtime/passes/rays/start.glsl"

// Where the rays of a point start.
struct RayStart {
  vec3 from;
  mat3 frame;           // about the normal
  vec2 height;          // heightOfStart
  float balls[kBalls];  // ballsOver
};

RayStart startOver(vec3 p, vec3 normal) {
  RayStart start;
  start.height = heightOfStart(p, normal);
  start.from = p + start.height.x * normal;
  start.frame = frameAbout(normal);
  start.balls = ballsOver(start.from, normal, vec3(textureSize(level0, 0)));
  return start;
}

// How many voxels away the ray in `direction`, in the frame about the normal, meets a surface; 0: it leaves the volume.
float meets(RayStart rays, vec3 direction) {
  vec3 size = vec3(textureSize(level0, 0));
  vec3 along = rays.frame * direction;
  float end = reachInVolume(rays.from, along, size);
  float t = max(kRayFirst, wayToVolume(rays.from, along, size));
  for (int i = 0; i < kBalls; ++i) t = throughBall(t, direction.z, ballHeight(i), rays.balls[i]);
  vec3 start = rays.from / size;
  vec3 way = along / size;
  float before = rays.height.y;
  for (int i = 0; i < kRaySteps && t < end; ++i) {
    float phi = sharpField(start + t * way);
    if (rayHits(t, rays.height.x + t * direction.z, phi, before)) return t;
    before = phi;
    t += max(phi, kRayShortest);
  }
  return t < end ? t : 0.0f;
}

// Visibility by the rays of one place of the wide pattern (denoise.h), and the mean of one over how many voxels away they meet something.
vec2 visibilityOfPlace(RayStart rays, int place) {
  vec2 sum = vec2(0.0f);
  for (int ray = 0; ray < OVERCAST_TRACED; ++ray) {
    float t = meets(rays, tracedDirection(ray, OVERCAST_TRACED, place));
    sum += t > 0.0f ? vec2(0.0f, 1.0f / t) : vec2(1.0f, 0.0f);
  }
  return sum / float(OVERCAST_TRACED);
}

// What the denoise pass takes for a guide: how open a few wide cones are within some voxels.
float guideOf(vec3 p, mat3 frame) {
  float sum = 0.0f;
  for (int cone = 0; cone < kGuideCones; ++cone) {
    vec3 axis = frame * spiralDirection(cone, kGuideCones, 0.5f, 0.0f);
    float open = 1.0f;
    for (int tap = 0; tap < kGuideTaps; ++tap) open = min(open, guideOpenness(fieldAt(p + guideDistance(tap) * axis), tap));
    sum += open;
  }
  return sum / float(kGuideCones);
}

float visibility(vec3 p, vec3 normal, vec4 skew) {
  RayStart rays = startOver(p, normal);
  float sum = 0.0f;
  for (int place = 0; place < kPatternSize; ++place) sum += visibilityOfPlace(rays, kPatternSize * place).x;
  return sum / float(kPatternSize);
}
#elif defined(OVERCAST_CONES)
float visibility(vec3 p, vec3 normal, vec4 skew) {
  mat3 frame = frameAbout(normal);
  float sum = 0.0f;
  for (int cone = 0; cone < OVERCAST_CONES; ++cone) {
    vec3 axis = frame * vec3(estimator.directions[cone]);
    float open = 1.0f;
    for (int tap = 0; tap < OVERCAST_TAPS; ++tap) {
      float d = estimator.taps[tap].distance;
      open = min(open, coneOpenness(field(estimator.taps[tap].level, p + d * axis), d, estimator.cone));
    }
    sum += open;
  }
  return pow(sum / float(OVERCAST_CONES), estimator.cone.z);
}
#elif defined(OVERCAST_STEPS)
// Visibility along the direction of one place of the wide pattern, and one over how many voxels away is what it misses.
vec2 visibilityOfPlace(vec3 p, vec3 normal, int place) {
  vec3 turned = tracedDirection(0, 1, place);
  vec3 direction = frameAbout(normal) * turned;
  float end = reachInVolume(p, direction, vec3(textureSize(level0, 0)));
  vec4 missing[2] = vec4[](vec4(0.0f), vec4(0.0f));
  vec4 gaps[2] = vec4[](vec4(0.0f), vec4(0.0f));
  vec2 before = vec2(0.0f);
  float nearest = 0.0f;
  for (int tap = 0; tap < OVERCAST_TAPS; ++tap) {
    float d = calibratedDistance(estimator.taps[tap], place, end);
    float phi = field(0, p + d * direction);
    float misses = shareMissing(phi, d, turned.z);
    missing[tap / 4][tap % 4] = misses;
    if (tap > 0) gaps[(tap - 1) / 4][(tap - 1) % 4] = gapMissing(before.y, before.x, phi, d, turned.z);
    nearest = max(nearest, misses / d);
    before = vec2(d, phi);
  }
  float exponent = 0.0f;
  for (int i = 0; i < OVERCAST_STEPS; ++i) exponent += stepExponent(estimator.steps[i], missing[0], missing[1], gaps[0], gaps[1], turned.z);
  float open = exp(-max(exponent, 0.0f));
  return vec2(open, (1.0f - open) * nearest);
}

float visibility(vec3 p, vec3 normal, vec4 skew) {
  float sum = 0.0f;
  for (int n = 0; n < kPointPlaces; ++n) sum += visibilityOfPlace(p, normal, pointPlace(n)).x;
  return sum / float(kPointPlaces);
}
#else
float visibility(vec3 p, vec3 normal, vec4 skew) {
  vec3 skewed = skewedNormal(normal, vec3(skew));
  float exponent = 0.0f;
  for (int tap = 0; tap < OVERCAST_TAPS; ++tap) {
    float d = estimator.taps[tap].distance;
    exponent += estimator.taps[tap].weight * tapMissing(field(estimator.taps[tap].level, p + d * skewed), d, skew.w);
  }
  return skyVisibility(exponent);
}
#endif
