// Aperture fit: values at the vertices of a coarse mesh whose interpolation comes nearest to the surface (Kavan, Bargteil and Sloan 2011,
// "Least Squares Vertex Baking").
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "bake/aperture.h"

namespace overcast {

/// One observation: what is seen at barycentric coordinates `weight` between three unknowns.
struct FitSample {
  glm::uvec3 corner{0};
  glm::dvec3 weight{1.0, 0.0, 0.0};
  ApertureSample seen;
};

/// Minimises the squares of (interpolated - seen) over the samples, plus a little of the squared difference to `start` and between
/// neighbours (the edges of `triangles`), each component by itself; then clamps every component to the range that the samples around its
/// vertex show, its own start included, and makes directions unit. Vertices without samples follow start and neighbours. The same result
/// for any number of threads. `start` is not empty; corners and triangles index it.
std::vector<ApertureSample> fitApertures(std::span<const ApertureSample> start, std::span<const glm::uvec3> triangles,
                                         std::span<const FitSample> samples);

}  // namespace overcast
