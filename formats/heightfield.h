// `heightfield`: heights over a rectangle, single sided or two layers back to back, as a signed distance (DESIGN 5.1 no. 3; Evans 2006,
// section 9.8), stored as mipmapped OpenEXR (DESIGN 4).
//
// Field space: x and y along the rectangle, z up, the middle of the field's box at 0. A field without back layer is a sheet: it has no
// inside, its distance is never negative. Of a pair what lies within the rectangle below the front layer and above the back layer is
// inside, and the sides of the box are walls.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "formats/mesh.h"
#include "formats/result.h"

namespace overcast {

/// Mean and variance of the surface's height over one texel, in units of halfExtent.z and of its square. The variance itself and not the
/// second moment: E[z^2] - E[z]^2 loses everything in half floats.
struct HeightTexel {
  float mean = 0.0f;
  float variance = 0.0f;
};

/// One layer with its mip levels: levels[l][i + max(1, size.x >> l) * j], each texel the mean and variance over those below it.
using HeightLevels = std::vector<std::vector<HeightTexel>>;

struct HeightField {
  glm::dmat3 localFromField{1.0};  ///< columns: axes of the field in local space; orthonormal, right-handed
  glm::dvec3 origin{0.0};          ///< local position of the middle of the box
  glm::dvec3 halfExtent{0.0};      ///< of the box in field space, local units; size.x by size.y texels cover its rectangle
  glm::ivec2 size{0};              ///< texels along x and y, powers of two
  HeightLevels front;              ///< the surface seen from +z
  HeightLevels back;               ///< the surface seen from -z; empty when single sided
};

inline constexpr int kHeightFieldVersion = 1;    ///< of the .exr layout, attribute `overcast_version`
inline constexpr int kMinHeightFieldSide = 8;    ///< texels
inline constexpr int kMaxHeightFieldSide = 256;  ///< larger ones are refused

/// Axes orthonormal to 1e-9, everything finite, sizes powers of two within the limits, all levels complete, no negative variance.
bool isWhole(const HeightField& field);

int levelCount(const HeightField& field);                      ///< mip levels, the last one a single texel
glm::ivec2 levelSize(const HeightField& field, int level);     ///< texels of that level
glm::dvec2 cellSize(const HeightField& field, int level = 0);  ///< of one texel, local units

/// Fills levels 1 and up of both layers from level 0 (law of total variance), which is complete.
void buildLevels(HeightField& field);

/// The smallest axis-aligned local box around the field's own, which is turned by localFromField.
Box bounds(const HeightField& field);

/// Texel (i, j) of a layer's level, -1 <= i <= width and so on: one texel beyond each side heights go on straight and variances stay, so
/// that a plane remains one up to the walls.
HeightTexel texelBeyond(const HeightField& field, const HeightLevels& layer, int level, int i, int j);

/// Distance, local units, at `point` (local space, finite), from the texels of `level` and coarser ones. h and its gradient are the
/// quadratic B-spline over the 3 x 3 nearest texels (which smooths heights by cell^2 / 6 times their second derivative), v the variance
/// likewise. `rough` is the squared slope that the variance holds beyond that of a plane, (12 v - sum of (grad h * cell)^2) / (cell.x *
/// cell.y), not below 0: the variance of a plane of slope s over a cell is (s cell)^2 / 12. It widens the falloff where heights scatter
/// (Evans 2006, section 9.8, after Donnelly and Lauritzen's variance maps).
///
/// A sheet: the smaller of two distances. From the point of the surface over the closest point of the rectangle, a horizontally and z - h
/// vertically away,
///   1. the first-order distance, to the closest point over the rectangle of the tangent plane there, its vertical part times
///      sqrt((1 + |grad h|^2) / (1 + |grad h|^2 + rough)); exact for planes;
///   2. that of the point of the surface over that one.
/// The gradient comes from blurred levels, linear between two of them, whose texels are kSheetBlur of |(a, z - h)|: from far away the
/// surface is smooth. Never less than the distance to the box.
///
/// A pair: within the box first order, the largest of
///   front = (z - h) / sqrt(1 + |grad h|^2 + rough),   back = (h_back - z) / sqrt(...),   walls = |x| - halfExtent.x and so on for y and z;
/// outside it goes on as sampleVolume does, the slope taken over the longer side of a finest texel; at the box the distance is
/// never negative, it has walls. Continuous everywhere.
double sampleHeightField(const HeightField& field, const glm::dvec3& point, int level = 0);

inline constexpr double kSheetBlur = 0.35;

/// A lower and an upper bound of a sheet's distance that cost one look at `level`: |(a, z - h)| / S or the distance to the box, and |(a, z
/// - h)|. `field` has no back layer.
glm::dvec2 sheetRange(const HeightField& field, const glm::dvec3& point, int level = 0);

/// What the composite's culling takes its margins from (runtime/passes/composite/composite.h), at least 1.
/// Of a sheet S = sqrt(1 + |grad h|^2 + rough), the largest over this level and those that the search reads, bounded by the B-spline's
/// control values: a Lipschitz constant over all of space of sheetRange's upper bound; its lower bound has 1.
/// Of a pair a Lipschitz constant of sampleHeightField's lower bound: itself within the box, c = 0 beyond it (volume.h). First-order
/// distances lose their slope where that of the surface changes: over each texel |grad phi| <= 1 + |z - h| |grad q| / (2 sqrt(1 + q)^3)
/// with q = |grad h|^2 + rough, each factor bounded by the B-spline's control values. Near 1 for smooth ground, in the hundreds and more
/// where it is steep and jagged.
double lipschitzBound(const HeightField& field, int level = 0);

/// The field as readHeightField gives it back after writeHeightField: texels rounded to half floats. Errors are measured on this.
HeightField asStored(HeightField field);

/// The bytes of the file, deterministic: a mipmapped EXR of half floats with the layers front and, for a pair, back: channels front.mean,
/// front.variance, back.mean, back.variance, attributes overcast_version, overcast_axisX.x to overcast_axisZ.z, overcast_origin.x to .z,
/// overcast_halfExtent.x to .z. `field` is whole.
std::vector<std::byte> encodeHeightField(const HeightField& field);

/// Writes these bytes atomically and returns how many they are.
Result<std::uint64_t> writeHeightField(const std::filesystem::path& path, const HeightField& field);

/// Reads what writeHeightField wrote, to the last bit of the half floats. Parsed in a sandbox. An Error when channels or attributes are
/// missing, a value is out of range (isWhole), or overcast_version is a later one.
Result<HeightField> readHeightField(const std::filesystem::path& path);

}  // namespace overcast
