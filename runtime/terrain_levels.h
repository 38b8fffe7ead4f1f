// Terrain levels: which clusters of a mesh with levels of detail a frame draws (formats/terrain_levels.h, rule 1).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "formats/camera.h"
#include "formats/terrain_levels.h"

namespace overcast {

/// From where levels are looked at, and how well they must be seen.
struct LevelView {
  glm::dvec3 eye{0.0};
  glm::dmat4 clipFromRelative{1.0};  ///< formats/camera.h
  double pixels = 0.0;               ///< of the picture that a length of 1 at distance 1 covers at most, wherever in the picture
  double error = 1.0;                ///< pixels that the surface may lie beside the finest one; 0 shows the finest
};

/// `height` in pixels, at least 1.
LevelView levelView(const View& view, double aspect, int height, double error);

/// Pixels of a group's error when its mesh lies at `worldFromLocal`: seen from the point of its ball nearest to the eye; infinite when the
/// eye is within it, 0 when there is no error. Never larger for a group than for one that holds it.
double levelPixels(const LevelGroup& group, const glm::dmat4& worldFromLocal, const LevelView& view);

/// A run of triangles, counted as LevelCluster::firstTriangle.
struct TriangleRun {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// The clusters to draw, in order, as the longest runs. Those whose group's ball lies outside the picture may be missing.
std::vector<TriangleRun> chooseLevels(const MeshLevels& levels, const glm::dmat4& worldFromLocal, const LevelView& view);

}  // namespace overcast
