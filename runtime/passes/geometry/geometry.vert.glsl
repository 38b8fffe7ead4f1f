// OVERCAST_APERTURES: with each vertex's aperture (8-byte packing, local space), turned into the world. OVERCAST_APERTURE_MAPS: with its
// texture coordinates, which lie in the place of the aperture.
// OVERCAST_TRANSFER: with the sky light of vertices that have transfer.
// OVERCAST_REST: with the vertices' sky visibility at rest.
#version 460
#include "runtime/passes/geometry/geometry.h"

layout(binding = 0, std430) readonly buffer Vertices {
  float vertices[];
};
layout(binding = 1, std430) readonly buffer Instances {
  GeometryInstance instances[];
};
#ifdef OVERCAST_APERTURES
#include "formats/shared/aperture.h"
layout(binding = 2, std430) readonly buffer Apertures {
  uvec2 apertures[];
};
#ifdef OVERCAST_APERTURE_MAPS
layout(location = 2) out vec2 coordinate;
layout(location = 3) flat out uint instanceIndex;
#else
layout(location = 2) out vec3 aperture;
layout(location = 3) out vec2 radiusAmbient;
#endif
#endif
#ifdef OVERCAST_TRANSFER
layout(binding = 5, std430) readonly buffer Transfers {
  float transfers[];
};  // 9 for each vertex
layout(binding = 6, std430) readonly buffer TransferInstances {
  TransferInstance transferInstances[];
};
layout(location = 5) out vec4 skyLight;
#endif
#ifdef OVERCAST_REST
layout(binding = 7, std430) readonly buffer RestValues {
  float restValues[];
};
layout(binding = 8, std430) readonly buffer RestInstances {
  RestInstance restInstances[];
};
layout(location = 6) out vec2 rest;
#endif
layout(push_constant) uniform Push {
  GeometryPush push;
};

layout(location = 0) out vec3 relative;
layout(location = 1) out vec3 normal;

void main() {
  const int first = gl_VertexIndex * kVertexFloats;
  const vec4 local = vec4(vertices[first], vertices[first + 1], vertices[first + 2], 1.0);
  const vec3 localNormal = vec3(vertices[first + 3], vertices[first + 4], vertices[first + 5]);
  const GeometryInstance instance = instances[gl_InstanceIndex];
  relative = vec3(dot(instance.rowX, local), dot(instance.rowY, local), dot(instance.rowZ, local));
  normal = vec3(dot(instance.normalX.xyz, localNormal), dot(instance.normalY.xyz, localNormal), dot(instance.normalZ.xyz, localNormal));
#if defined(OVERCAST_APERTURE_MAPS)
  coordinate = uintBitsToFloat(apertures[gl_VertexIndex]);
  instanceIndex = uint(gl_InstanceIndex);
#elif defined(OVERCAST_APERTURES)
  const uvec2 code = apertures[gl_VertexIndex];
  const vec4 cap = apertureFromWords(code.x, code.y);
  aperture = normalize(vec3(dot(instance.rowX.xyz, cap.xyz), dot(instance.rowY.xyz, cap.xyz), dot(instance.rowZ.xyz, cap.xyz)));
  radiusAmbient = vec2(cap.w, ambientFromWord(code.y));
#endif
#ifdef OVERCAST_TRANSFER
  skyLight = vec4(0.0);
  const ivec4 its = transferInstances[gl_InstanceIndex].first;
  if (its.y != 0) {
    const int transfer = 9 * (gl_VertexIndex + its.x);
    for (int i = 0; i < 9; ++i) skyLight += transfers[transfer + i] * transferInstances[gl_InstanceIndex].sky.coefficients[i];
    skyLight.w = 1.0;
  }
#endif
#ifdef OVERCAST_REST
  const RestInstance own = restInstances[gl_InstanceIndex];
  rest = vec2(own.shift == kNoRestValues ? 1.0 : restValues[gl_VertexIndex + own.shift], own.trust);
#endif
  gl_Position = push.clipFromRelative * vec4(relative, 1.0);
}
