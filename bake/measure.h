// Measure: the error that an asset makes against the exact distance to its source mesh, and what a light sees of it. The same points for
// every representation and size of a mesh, so that their figures compare.
//
// With D the diagonal of the mesh's box, method "influence-2" takes for `samples` points of a seed:
//  * evenly random points of the box grown by D on every side, the influence radius: `rms` and `p99` of |phi - exact|.
//  * evenly random points of the box grown by 5 sigma and no further than 5 sigma from the surface, sigma = 0.02 D, weighted by
//    w = exp(-|exact| / sigma): surfaceRms = sqrt(sum w (phi - exact)^2 / sum w). Drawn until (sum w)^2 / sum w^2 reaches an eighth of
//    `samples`, from at most 16 * `samples` points of the grown box.
//  * of both sets `max`, and `signErrors`: points over 0.01 D from the surface on the wrong side of it.
//  * samples / 16 receivers on the ground (the plane below the box, its rectangle grown by D / 2) facing up, and as many on a sphere of
//    radius 0.6 D about the middle of the box facing it: `skyRmse` is the root mean square difference between the sky visibility that
//    `published` (runtime/passes/shade/shade.h, DESIGN 5.4) gives with the asset and with the exact distance, its constants those of a new
//    scene (formats/lighting.h), the first tap at D / 64 (a voxel of 128 along two diagonals), phi not blurred and joined with the
//    receiver's own plane.
// Where the winding number decides nothing (0.2 < |w| < 0.8: about an open sheet) the sign is a matter of opinion: there phi is compared
// with the exact distance in the sign that phi has, and no sign is an error. Of a mesh that is mostly such a sheet (kSheet), larger |w| is
// but a hollow of it and decides nothing either. So is where a solid behind a sheet would end, which is what sets "influence-2" apart from
// its predecessor: a terrain may be a block as well as a sheet in the air, and a light sees the difference only from places where nothing
// is known. Of a mesh that is not closed, points behind it (w > 0.02 on the side that phi takes for solid, which is the sign of the sum of
// w over the points near the surface where phi < 0) and points whose nearest place is on a boundary edge have an error only where |phi|
// exceeds the exact distance, which no surface that holds the mesh can do, or where phi is outside although inside is decided; they
// count for surfaceRms only with such an error. Taps of receivers there likewise. A volume that states sheets is compared with the field of
// bake/sheets.h in the thickness it states instead: two sides leave no sign open.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include <glm/vec3.hpp>

#include "bake/prepare.h"
#include "bake/repair.h"
#include "bake/sheets.h"
#include "formats/asset.h"
#include "formats/mesh.h"
#include "formats/occluder.h"

namespace overcast {

inline constexpr const char* kMeasureMethod = "influence-2";

/// Share of the points near the surface with 0.2 < |w| < 0.8 above which a mesh is a sheet: it has no inside but by opinion.
inline constexpr double kSheet = 0.25;

struct MeasureSettings {
  std::uint64_t samples = 4096;
  std::uint64_t seed = 1;
};

/// One point that receives light from the sky.
struct Receiver {
  glm::dvec3 point{0.0};
  glm::dvec3 normal{0.0, 1.0, 0.0};
};

/// The points for one mesh, in its local space, with the exact distance (distanceAt) and the winding number (windingAt) at each.
struct Probes {
  MeasureSettings settings;
  MeshDiagnosis found;
  double ambiguousSign = 0.0;       ///< share of the points near the surface with 0.2 < |w| < 0.8: inside is a matter of opinion
  double diagonal = 0.0;            ///< of the mesh's box
  std::vector<glm::dvec3> points;   ///< `samples` of the influence region, then those near the surface, then the taps of each receiver
  std::vector<double> exact;        ///< at each of the points, not negative
  std::vector<double> winding;      ///< likewise; inside where it exceeds a half either way
  std::vector<std::uint8_t> atRim;  ///< 1 where the nearest place of the mesh is on a boundary edge; empty when it is closed
  std::size_t nearEnd = 0;          ///< index behind the last point near the surface
  std::vector<Receiver> receivers;  ///< every second one on the ground
  std::shared_ptr<const PreparedMesh> prepared;
  std::shared_ptr<const SheetTable> table;
};

/// Draws the points and takes the exact distances. Costs two trees over the mesh and a query per point; the mesh has a triangle and an
/// extent, samples at least 1. Runs on the calling TBB arena; same result for any thread count.
Probes drawProbes(const Mesh& mesh, const MeasureSettings& settings);

/// What evaluates an occluder: local units, safe to call from several threads.
using DistanceFunction = std::function<double(const glm::dvec3&)>;

/// The error of `distance`, from the first `share` (0 to 1] of the points of each kind; `samples` says how many that were of the first
/// kind. Same result for any thread count.
MeasuredError measure(const DistanceFunction& distance, const Probes& probes, double share = 1.0);

/// The mesh of the probes, centred, as `volume` took it apart: by the thickness and the inside that it states.
SheetParts sheetParts(const Volume& volume, const Probes& probes);
MeasuredError measure(const Asset& asset, const Probes& probes, double share = 1.0);

}  // namespace overcast
