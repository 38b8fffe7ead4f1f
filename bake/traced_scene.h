// Traced scene: all surfaces of a scene at one moment, ready for rays. Private to bake.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "bake/aperture.h"
#include "bake/sky_image.h"
#include "bake/visibility.h"
#include "formats/result.h"
#include "formats/scene.h"

namespace overcast {

/// A light as it stands in the world.
struct TracedLight {
  glm::dvec3 place{0.0};     ///< centre, or for the sun the unit vector towards it
  double radius = 0.0;       ///< metres; of the sun radians
  glm::dvec3 radiance{0.0};  ///< linear
  bool sun = false;
};

/// Every node with a mesh blocks light, from both sides. Lights block nothing.
struct TracedScene {
  Mesh mesh;                      ///< world space, of all nodes; triangles of mirrored nodes turned, so that outside stays outside. Normals
                                  ///< as the inverse transpose makes them, of any length; zero where there is none
  std::vector<int> node;          ///< of each triangle
  std::vector<glm::vec3> colour;  ///< base colour of each triangle
  std::vector<TracedLight> lights;
  glm::dvec3 sky{0.0};                 ///< radiance from all around, or the mean of `skyImage`
  const SkyImage* skyImage = nullptr;  ///< null: none
  glm::dvec3 up{0.0, 1.0, 0.0};
  RayScenePointer rays;  ///< of `mesh`; its triangle i is here triangle i
};

/// The scene at `time` seconds, under `skyImage` (which must outlive it) instead of its own sky when that is not null. An Error without a
/// file when it has no surface or memory runs out.
Result<TracedScene> makeTracedScene(const Scene& scene, double time, const SkyImage* skyImage = nullptr);

/// A point to look from, on the side of `towards`.
struct TracedSurface {
  std::uint32_t triangle = 0;
  glm::dvec3 position{0.0};  ///< world space, on the triangle
  glm::dvec3 face{0.0};      ///< unit, of the flat triangle
  glm::dvec3 normal{0.0};    ///< unit, to shade with: as facingNormal of the runtime's geometry pass has it
  glm::vec3 start{0.0f};     ///< where rays start, in units of the ray scene
};

/// The point with these barycentric coordinates, seen from where `towards` points (any length). Rays start on the smooth surface that the
/// normals suggest (liftAt), so that the flat triangles of a round shape do not darken it in facets, unless something lies between that
/// and the triangle; then, as on flat shapes and when not `smooth`, on the triangle. In either case kRayOffset of the scene's diagonal off
/// it and as far towards the viewer.
TracedSurface surfaceAt(const TracedScene& scene, const SurfaceSample& sample, const glm::dvec3& towards, bool smooth = true);

/// What the ray from `origin` (world space) along unit `direction` meets first at `nearest` metres or beyond, and how far off.
struct TracedHit {
  TracedSurface surface;
  double distance = 0.0;  ///< metres
};
std::optional<TracedHit> firstHit(const TracedScene& scene, const glm::dvec3& origin, const glm::dvec3& direction, double nearest);

/// Whether most of the hemisphere about the surface shows backs of triangles: it lies within a solid.
bool liesInside(const TracedScene& scene, const TracedSurface& surface);

}  // namespace overcast
