#include "formats/aperture_map.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "formats/shared/aperture.h"

namespace overcast {
namespace {

bool isShare(float value) {
  return value >= 0.0f && value <= 1.0f;
}

bool isWhole(const ApertureTexel& texel) {
  const double length = glm::length(glm::dvec3(texel.aperture.direction));
  return std::abs(length - 1.0) < 1e-3 && texel.aperture.radius >= 0.0f && texel.aperture.radius <= shared::kApertureWidest &&
         isShare(texel.ambient) && isShare(texel.coverage);
}

/// Light that comes through texels, which unlike directions and radii may be averaged.
struct Light {
  glm::dvec3 visible{0.0};    ///< directions times the share of the hemisphere that is visible
  glm::dvec3 direction{0.0};  ///< directions alone, for texels that see nothing
  double share = 0.0;
  double ambient = 0.0;
  double weight = 0.0;
};

void add(Light& light, const ApertureTexel& texel, double weight) {
  const glm::dvec3 direction(texel.aperture.direction);
  const double sine = std::sin(0.5 * double{texel.aperture.radius});
  const double share = 2.0 * sine * sine;
  light.visible += weight * share * direction;
  light.direction += weight * direction;
  light.share += weight * share;
  light.ambient += weight * double{texel.ambient};
  light.weight += weight;
}

ApertureTexel texelOf(const Light& light, const glm::vec3& fallback, double coverage) {
  ApertureTexel texel;
  const glm::dvec3 mean = glm::length(light.visible) > 0.0 ? light.visible : light.direction;
  texel.aperture.direction = glm::length(mean) > 0.0 ? glm::vec3(glm::normalize(mean)) : fallback;
  texel.aperture.radius = capRadius(light.share / light.weight);
  texel.ambient = static_cast<float>(std::min(light.ambient / light.weight, 1.0));
  texel.coverage = static_cast<float>(std::min(coverage, 1.0));
  return texel;
}

/// The fine texels under a coarse one along one side, and how much of each.
struct Overlap {
  int first = 0;
  int count = 0;
  double share[3] = {};  ///< of the coarse texel; sides halve and round down, so no more than three fine texels lie under one
};

Overlap overlapOf(int fine, int coarse, int i) {
  Overlap overlap{i * fine / coarse, 0, {}};
  const int last = ((i + 1) * fine + coarse - 1) / coarse;
  for (int f = overlap.first; f < last; ++f) {
    // In units of 1 / (fine * coarse) of the side, in which all borders are whole.
    const int low = std::max(i * fine, f * coarse), high = std::min((i + 1) * fine, (f + 1) * coarse);
    overlap.share[overlap.count++] = static_cast<double>(high - low) / fine;
  }
  return overlap;
}

ApertureTexel coarser(const std::vector<ApertureTexel>& fine, int width, const Overlap& across, const Overlap& down) {
  Light covered, all;
  glm::vec3 first(0.0f, 1.0f, 0.0f);
  for (int v = 0; v < down.count; ++v) {
    for (int u = 0; u < across.count; ++u) {
      const ApertureTexel& texel =
          fine[static_cast<std::size_t>(across.first + u) + static_cast<std::size_t>(width) * static_cast<std::size_t>(down.first + v)];
      const double area = across.share[u] * down.share[v];
      if (u == 0 && v == 0) first = texel.aperture.direction;
      add(covered, texel, area * double{texel.coverage});
      add(all, texel, area);
    }
  }
  return texelOf(covered.weight > 0.0 ? covered : all, first, covered.weight);
}

}  // namespace

bool isWhole(const ApertureMap& map) {
  if (map.size.x < 1 || map.size.y < 1 || std::max(map.size.x, map.size.y) > kLargestApertureMapSide) return false;
  if (map.levels.size() != static_cast<std::size_t>(mipmapLevels(map.size.x, map.size.y))) return false;
  if (map.usableLevels < 1 || map.usableLevels > static_cast<int>(map.levels.size())) return false;
  for (std::size_t l = 0; l < map.levels.size(); ++l) {
    const glm::ivec2 size = levelSize(map, static_cast<int>(l));
    if (map.levels[l].size() != static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y)) return false;
    if (!std::all_of(map.levels[l].begin(), map.levels[l].end(), [](const ApertureTexel& texel) { return isWhole(texel); })) return false;
  }
  return true;
}

glm::ivec2 levelSize(const ApertureMap& map, int level) {
  return {std::max(1, map.size.x >> level), std::max(1, map.size.y >> level)};
}

void buildLevels(ApertureMap& map) {
  map.levels.resize(static_cast<std::size_t>(mipmapLevels(map.size.x, map.size.y)));
  for (int l = 1; l < static_cast<int>(map.levels.size()); ++l) {
    const glm::ivec2 fine = levelSize(map, l - 1), size = levelSize(map, l);
    const std::vector<ApertureTexel>& from = map.levels[static_cast<std::size_t>(l - 1)];
    std::vector<ApertureTexel>& level = map.levels[static_cast<std::size_t>(l)];
    level.clear();
    for (int j = 0; j < size.y; ++j)
      for (int i = 0; i < size.x; ++i) level.push_back(coarser(from, fine.x, overlapOf(fine.x, size.x, i), overlapOf(fine.y, size.y, j)));
  }
}

ApertureTexel sampleApertureMap(const ApertureMap& map, const glm::dvec2& coordinate, int level) {
  const glm::ivec2 size = levelSize(map, level);
  const std::vector<ApertureTexel>& texels = map.levels[static_cast<std::size_t>(level)];
  const glm::dvec2 at(std::clamp(coordinate.x, 0.0, 1.0) * size.x - 0.5, std::clamp(coordinate.y, 0.0, 1.0) * size.y - 0.5);
  const glm::ivec2 low(static_cast<int>(std::floor(at.x)), static_cast<int>(std::floor(at.y)));
  glm::dvec3 direction(0.0);
  double radius = 0.0, ambient = 0.0, coverage = 0.0;
  for (int corner = 0; corner < 4; ++corner) {
    const int di = corner & 1, dj = corner >> 1;
    const double wx = di == 1 ? at.x - low.x : 1.0 - (at.x - low.x), wy = dj == 1 ? at.y - low.y : 1.0 - (at.y - low.y);
    const auto i = static_cast<std::size_t>(std::clamp(low.x + di, 0, size.x - 1));
    const auto j = static_cast<std::size_t>(std::clamp(low.y + dj, 0, size.y - 1));
    const ApertureTexel& texel = texels[i + static_cast<std::size_t>(size.x) * j];
    direction += wx * wy * glm::dvec3(texel.aperture.direction);
    radius += wx * wy * double{texel.aperture.radius};
    ambient += wx * wy * double{texel.ambient};
    coverage += wx * wy * double{texel.coverage};
  }
  const double length = glm::length(direction);
  const glm::vec3 unit = length > 0.0 ? glm::vec3(direction / length) : glm::vec3(0.0f, 1.0f, 0.0f);
  return {{unit, static_cast<float>(radius)}, static_cast<float>(ambient), static_cast<float>(coverage)};
}

}  // namespace overcast
