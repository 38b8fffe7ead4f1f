// Ground: pixels laid over surfaces by an affine view, so that pixel and depth are directly a point of the volume and nothing depends on a
// rasteriser.
#pragma once

#include <functional>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "runtime/passes/screen/screen_pass.h"
#include "tests/reference/pyramid.h"

namespace overcast::test {

/// Pixels along each side, and voxels of the fields.
inline constexpr int kGroundSide = 64;

/// What a pixel sees: height y over the point (x, z) of its column, in voxels, and the normal there. Height 0: no surface.
struct Surface {
  double height = 0.0;
  glm::vec3 normal{0.0f, 1.0f, 0.0f};
};
using Ground = std::function<Surface(double x, double z)>;

/// Light and visibility of a pixel.
struct Pixel {
  glm::vec3 light{0.0f};
  float sky = 0.0f;
};

/// From where, and of which volume.
struct GroundView {
  GlobalGrid grid{{0, 0, 0}, 1.0, glm::ivec3(kGroundSide)};
  glm::dvec3 eye{3, 70, -5};
  double left = 0.0, right = kGroundSide;  ///< span of the picture along x and z, voxels
};

/// A view of kGroundSide x kGroundSide pixels straight over the grid, from positions relative to the eye.
glm::dmat4 clipFromRelative(const GroundView& view);

/// Column (x, z) of pixel n.
glm::dvec2 column(std::size_t n, const GroundView& view);

/// The geometry images of that view, base colour white.
GeometryImages uploadGround(const Device& device, const Ground& ground, const GroundView& view);

/// The light image after a screen pass.
std::vector<Pixel> readPixels(const Device& device, const GpuImage& light);

/// `f` at the voxels' centres.
reference::Field groundCube(const std::function<double(const glm::dvec3&)>& f);

/// Ground at y = kGround with a sphere touching it in the middle.
inline constexpr double kGround = 20.0;
inline constexpr double kSphereRadius = 12.0;
double sphereOnGround(const glm::dvec3& p);
Surface groundOnly(double x, double z);

}  // namespace overcast::test
