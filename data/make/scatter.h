// Scatter: many objects of a few shapes, placed at random and never meeting, for generated scenes.
#pragma once

#include <vector>

#include "data/make/random.h"
#include "formats/scene.h"

namespace overcast {

/// Shapes to scatter: meshes of the scene, each within a sphere of radius 1 about its origin times `radius`.
struct ShapeSet {
  std::vector<int> meshes;
  double radius = 1.0;
};

/// Seven shapes of low detail in colours by chance, within spheres of `radius`: ball, box, plank, column, ring, cone, cylinder.
ShapeSet addClutterShapes(Scene& scene, Random& random, double radius);

/// Eight shapes with proportions by chance, knots and stars among them.
ShapeSet addRandomShapes(Scene& scene, Random& random, double radius);

/// Where the objects are to be. They stay `radius` within it at the sides, and below its top.
struct ScatterRegion {
  glm::dvec2 min{0.0};  ///< x, z
  glm::dvec2 max{0.0};
  double top = 0.0;          ///< y; objects fly between the ground and here
  double groundShare = 0.5;  ///< at most this share stands on the ground y = 0, and never so many that they cover more than a third
  double smallest = 1.0;     ///< objects are scaled by chance between this and 1
  double movingShare = 1.0;  ///< of the objects that move: on the ground they turn, above it they tumble, or rise and fall
};

/// Places up to `count` objects, fewer where no room is left; returns how many. Spheres of ShapeSet::radius round them never meet, also
/// while they move.
int scatter(Scene& scene, Random& random, const ShapeSet& shapes, const ScatterRegion& region, int count);

}  // namespace overcast
