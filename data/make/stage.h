// Stage: puts shapes, cameras and motions into a Scene. Motions loop after kLoopSeconds.
#pragma once

#include <string>
#include <vector>

#include "formats/scene.h"

namespace overcast {

inline constexpr double kLoopSeconds = 2.0;  ///< 60 frames at 30 per second
inline constexpr glm::dvec3 kUp{0.0, 1.0, 0.0};

/// Intervals of a sampled motion: straight lines between them differ from the curve by less than a millimetre per metre.
inline constexpr int kMotionKeys = 32;

Scene namedScene(const std::string& name);

/// Where a shape stands and how it is turned.
struct Pose {
  glm::dvec3 translation{0.0};
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};
};

glm::dquat turned(double degrees, const glm::dvec3& axis);

/// `colour` is display-encoded (sRGB), as one picks it; the material holds it linear. Returns the material's index.
int addMaterial(Scene& scene, const std::string& name, const glm::dvec3& colour);

/// Adds the mesh with that material. The same mesh may be shown by several nodes. Returns its index.
int addMesh(Scene& scene, Mesh mesh, int material);

/// Returns the node's index.
int addNode(Scene& scene, const std::string& name, int mesh, const Pose& pose);

/// A node whose lowest point touches y = `ground` below (x, z).
int standNode(Scene& scene, const std::string& name, int mesh, double x, double z, const glm::dquat& rotation = {1.0, 0.0, 0.0, 0.0},
              double ground = 0.0);

/// Makes `child` (a node without a parent) a child of `parent`: it moves with it.
void addChild(Scene& scene, int parent, int child);

/// A slab 0.25 m thick whose top is the plane y = 0, named "ground".
void addGround(Scene& scene, double width, double depth, int material);

void addCamera(Scene& scene, const glm::dvec3& eye, const glm::dvec3& target, double verticalDegrees);

/// Turns the node about a world axis through its origin by `degrees` over the loop, at a steady rate: a multiple of the shape's symmetry.
/// `keys` intervals, each of less than 180 degrees: between keys a turn at a steady rate is exact.
void spin(Scene& scene, int node, const glm::dvec3& axis, double degrees, int keys = kMotionKeys);

/// Sways the node to both sides by `degrees` about a world axis through its origin.
void sway(Scene& scene, int node, const glm::dvec3& axis, double degrees);

/// Carries the node once round the vertical axis through `middle`, starting where it is, rising and falling `bobs` times by `height`.
void orbit(Scene& scene, int node, const glm::dvec3& middle, int bobs, double height);

/// Moves the node along `reach` and back to both sides of where it is, once over the loop, beginning at `phase` of a turn.
void swing(Scene& scene, int node, const glm::dvec3& reach, double phase, int keys = kMotionKeys);

}  // namespace overcast
