// Surfels: sky visibility and one bounce of colour from discs on the surfaces (Bunnell 2005, Dynamic Ambient Occlusion and Indirect
// Lighting, GPU Gems 2, chapter 14). Read by C++ and GLSL.
//
// Every surface carries discs with a position, a normal and an area, in trees whose parents stand for what is below them
// (surfel_tree.h). A disc casts shadow from its back and light from its front. Three gathers walk the trees: the first finds each disc's
// accessibility, shadows of shadows included; the second what light reaches it from the fronts of others; the third, for each pixel, counts
// each disc's shadow by its accessibility and takes from the bounced light what the shadowing discs hold back of theirs.
//
// Where we differ: sky visibility is weighted by the cosine, so shadow is the form factor of his equation 14-2 and not his 14-1, which is
// the solid angle; a parent is not marked by a negative area but by its size, for discs far apart in a large cluster are no large disc; and
// pixels are receivers themselves, where he interpolates between vertices. His listing descends within twice the radius of the area, his
// text within four times; we take the text's. All positions are relative to the eye.
#ifndef RUNTIME_PASSES_SURFELS_SURFELS_H
#define RUNTIME_PASSES_SURFELS_SURFELS_H

#include "runtime/passes/screen/screen.h"

OVERCAST_SHARED_BEGIN

/// A disc, or the disc that stands for a subtree; nodes of a tree lie in depth-first order.
struct Surfel {
  vec4 place;   //  0: xyz: centre; w: area / pi, the square of its radius
  vec4 normal;  // 16: xyz: unit; w: index of the next node that is not below this one
  vec4 albedo;  // 32: rgb: base colour; w: square of the radius about the centre that holds all discs below; 0: none are below
};

/// One placed tree.
struct SurfelObject {
  vec4 rowX;    //  0: position relative to the eye x = dot(rowX.xyz, local) + rowX.w
  vec4 rowY;    // 16
  vec4 rowZ;    // 32
  vec4 areaX;   // 48: xyz: first row of the matrix of cofactors, which takes area times normal along; w: square of the largest scale
  vec4 areaY;   // 64
  vec4 areaZ;   // 80
  ivec4 nodes;  // 96: x: first node of the tree in the mesh's, y: how many, z: first node among all placed
};

struct SurfelPush {
  mat4 relativeFromClip;  //  0: positions relative to the eye from clip space, before the division by w; of pixels
  vec4 sky;               // 64: rgb: linear radiance of the sky; w: square of the distance below which a node is entered, in its radii
  ivec4 counts;           // 80: x: placed nodes
};

/// Share of the cosine-weighted hemisphere that a disc takes from one side (equation 14-2): exact on the axis of a parallel disc.
/// `squared` is the distance's square, `area` is divided by pi, the cosines are to the way between both and count from 0 up.
OVERCAST_INLINE float surfelFactor(float squared, float area, float cosReceiver, float cosEmitter) {
  return area * max(cosReceiver, 0.0f) * max(cosEmitter, 0.0f) / (squared + area);
}

/// Whether what is below a node must be looked at, from `squared` away.
OVERCAST_INLINE int surfelEnters(float squared, float area, float size, float nearness) {
  return size > 0.0f && squared < nearness * max(area, size) ? 1 : 0;
}

/// Visibility from the sum of all shadows and that of shadows by accessibility: the first counts shadows of shadows twice, the second
/// leaves out those of three; their mean stands for more passes.
OVERCAST_INLINE float surfelVisibility(float first, float second) {
  return clamp(1.0f - 0.5f * (first + second), 0.0f, 1.0f);
}

OVERCAST_SHARED_END

#endif
