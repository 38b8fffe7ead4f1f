// Winding: the generalised winding number of a set of triangles by a tree of dipoles (Barill et al. 2018, "Fast Winding Numbers for Soups
// and Clouds"), and the surface that fills the holes of a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "bake/edges.h"
#include "bake/lattice.h"

namespace overcast {

/// A set of triangles seen from afar: a dipole and its first moment about `centre`, in lattice units.
struct WindingNode {
  glm::dvec3 centre{0.0};
  double radius = 0.0;     ///< of a ball about the centre that holds all triangles below
  glm::dvec3 area{0.0};    ///< sum of vector areas
  glm::dmat3 moment{0.0};  ///< sum of outer products: moment[j][i] = area_i * (centroid - centre)_j
  double absolute = 0.0;   ///< sum of areas
  int triangle = -1;       ///< index of the node's own triangle, or -1
  std::array<int, 2> children{-1, -1};
};

/// Triangles over lattice points and the tree above them. root is -1 when there is no triangle with an area.
struct WindingTree {
  std::vector<glm::uvec3> triangles;
  std::vector<WindingNode> nodes;
  int root = -1;
};

/// The tree over given triangles, split at spatial medians.
WindingTree windingTree(const std::vector<glm::ivec3>& points, const std::vector<glm::uvec3>& triangles);

/// A surface whose boundary is the opposite of `boundary` (the net boundary of a chain of triangles): together they are closed. Each loop
/// is filled by a triangle over its two halves and so on down to single edges, so that the many small triangles lie near the
/// boundary and every subtree is a closed loop along a piece of it.
WindingTree fillBoundary(const std::vector<glm::ivec3>& points, const std::vector<DirectedEdge>& boundary);

/// Winding numbers at `points` (lattice coordinates, close together: one list of nodes serves all), added to `result` (same size). Nodes
/// are used whole where their error is estimated below `tolerance`. Points on a triangle count as moved by +x, then +y, then +z
/// infinitesimally.
void addWinding(const WindingTree& tree, const std::vector<glm::ivec3>& vertices, std::span<const glm::ivec3> points, double tolerance,
                std::span<double> result);

}  // namespace overcast
