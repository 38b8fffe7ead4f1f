// Verify apertures: whether what a mesh carries at its vertices is what can be seen from them.
#pragma once

#include <string>
#include <vector>

#include "bake/scene_apertures.h"

namespace overcast {

/// Rays from each vertex that is looked at; four times the rays of the bake when that is more.
inline constexpr int kVerifyRays = 1024;
inline constexpr std::size_t kVerifyVertices = 2000;  ///< of a mesh; all when it has no more
/// The stated errors come out again, at the same points, to this share of them and this many radians (or share of visibility): what other
/// instruction sets may change in single rays.
inline constexpr double kVerifyApertureTolerance = 0.02;
inline constexpr double kVerifyApertureSlack = 2e-4;

/// One line per finding, each naming the mesh, about all meshes of a baked scene that carry visibility at their vertices; empty when all is
/// well. Two things are held to their word. The stated error of what is interpolated between vertices (formats/aperture_bake.h) comes out
/// again. And vertices show what kVerifyRays fresh rays see there: those that are off by more than the sampling noise of the stated rays
/// (fitted and filled ones may be) have to be what the bake, done again, gives. Positions of `scene` are those the bake had, or these in
/// single floats.
std::vector<std::string> verifyApertures(const Scene& scene);

}  // namespace overcast
