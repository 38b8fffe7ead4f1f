// Surfel trees: the discs of a mesh and the parents that stand for them (surfels.h).
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "runtime/passes/surfels/surfels.h"

namespace overcast {

/// A disc before it is put into a tree.
struct Disc {
  glm::dvec3 place{0.0};
  double area = 0.0;
  glm::dvec3 facing{0.0};  ///< normals times area
  glm::dvec3 albedo{0.0};  ///< base colour times area
};

/// A triangle and its colour.
struct DiscTriangle {
  glm::uvec3 corners{0};
  glm::vec3 albedo{1.0f};
};

/// One disc for each vertex, with a third of the area of its triangles and their mean normal, where `normals` (none, or one for each
/// vertex, of any length) does not say another. Triangles with edges longer than `longestEdge` are divided evenly first (into at most
/// 64 x 64), so that coarse walls shadow and bounce like fine ones. Discs without area or direction are left out; the others together have
/// the mesh's area.
std::vector<Disc> discsOf(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals, std::span<const DiscTriangle> triangles,
                          double longestEdge);

/// A tree over `discs`, in depth-first order: each node has the total area of what is below it, its mean place and normal weighted by area,
/// and its mean colour; normal.w counts from the first node. Discs are parted by the side their normal faces, then halved along the longest
/// side of their bounds, so that neighbours which face alike share parents. Where there are more than `mostLeaves`, leaves stand for
/// several discs. The same discs give the same tree.
std::vector<shared::Surfel> surfelTree(std::vector<Disc> discs, std::size_t mostLeaves);

}  // namespace overcast
