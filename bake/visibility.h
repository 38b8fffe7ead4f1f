// Visibility: what points of a surface see past a mesh, from one pass of rays each (Embree; Oat and Sander 2006, section 8.3; DESIGN 5.5).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "bake/progress.h"
#include "formats/mesh.h"
#include "formats/result.h"

namespace overcast {

inline constexpr std::size_t kRayPacket = 16;  ///< rays come in packets of so many
inline constexpr int kMostRays = 1 << 20;

struct VisibilitySettings {
  int rays = 256;         ///< per point, rounded up to whole packets, at most kMostRays. Presets: 128, 256, 1024
  bool transfer = false;  ///< PointVisibility::transfer is wanted
};

/// A point of a surface and the side to look from, in the space of the occluding mesh.
struct SurfacePoint {
  glm::dvec3 position{0.0};
  glm::vec3 normal{0.0f, 0.0f, 1.0f};  ///< unit
};

/// What a point sees over the hemisphere about its normal. Where nothing is hit, exactly 1, 1, the normal and the normal.
struct PointVisibility {
  float visible = 0.0f;                   ///< share of the hemisphere's solid angle in which nothing is hit, a multiple of 1 / rays
  float ambient = 0.0f;                   ///< the same weighted by the cosine to the normal: 1 minus ambient occlusion, [0, 1]
  glm::vec3 direction{0.0f, 0.0f, 1.0f};  ///< mean visible direction, unit; the normal when nothing is visible
  glm::vec3 bent{0.0f, 0.0f, 1.0f};       ///< the same weighted by the cosine: the bent normal
  bool interior = false;                  ///< more than half of all directions meet the back of a triangle: the point lies in a solid
  std::array<float, 9> transfer{};        ///< as VertexVisibility::transfer; zeros unless asked for
};

struct RayScene;
struct RaySceneRelease {
  void operator()(RayScene* scene) const;
};
using RayScenePointer = std::unique_ptr<RayScene, RaySceneRelease>;

/// A mesh ready for rays: recentred in double and scaled to a diagonal of 1, so that place and scale change nothing. An Error without a
/// file when it has no extent or memory runs out. The mesh is copied. Scenes that are to see each other are made with one of them as
/// `family`.
Result<RayScenePointer> makeRayScene(const Mesh& mesh, const RayScene* family = nullptr);

/// Another mesh about one.
struct Neighbour {
  const RayScene* scene = nullptr;
  glm::dmat4 hereFromThere{1.0};  ///< from its space to that of the mesh it is a neighbour of; left out where it flattens
};

struct Surroundings;
struct SurroundingsRelease {
  void operator()(Surroundings* around) const;
};
using SurroundingsPointer = std::unique_ptr<Surroundings, SurroundingsRelease>;

/// The neighbours of the mesh of `scene`, of its family, ready for rays. They must outlive it. An Error when memory runs out.
Result<SurroundingsPointer> surround(const RayScene& scene, std::span<const Neighbour> neighbours);

/// What rays can meet: the mesh that the points lie on, in whose space they and their directions are, and what is around it.
struct Occluders {
  const RayScene* self = nullptr;
  const Surroundings* others = nullptr;  ///< null: nothing
};

/// What each point sees. Rays are uniform in solid angle: a spherical Fibonacci set (Keinert et al. 2015) turned about the normal by an
/// angle that point i of the span has for itself, drawn from i alone. They start kRayOffset of the mesh's diagonal above the surface: far
/// enough to leave the triangles the point lies on behind in single floats, near enough for the error to stay below 0.002 (MEASURED 4).
/// Points that see next to nothing are looked at twice, a little turned, so that no single ray slips out between two triangles.
/// Points are worked on in Morton order on all threads; the result does not depend on how many there are. A stopped `progress` leaves the
/// rest untouched.
std::vector<PointVisibility> traceVisibility(const Occluders& occluders, std::span<const SurfacePoint> points,
                                             const VisibilitySettings& settings, const Progress& progress = {});
inline constexpr double kRayOffset = 4e-6;

/// The directions of traceVisibility before they are turned: z up, uniform over the hemisphere in sorted packets of kRayPacket
/// neighbours. [i] for i below `rays` rounded up to whole packets.
std::vector<glm::dvec3> hemisphereDirections(int rays);

/// Angle by which the directions of point `index` are turned about its normal, [0, 2 pi).
double azimuthOf(std::uint64_t index);

/// Columns x, y, z of the frame of a unit normal z (Duff et al. 2017, "Building an Orthonormal Basis, Revisited"), turned by `azimuth`.
std::array<glm::dvec3, 3> frameOf(const glm::dvec3& normal, double azimuth);

/// Order in which to visit points so that neighbours follow each other: along a Morton curve of 21 bits per axis over their box.
std::vector<std::uint32_t> mortonOrder(std::span<const SurfacePoint> points);

}  // namespace overcast
