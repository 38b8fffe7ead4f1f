#include "runtime/terrain_levels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace overcast {
namespace {

/// By how much a transform stretches at most: exact where its columns are at right angles, as turning and scaling leave them, else a bound.
double largestStretch(const glm::dmat4& m) {
  const glm::dvec3 x(m[0]), y(m[1]), z(m[2]);
  const double longest = std::max({glm::length(x), glm::length(y), glm::length(z)});
  const double askew = std::abs(glm::dot(x, y)) + std::abs(glm::dot(y, z)) + std::abs(glm::dot(z, x));
  return askew <= 1e-9 * longest * longest ? longest : std::sqrt(glm::dot(x, x) + glm::dot(y, y) + glm::dot(z, z));
}

/// A group where its mesh lies.
struct Placed {
  glm::dvec3 centre;  ///< relative to the eye
  double radius;
};

Placed placed(const LevelGroup& group, const glm::dmat4& worldFromLocal, double stretch, const LevelView& view) {
  return {glm::dvec3(worldFromLocal * glm::dvec4(glm::dvec3(group.centre), 1.0)) - view.eye, stretch * double{group.radius}};
}

double pixelsOf(const LevelGroup& group, const Placed& ball, double stretch, const LevelView& view) {
  if (group.error == 0.0f) return 0.0;
  const double distance = glm::length(ball.centre) - ball.radius;
  return distance > 0.0 ? view.pixels * stretch * double{group.error} / distance : std::numeric_limits<double>::infinity();
}

/// Inner sides of the picture's pyramid through the eye: points p with dot(p, side) >= 0, unit length.
std::array<glm::dvec3, 4> sidesOf(const glm::dmat4& clipFromRelative) {
  const glm::dmat4 rows = glm::transpose(clipFromRelative);
  std::array<glm::dvec3, 4> sides = {glm::dvec3(rows[3] + rows[0]), glm::dvec3(rows[3] - rows[0]), glm::dvec3(rows[3] + rows[1]),
                                     glm::dvec3(rows[3] - rows[1])};
  for (glm::dvec3& side : sides) side = glm::normalize(side);
  return sides;
}

}  // namespace

LevelView levelView(const View& view, double aspect, int height, double error) {
  LevelView levels;
  levels.eye = eye(view);
  levels.clipFromRelative = clipFromRelative(view, aspect);
  levels.error = error;
  // A length at an angle a off the axis covers up to 1 / cos^2 a as much as on it: most in the corners.
  const double tangent = std::tan(0.5 * view.verticalFieldOfView);
  levels.pixels = 0.5 * height / tangent * (1.0 + tangent * tangent * (1.0 + aspect * aspect));
  return levels;
}

double levelPixels(const LevelGroup& group, const glm::dmat4& worldFromLocal, const LevelView& view) {
  const double stretch = largestStretch(worldFromLocal);
  return pixelsOf(group, placed(group, worldFromLocal, stretch, view), stretch, view);
}

std::vector<TriangleRun> chooseLevels(const MeshLevels& levels, const glm::dmat4& worldFromLocal, const LevelView& view) {
  const double stretch = largestStretch(worldFromLocal);
  const auto sides = sidesOf(view.clipFromRelative);
  std::vector<char> fine(levels.groups.size()), seen(levels.groups.size());
  for (std::size_t g = 0; g < levels.groups.size(); ++g) {
    const Placed ball = placed(levels.groups[g], worldFromLocal, stretch, view);
    fine[g] = pixelsOf(levels.groups[g], ball, stretch, view) <= view.error;
    seen[g] = std::all_of(sides.begin(), sides.end(), [&](const glm::dvec3& side) { return glm::dot(ball.centre, side) >= -ball.radius; });
  }
  std::vector<TriangleRun> runs;
  for (const LevelCluster& cluster : levels.clusters) {
    const bool shown = (cluster.own == kNoLevelGroup || fine[cluster.own]) && (cluster.coarser == kNoLevelGroup || !fine[cluster.coarser]);
    const std::uint32_t around = cluster.own != kNoLevelGroup ? cluster.own : cluster.coarser;
    if (!shown || (around != kNoLevelGroup && !seen[around])) continue;
    if (!runs.empty() && runs.back().first + runs.back().count == cluster.firstTriangle)
      runs.back().count += cluster.triangleCount;
    else
      runs.push_back({cluster.firstTriangle, cluster.triangleCount});
  }
  return runs;
}

}  // namespace overcast
