// Aperture: visibility baked into the vertices of a mesh (DESIGN 4, 5.5; Oat and Sander 2006, section 8.3).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "bake/progress.h"
#include "bake/visibility.h"
#include "formats/aperture.h"
#include "formats/mesh.h"
#include "formats/result.h"

namespace overcast {

struct ApertureSettings {
  VisibilitySettings visibility;
  ApertureBits bits = ApertureBits::packed32;
  std::uint64_t errorSamples =
      4096;                ///< points of the surface at which the interpolated result is measured; 0: not measured, nothing fitted
  std::uint64_t seed = 1;  ///< of these points
};

/// Root mean squares over the surface of what a renderer interpolates between vertices against what is visible there.
struct InterpolationError {
  double radius = 0.0;     ///< radians
  double ambient = 0.0;    ///< of the cosine-weighted visibility
  double direction = 0.0;  ///< radians, over points that see something
};

/// What was found and made.
struct ApertureReport {
  std::uint64_t vertices = 0;
  std::uint64_t points = 0;    ///< distinct places and normals among them
  std::uint64_t interior = 0;  ///< vertices in a solid, filled from their neighbours where they have any outside
  std::uint64_t inward = 0;    ///< in solids or seeing nothing, but seeing sky from their other side: their triangles face inward
  std::uint64_t shut = 0;      ///< vertices that see nothing: normal and radius 0
  std::uint64_t rays = 0;      ///< traced in all
  double seconds = 0.0;
  std::uint64_t samples = 0;   ///< points of the measurement that lie outside of solids
  InterpolationError sampled;  ///< of visibility taken at the vertices alone
  InterpolationError error;    ///< of what is stored: fitted where that was better, rounded to its codes
  bool fitted = false;
};

struct BakedApertures {
  VertexVisibility visibility;  ///< as stored, but for `ambient`, which is there for packed32 too
  ApertureReport report;
};

/// Bakes what the vertices of `mesh` see past `occluders`, of which the mesh is one. The mesh has a triangle with an extent and unit
/// normals, one per position. Vertices with the same position and normal get the same, so that seams of other attributes do not show. A
/// vertex looks from kVertexPull of the diagonal within its triangles, else it would lie in the plane of the wall behind a sharp edge. On
/// coarse meshes, where interpolation is further off than kCoarse, vertices are fitted to the surface (bake/aperture_fit.h) if that lowers
/// the error at points the fit has not seen. The reported errors are measured at others again. The same result for any order of the
/// vertices, but for ties and the fit. When `progress` stops the job, the result is of no use.
BakedApertures bakeApertures(const Mesh& mesh, const Occluders& occluders, const ApertureSettings& settings, const Progress& progress = {});

/// The same for a mesh by itself. An Error without a file when it has no extent or there is no memory.
Result<BakedApertures> bakeApertures(const Mesh& mesh, const ApertureSettings& settings, const Progress& progress = {});

/// The error of what `mesh` carries (visibility with apertures, normals) as bakeApertures with these settings reports it. Without its
/// ambient visibility, which packed32 does not store, the error of that means nothing.
InterpolationError measureApertures(const Mesh& mesh, const Occluders& occluders, const ApertureSettings& settings);

inline constexpr double kVertexPull = 2e-6;
inline constexpr double kCoarse = 0.02;  ///< radians of radius, or share of ambient visibility

/// What one vertex, or a point between vertices, shows.
struct ApertureSample {
  glm::dvec3 direction{0.0, 0.0, 1.0};
  double radius = 0.0;
  double ambient = 0.0;
  std::array<double, 9> transfer{};
};

/// What a vertex carries, and what rays see from where its bake looked from.
struct VertexLook {
  std::uint32_t vertex = 0;
  ApertureSample stored;  ///< ambient 0 and transfer zeros where these are not stored
  ApertureSample seen;
};

/// Looks from `count` of the mesh's distinct points (all if there are no more), drawn with `seed`, with rays that the bake did not send.
/// The mesh carries apertures and normals.
std::vector<VertexLook> lookAgain(const Mesh& mesh, const Occluders& occluders, const VisibilitySettings& settings, std::size_t count,
                                  std::uint64_t seed);

/// A point of the surface as a renderer shades it: barycentric coordinates in a triangle, and the interpolated normal.
struct SurfaceSample {
  std::uint32_t triangle = 0;
  glm::dvec3 weight{1.0, 0.0, 0.0};
};

ApertureSample sampleOf(const PointVisibility& seen);

/// Of pairs of what is shown, whose directions may have any length, and what is seen there. Zeros when there are none.
InterpolationError interpolationError(std::span<const std::pair<ApertureSample, ApertureSample>> shownAndSeen);

/// Points evenly at random over the area of the triangles; the same on every machine. Empty when there is no area.
std::vector<SurfaceSample> sampleSurface(const Mesh& mesh, std::uint64_t count, std::uint64_t seed);

/// How far a point of a triangle lies from the smooth surface that unit (or zero) normals at its corners suggest, outwards (Hanika 2021,
/// "Hacking the Shadow Terminator"). Zero at corners and where that surface is hollow.
glm::dvec3 liftAt(const std::array<glm::dvec3, 3>& corners, const std::array<glm::dvec3, 3>& normals, const glm::dvec3& weight);

/// Where to look from at a sample: the interpolated normal and the point on the smooth surface (liftAt), so that flat triangles do not hide
/// the sky from normals that are bent away from them.
SurfacePoint surfacePoint(const Mesh& mesh, const SurfaceSample& sample);

}  // namespace overcast
