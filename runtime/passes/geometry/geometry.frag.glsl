// OVERCAST_APERTURES: with the interpolated aperture, packed. OVERCAST_APERTURE_MAPS: with the one that a map has here.
// OVERCAST_TRANSFER: with the interpolated sky light. OVERCAST_REST: with the interpolated sky visibility at rest, into that attachment.
#version 460
#include "runtime/passes/geometry/geometry.h"

#ifdef OVERCAST_APERTURES
#include "runtime/passes/aperture/aperture.h"
#ifdef OVERCAST_APERTURE_MAPS
layout(binding = 1, std430) readonly buffer Instances {
  GeometryInstance instances[];
};
layout(binding = 3) uniform sampler2D capMap;
layout(binding = 4) uniform sampler2D ambientMap;
layout(location = 2) in vec2 coordinate;
layout(location = 3) flat in uint instanceIndex;
#else
layout(location = 2) in vec3 aperture;
layout(location = 3) in vec2 radiusAmbient;
#endif
layout(location = 2) out uvec2 outAperture;
#endif

#ifdef OVERCAST_TRANSFER
layout(location = 5) in vec4 skyLight;
layout(location = OVERCAST_TRANSFER) out vec4 outSkyLight;
#endif

#ifdef OVERCAST_REST
layout(location = 6) in vec2 rest;
layout(location = OVERCAST_REST) out vec2 outRest;
#endif

layout(push_constant) uniform Push {
  GeometryPush push;
};

layout(location = 0) in vec3 relative;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec4 outNormal;
layout(location = 1) out vec4 outColour;

void main() {
  // Lengths do not matter, so the face is taken from unit steps: products of tiny derivatives would vanish.
  const vec3 stepX = dFdx(relative);
  const vec3 stepY = dFdy(relative);
  const float size = max(max(abs(stepX.x), abs(stepX.y)), max(max(abs(stepX.z), abs(stepY.x)), max(abs(stepY.y), abs(stepY.z))));
  const vec3 face = size > 0.0 ? cross(stepX / size, stepY / size) : vec3(0.0);
  outNormal = vec4(facingNormal(normal, face, -relative), 1.0);
  outColour = vec4(push.baseColour.rgb, 1.0);
#ifdef OVERCAST_APERTURE_MAPS
  const vec4 cap = texture(capMap, coordinate);
  const GeometryInstance instance = instances[instanceIndex];
  const vec3 aperture = vec3(dot(instance.rowX.xyz, cap.xyz), dot(instance.rowY.xyz, cap.xyz), dot(instance.rowZ.xyz, cap.xyz));
  const vec2 radiusAmbient = vec2(cap.w * kApertureWidest, texture(ambientMap, coordinate).r);
#endif
#ifdef OVERCAST_APERTURES
  const float squared = dot(aperture, aperture);
  const vec3 axis = squared > 0.0 ? aperture / sqrt(squared) : outNormal.xyz;
  outAperture = aperturePacked(vec4(axis, radiusAmbient.x), radiusAmbient.y);
#endif
#ifdef OVERCAST_TRANSFER
  outSkyLight = max(skyLight, vec4(0.0));
#endif
#ifdef OVERCAST_REST
  outRest = rest;
#endif
}
