// Bvh: the tree over the triangles of a mesh that the distance kernels traverse. Private to bake.
//
// Inner nodes have sixteen children side by side, so that one packet of samples tests all of them at once. A leaf is a patch of at most
// sixteen triangles over at most sixteen vertices. What a leaf tells about its triangles is their vertices: for a triangle whose smallest
// enclosing circle has radius R, every point q of it and every p satisfy |p - q|^2 >= min_i |p - v_i|^2 - R^2 (q = sum l_i v_i gives
// |p - q|^2 = sum l_i |p - v_i|^2 - sum l_i |q - v_i|^2, and the last sum is at most R^2). Far from the mesh this bound is far tighter than
// any box around the triangle.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "bake/binary_tree.h"
#include "bake/distance.h"
#include "formats/mesh.h"

namespace overcast {

/// Children: an index of a node when not negative, else ~index of a leaf. Unused slots hold a box that is very far away.
struct alignas(64) TreeNode {
  float low[3][kTreeWidth];
  float high[3][kTreeWidth];
  std::int32_t child[kTreeWidth];
};

/// Unused vertices lie very far away, unused triangles have no corners.
struct alignas(64) TreeLeaf {
  float vertex[3][kTreeWidth];
  float slack[kTreeWidth];            ///< R^2 of the largest of the leaf's triangles at the vertex, rounded up
  std::uint32_t corners[kTreeWidth];  ///< per triangle: bits of its vertices
  std::uint32_t firstTriangle;
};

/// A triangle in a frame of its own: corner a at the origin, b at (length0, 0), c above the first axis. With (u, v, w) the coordinates of a
/// point there, the distance to edge k is made of its position along the edge, which runs over [0, length_k], and its distance on the
/// inner side: edge 0: u and v; edge 1: along1 . (u, v) + alongStart1 and inner1 . (u, v) + innerStart1; edge 2: along2 . (u, v) and
/// inner2 . (u, v), where inner1 = (-along1.y, along1.x) and inner2 = (along2.y, -along2.x).
struct TreeTriangle {
  float a[3];      ///< corner a
  float aRest[3];  ///< what the rounding of `a` left over
  float u[3], v[3], w[3];
  float length0, length1, length2;
  float along1[2], alongStart1, innerStart1;
  float along2[2];
};

/// All lengths in voxels, positions relative to the grid's origin.
struct Tree {
  std::vector<TreeNode> nodes;  ///< nodes[0] is the root
  std::unique_ptr<TreeLeaf[]> leaves;
  std::size_t leafCount = 0;
  std::unique_ptr<TreeTriangle[]> triangles;  ///< in the order of the leaves
  std::vector<std::uint32_t> order;           ///< triangles[i] is mesh.triangles[order[i]]
  float positionError = 0.0f;                 ///< bound on the rounding of any coordinate of mesh and grid to float
};

/// Widens the binary tree of bake/binary_tree.h. The same tree for any thread count.
Tree buildTree(const Mesh& mesh, const Grid& grid);

}  // namespace overcast
