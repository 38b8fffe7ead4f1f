// What an open surface receives of the sky, for shaders whose push constants hold `sky`. OVERCAST_SKY: the sky is not uniform but a
// SkyLight at this binding.
#ifdef OVERCAST_SKY
#include "runtime/passes/aperture/sky.h"

layout(set = 0, binding = OVERCAST_SKY, std430) readonly buffer Sky {
  SkyLight skyLight;
};
#endif

// Irradiance over pi at a surface of any normal but zero.
vec3 openSky(vec3 normal) {
#ifdef OVERCAST_SKY
  return skyOverOpen(skyLight, normalize(normal));
#else
  return push.sky.rgb;
#endif
}
