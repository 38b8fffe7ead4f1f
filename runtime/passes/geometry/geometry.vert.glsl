#version 460
#include "runtime/passes/geometry/geometry.h"

layout(binding = 0, std430) readonly buffer Vertices { float vertices[]; };
layout(binding = 1, std430) readonly buffer Instances { GeometryInstance instances[]; };
layout(push_constant) uniform Push { GeometryPush push; };

layout(location = 0) out vec3 relative;
layout(location = 1) out vec3 normal;

void main() {
  const int first = gl_VertexIndex * kVertexFloats;
  const vec4 local = vec4(vertices[first], vertices[first + 1], vertices[first + 2], 1.0);
  const vec3 localNormal = vec3(vertices[first + 3], vertices[first + 4], vertices[first + 5]);
  const GeometryInstance instance = instances[gl_InstanceIndex];
  relative = vec3(dot(instance.rowX, local), dot(instance.rowY, local), dot(instance.rowZ, local));
  normal = vec3(dot(instance.normalX.xyz, localNormal), dot(instance.normalY.xyz, localNormal), dot(instance.normalZ.xyz, localNormal));
  gl_Position = push.clipFromRelative * vec4(relative, 1.0);
}
