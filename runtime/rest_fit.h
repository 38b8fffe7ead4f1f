// RestFit: values of a field over a surface, put to the vertices so that what is interpolated between them follows it on average. The bake
// of apertures does the same with what vertices of coarse meshes see, so that the two have left out the same.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace overcast {

/// A point of a triangle.
struct SurfaceSpot {
  glm::uvec3 corner;  ///< vertices
  glm::vec3 weight;   ///< barycentric coordinates
  float area;         ///< that it stands for, of any unit
};

/// Points spread evenly over the triangles that have an edge longer than `longest`, the more the longer it is: 4 to 256 on each.
std::vector<SurfaceSpot> spotsOver(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles, float longest);

/// `start` at the vertices, except around spots: there the values in [0, 1] whose interpolation is nearest to `seen` at the spots in the
/// least squares, clamped to what was seen around the vertex. Spots of no area are left out.
std::vector<float> fittedTo(std::vector<float> start, std::span<const SurfaceSpot> spots, std::span<const float> seen);

}  // namespace overcast
