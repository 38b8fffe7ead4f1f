// Geometry: which surface every pixel sees. Read by C++ and GLSL.
//
// Positions reach the GPU relative to the eye, in world axes: single floats are then finest where the picture needs them, also when the
// scene lies far from the world's origin.
#ifndef RUNTIME_PASSES_GEOMETRY_GEOMETRY_H
#define RUNTIME_PASSES_GEOMETRY_GEOMETRY_H

#include "runtime/passes/aperture/sky.h"
#include "runtime/passes/shade/rest.h"

OVERCAST_SHARED_BEGIN

const int kVertexFloats = 6;  ///< position, normal; both relative to the mesh's centre, in its local axes

/// One placed mesh.
struct GeometryInstance {
  vec4 rowX;     //  0: position relative to the eye x = dot(rowX.xyz, local) + rowX.w
  vec4 rowY;     // 16
  vec4 rowZ;     // 32
  vec4 normalX;  // 48: normal.x = dot(normalX.xyz, local normal), of any length: the inverse transpose times a positive number
  vec4 normalY;  // 64
  vec4 normalZ;  // 80
};

/// What the vertices of a placed mesh with transfer (VertexVisibility::transfer) are lit by.
struct TransferInstance {
  SkyLight sky;  //    0: in the mesh's own axes
  ivec4 first;   //  144: x: added to a vertex's index gives that of its transfer; y: 1, or 0 for a mesh without
};

struct GeometryPush {
  mat4 clipFromRelative;  //  0: clip space from positions relative to the eye
  vec4 baseColour;        // 64: linear
};

/// The unit normal to shade with. `normal` is the interpolated one (any length; zero or not finite: there is none), `face` a normal of
/// the flat triangle of either sign, `toViewer` any vector from the surface to the eye. Surfaces are two-sided: the face turns to the
/// viewer and takes the normal with it, so a smooth normal that bends away at a silhouette stays smooth.
OVERCAST_INLINE vec3 facingNormal(vec3 normal, vec3 face, vec3 toViewer) {
  vec3 front = dot(face, toViewer) < 0.0f ? -face : face;
  float squared = dot(normal, normal);
  vec3 chosen = squared > 0.0f && squared < 1.0e30f ? normal : front;
  chosen = dot(chosen, front) < 0.0f ? -chosen : chosen;
  float length2 = dot(chosen, chosen);
  return length2 > 0.0f ? chosen / sqrt(length2) : normalize(toViewer);
}

OVERCAST_SHARED_END

#endif
