// `radius`: a star shape as its radius over directions about a centre, |p - centre| = r(direction), on a cube map with mipmap levels
// (DESIGN 4, 5.1 no. 4; Evans 2006, section 9.8). Stored as OpenEXR with the attribute `envmap` = cube.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "formats/mesh.h"
#include "formats/result.h"

namespace overcast {

/// What is known of the surface around the direction of one texel, local units.
struct RadiusTexel {
  float mean = 0.0f;      ///< mean distance of the surface from the centre, positive
  float variance = 0.0f;  ///< of that distance over the texel's footprint: second moment minus mean squared, kept apart from them because
                          ///< their difference loses everything in half floats (PITFALLS "Numbers")
  glm::vec3 slope{0.0f};  ///< how steep the surface is here, per radian, see derive; not stored
};

/// Six faces of side x side texels in the order and places of formats/shared/cube_map.h: texel[i + side * (j + side * face)]. Texels on
/// edges and corners of the cube are the same on all faces that share them.
struct RadiusLevel {
  int side = 0;
  std::vector<RadiusTexel> texel;
  // Derived from the texels by derive(), not stored:
  double smallest = 0.0;  ///< of mean - sqrt(3 variance), the least radius of a slope with that variance; at least half of the least mean
  double largest = 0.0;   ///< of mean + sqrt(3 variance)
  double steepest = 0.0;  ///< bound of the gradient over directions of the interpolated mean, per radian
  double gentlest = 1.0;  ///< the least share of |v| that a distance is, see sampleRadius
  Box box;  ///< around the surface |p| = r(direction) as interpolated, about the centre, with a margin of kRadiusPadding of the largest
            ///< radius
};

/// levels[0] has kSmallestRadiusSide .. kLargestRadiusSide texels along a face, a power of two, every next level half of it, the last 2.
struct RadiusField {
  glm::dvec3 centre{0.0};  ///< local space
  std::vector<RadiusLevel> levels;
};

/// Place of texel (i, j) of a face, texels of six faces, and the direction of a texel (on the cube [-1, 1]^3, the same for shared texels).
std::size_t texelIndex(int side, unsigned face, int i, int j);
std::size_t texelCount(int side);
glm::dvec3 texelDirection(int side, unsigned face, int i, int j);

/// Of the texels that share the place nearest to `direction` the one that stands for all: that on the face that cubeFace names.
std::size_t texelTowards(int side, const glm::dvec3& direction);

/// Width of a texel around the unit vector `direction`, radians: the square root of the solid angle of a cell.
double texelAngle(int side, const glm::dvec3& direction);

inline constexpr int kRadiusVersion = 1;  ///< version of the .exr layout, stored as the attribute `overcast_version`
inline constexpr int kSmallestRadiusSide = 8;
inline constexpr int kLargestRadiusSide = 128;
/// Up to this share of a level's smallest radius about the centre, the distance is drawn out linearly from its value at the centre: there
/// directions turn too fast for the first-order formula.
inline constexpr double kRadiusCore = 0.9;
/// Largest ratio of largest to smallest radius: beyond it the centre is as good as on the surface.
inline constexpr double kLargestRadiusRatio = 1e4;

/// Sides and counts as above, means positive and finite within kLargestRadiusRatio, variances finite and not negative, slopes finite, what
/// is derived as derive() gives.
bool isWhole(const RadiusField& field);

/// Fills in what is derived of every level from mean and variance; all are positive, finite and as many as the sides say. Of a slope the
/// part across the texel's direction is the gradient of the means over directions (central differences one texel each way, right across
/// edges of the cube); the part along the direction makes its length that of the slope which would give the stored variance over the
/// texel's footprint, where that is larger. On smooth surfaces there is none; on rough ones, and on the blurred levels, the variance widens
/// the falloff (Evans 2006, section 9.8).
void derive(RadiusField& field);

/// The box of the finest level, local space.
Box bounds(const RadiusField& field);
inline constexpr double kRadiusPadding = 0.125;

/// Distance at `point` (local space, finite), local units, by a short search for the closest point of the surface |p| = r(direction) of
/// `level`. With rho = |p - centre|, at least rho_0 = kRadiusCore r_min, v = rho - r towards the point and g the slope there:
///   1. the first-order distance |v| / sqrt(1 + |g|^2 / (r rho)), which is that of DESIGN 5.1 at the surface and, far from it, what one
///      Newton step of the squared distance over directions gains;
///   2. that of the point of the surface in the direction where this step ends.
/// The smaller of both is the distance. r and g of the step come from blurred levels, linear between two of them, whose texels are
/// kRadiusBlur of |v|: from far away the surface is smooth. Negative where v is. It is kept within what is known for sure:
/// -r_min - rho and rho - r_max from below, rho - r_min from above, the distance to the level's box from below, and gentlest |v| from
/// below: gentlest = 1 / sqrt(1 + k^2 / (rho_0 r_min)) with k the larger of pi / 2 steepest (a surface that is nowhere steeper has no
/// nearer point) and the longest slope of this level and the coarser ones. Towards the centre, within rho_0, linear between -r_min (exact)
/// at the centre and the value at rho_0. Continuous everywhere.
double sampleRadius(const RadiusField& field, const glm::dvec3& point, int level = 0);

inline constexpr double kRadiusBlur = 0.25;

/// A lower and an upper bound of sampleRadius that cost one look at `level`: what is known for sure, and v instead of the distance.
glm::dvec2 radiusRange(const RadiusField& field, const glm::dvec3& point, int level = 0);

/// A Lipschitz constant over all of space of both bounds of radiusRange, at least 1: sqrt(1 + (steepest / rho_0)^2). The composite's
/// culling takes its margins from it (runtime/passes/composite/composite.h).
double lipschitzBound(const RadiusField& field, int level = 0);

/// The field as readRadius gives it back after writeRadius: means and variances rounded, falloffs derived from these.
RadiusField asStored(RadiusField field);

/// The bytes of the file: half-float channels `radius` and `variance`, scaled so that half floats keep their detail: r = overcast_offset +
/// overcast_scale * radius with radius in [-1, 1], variance in units of overcast_scale^2; centre as overcast_centre_x, _y, _z. Texels are
/// where OpenEXR expects them in a cube map. The same field gives the same bytes. `field` is whole.
std::vector<std::byte> encodeRadius(const RadiusField& field);

/// Writes these bytes atomically and returns how many they are.
Result<std::uint64_t> writeRadius(const std::filesystem::path& path, const RadiusField& field);

/// Reads what writeRadius wrote. Parsed in a sandbox. An Error when it is not a mipmapped cube map with these channels and numbers, a side
/// is not a power of two within the limits, a radius is not positive and finite, or its version is a later one.
Result<RadiusField> readRadius(const std::filesystem::path& path);

}  // namespace overcast
