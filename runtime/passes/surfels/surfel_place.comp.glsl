// One thread per placed node: the mesh's node moved with its object. Work group y is the object.
#version 460
#include "runtime/passes/surfels/surfels.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) readonly buffer Nodes {
  Surfel nodes[];
};
layout(set = 0, binding = 1, std430) readonly buffer Objects {
  SurfelObject objects[];
};
layout(set = 0, binding = 4, std430) writeonly buffer Placed {
  Surfel placed[];
};

void main() {
  SurfelObject object = objects[gl_WorkGroupID.y];
  int node = int(gl_GlobalInvocationID.x);
  if (node >= object.nodes.y) return;
  Surfel local = nodes[object.nodes.x + node];
  vec4 at = vec4(local.place.xyz, 1.0f);
  vec3 area =
      vec3(dot(object.areaX.xyz, local.normal.xyz), dot(object.areaY.xyz, local.normal.xyz), dot(object.areaZ.xyz, local.normal.xyz));
  float grown = length(area);
  Surfel moved;
  moved.place = vec4(dot(object.rowX, at), dot(object.rowY, at), dot(object.rowZ, at), local.place.w * grown);
  moved.normal = vec4(grown > 0.0f ? area / grown : vec3(0.0f), local.normal.w + float(object.nodes.z));
  moved.albedo = vec4(local.albedo.rgb, local.albedo.w * object.areaX.w);
  placed[object.nodes.z + node] = moved;
}
