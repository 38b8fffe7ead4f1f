// Binary tree: orders the triangles of a mesh into patches that the wide tree's leaves are made of. Private to bake (bake/bvh.h).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/vec3.hpp>

namespace overcast {

constexpr int kTreeWidth = 16;     ///< most triangles and most vertices of a leaf, and children of a wide node
constexpr float kFarAway = 1e15f;  ///< where unused slots lie; its square is still a float

/// Four lanes, the last unused: the compiler has vector minima and maxima for them.
using Float4 __attribute__((vector_size(16))) = float;

/// A leaf when `left` is negative, else the right child is left + 1.
struct BinaryNode {
  Float4 low;
  Float4 high;
  std::uint32_t first;  ///< of its triangles in BinaryTree::order
  std::uint32_t count;
  std::int32_t left;
};

/// Half the surface of the node's box.
float area(const BinaryNode& node);

struct BinaryTree {
  std::unique_ptr<BinaryNode[]> nodes;  ///< nodes[0] is the root
  std::vector<std::uint32_t> order;     ///< triangles, leaf by leaf
  /// Per triangle in that order: the places of its corners among the vertices of its leaf, four bits each. Corners at the same position
  /// share a place, so that an unwelded mesh makes leaves as full as a welded one.
  std::vector<std::uint16_t> places;
};

/// Cells of a coarse grid in Morton order for the top levels of large meshes, the binned surface-area heuristic along the longest axis
/// below. The same tree for any thread count but for the numbering of nodes. At most 61 levels.
BinaryTree buildBinaryTree(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles);

}  // namespace overcast
