#include "formats/radius.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "formats/shared/cube_map.h"

namespace overcast {
namespace {

struct MeanAndFalloff {
  double mean;
  double falloff;
};

/// Bilinear interpolation in a direction of any length.
MeanAndFalloff interpolate(const RadiusLevel& level, const glm::dvec3& direction) {
  const glm::vec3 d(direction / std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z), 1e-300}));
  const unsigned face = shared::cubeFace(d);
  const glm::dvec2 at = (glm::dvec2(shared::cubeCoordinates(face, d)) * 0.5 + 0.5) * double(level.side - 1);
  const glm::ivec2 cell = glm::clamp(glm::ivec2(at), glm::ivec2(0), glm::ivec2(level.side - 2));
  const glm::dvec2 t = at - glm::dvec2(cell);
  const std::size_t first = texelIndex(level.side, face, cell.x, cell.y), next = first + static_cast<std::size_t>(level.side);
  const auto mix = [&](auto value) {
    const double low = value(level.texel[first]) * (1.0 - t.x) + value(level.texel[first + 1]) * t.x;
    const double high = value(level.texel[next]) * (1.0 - t.x) + value(level.texel[next + 1]) * t.x;
    return low * (1.0 - t.y) + high * t.y;
  };
  return {mix([](const RadiusTexel& texel) { return double{texel.mean}; }),
          mix([](const RadiusTexel& texel) { return double{texel.falloff}; })};
}

double firstOrderDistance(const RadiusLevel& level, const glm::dvec3& fromCentre) {
  const double rho = glm::length(fromCentre), core = kRadiusCore * level.smallest;
  const double s = std::max(rho, core);
  const MeanAndFalloff here = interpolate(level, fromCentre);
  const double lowest = std::max(-level.smallest - s, s - level.largest);
  const double phi = std::clamp((s - here.mean) * here.falloff, lowest, s - level.smallest);
  return -level.smallest + std::min(rho / core, 1.0) * (phi + level.smallest);
}

/// Squared length of the gradient of the mean over directions, per radian, by central differences one texel each way.
double squaredSlope(const RadiusLevel& level, const glm::dvec3& direction) {
  const glm::dvec3 d = glm::normalize(direction);
  const glm::dvec3 across = std::abs(d.x) < std::abs(d.y) ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 u = glm::normalize(glm::cross(d, across));
  const double step = texelAngle(level.side, d);
  double sum = 0.0;
  for (const glm::dvec3& axis : {u, glm::cross(d, u)}) {
    const glm::dvec3 along = axis * std::tan(step);
    const double slope = (interpolate(level, d + along).mean - interpolate(level, d - along).mean) / (2.0 * step);
    sum += slope * slope;
  }
  return sum;
}

/// Calls visit(corners, face, i, j) for every cell of every face, corners as {(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)}.
template <class Visit>
void forCells(const RadiusLevel& level, const Visit& visit) {
  for (unsigned face = 0; face < shared::kCubeFaces; ++face)
    for (int j = 0; j + 1 < level.side; ++j)
      for (int i = 0; i + 1 < level.side; ++i) {
        std::array<const RadiusTexel*, 4> corner{};
        for (int c = 0; c < 4; ++c)
          corner[static_cast<std::size_t>(c)] = &level.texel[texelIndex(level.side, face, i + (c & 1), j + (c >> 1))];
        visit(corner, face, i, j);
      }
}

void deriveBox(RadiusLevel& level) {
  level.box = {glm::dvec3(-level.largest), glm::dvec3(level.largest)};
  // Between the corners of a cell the surface bulges by the cosine of half its diagonal; from this side on the margin holds that.
  if (level.side >= kSmallestRadiusSide) {
    level.box = {};
    forCells(level, [&](const std::array<const RadiusTexel*, 4>& corner, unsigned face, int i, int j) {
      double radius = 0.0;
      for (const RadiusTexel* t : corner) radius = std::max(radius, double{t->mean});
      for (int c = 0; c < 4; ++c) include(level.box, radius * glm::normalize(texelDirection(level.side, face, i + (c & 1), j + (c >> 1))));
    });
  }
  level.box.min -= kRadiusPadding * level.largest;
  level.box.max += kRadiusPadding * level.largest;
}

/// Lowers falloffs until none differs from another by more than kFalloffSlope times the angle between them, by sweeps along the faces and
/// an exchange over the edges. Lower ones only draw distances towards zero.
void limitFalloff(RadiusLevel& level) {
  const int n = level.side;
  std::vector<glm::dvec3> unit(level.texel.size());
  std::vector<std::size_t> standsFor(level.texel.size());
  for (unsigned face = 0; face < shared::kCubeFaces; ++face)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const glm::dvec3 direction = texelDirection(n, face, i, j);
        unit[texelIndex(n, face, i, j)] = glm::normalize(direction);
        standsFor[texelIndex(n, face, i, j)] = texelTowards(n, direction);
      }
  bool changed = true;
  const auto lower = [&](std::size_t at, float value) {
    if (!(value < level.texel[at].falloff)) return;
    level.texel[at].falloff = value;
    changed = true;
  };
  const auto from = [&](std::size_t at, std::size_t other) {
    lower(at, level.texel[other].falloff + static_cast<float>(kFalloffSlope * glm::length(unit[at] - unit[other])));
  };
  const auto row = static_cast<std::size_t>(n), perFace = row * row;
  while (changed) {
    changed = false;
    for (std::size_t first = 0; first < level.texel.size(); first += perFace) {
      for (std::size_t i = 0; i < perFace; ++i) {
        if (i % row > 0) from(first + i, first + i - 1);
        if (i >= row) from(first + i, first + i - row);
      }
      for (std::size_t i = perFace; i-- > 0;) {
        if (i % row + 1 < row) from(first + i, first + i + 1);
        if (i + row < perFace) from(first + i, first + i + row);
      }
    }
    for (std::size_t i = 0; i < level.texel.size(); ++i) lower(standsFor[i], level.texel[i].falloff);
    for (std::size_t i = 0; i < level.texel.size(); ++i) lower(i, level.texel[standsFor[i]].falloff);
  }
}

/// `footprint` is the variance of the texel's filter along one axis in squared texels.
void derive(RadiusLevel& level, double footprint) {
  double leastMean = level.texel.front().mean;
  level.smallest = level.largest = leastMean;
  for (const RadiusTexel& texel : level.texel) {
    const double spread = std::sqrt(3.0 * texel.variance);
    leastMean = std::min(leastMean, double{texel.mean});
    level.smallest = std::min(level.smallest, texel.mean - spread);
    level.largest = std::max(level.largest, texel.mean + spread);
  }
  level.smallest = std::max(level.smallest, 0.5 * leastMean);
  deriveBox(level);
  for (unsigned face = 0; face < shared::kCubeFaces; ++face)
    for (int j = 0; j < level.side; ++j)
      for (int i = 0; i < level.side; ++i) {
        RadiusTexel& texel = level.texel[texelIndex(level.side, face, i, j)];
        const glm::dvec3 direction = texelDirection(level.side, face, i, j);
        const double angle = texelAngle(level.side, glm::normalize(direction));
        const double rough = texel.variance / (footprint * angle * angle);
        const double steep = std::max(squaredSlope(level, direction), rough) / (double{texel.mean} * texel.mean);
        texel.falloff = static_cast<float>(1.0 / std::sqrt(1.0 + steep));
      }
  limitFalloff(level);
}

/// Ranges over one cell of a face.
struct Cell {
  double meanLow, meanHigh, falloffLow, falloffHigh;
  double meanSlope, falloffSlope;  ///< largest gradients over directions, per radian
};

Cell cellOf(const std::array<const RadiusTexel*, 4>& corner, int side, int i, int j) {
  const double width = 2.0 / (side - 1);
  const auto farthest = [&](int k) { return std::max(std::abs(-1.0 + k * width), std::abs(-1.0 + (k + 1) * width)); };
  const glm::dvec2 x(farthest(i), farthest(j));
  const auto slope = [&](auto value) {
    const auto difference = [&](int a, int b) { return std::abs(value(*corner[std::size_t(a)]) - value(*corner[std::size_t(b)])) / width; };
    const glm::dvec2 g(std::max(difference(0, 1), difference(2, 3)), std::max(difference(0, 2), difference(1, 3)));
    const double radial = glm::dot(x, g);
    return std::sqrt((1.0 + glm::dot(x, x)) * (glm::dot(g, g) + radial * radial));
  };
  const auto mean = [](const RadiusTexel& t) { return double{t.mean}; };
  const auto falloff = [](const RadiusTexel& t) { return double{t.falloff}; };
  Cell cell{1e300, 0.0, 1.0, 0.0, slope(mean), slope(falloff)};
  for (const RadiusTexel* t : corner) {
    cell.meanLow = std::min(cell.meanLow, mean(*t));
    cell.meanHigh = std::max(cell.meanHigh, mean(*t));
    cell.falloffLow = std::min(cell.falloffLow, falloff(*t));
    cell.falloffHigh = std::max(cell.falloffHigh, falloff(*t));
  }
  return cell;
}

/// Largest gradient of the first-order formula over a cell, for radii up to `reach`, where it is not cut off.
double largestGradient(const Cell& cell, const RadiusLevel& level, double reach) {
  // Where each of the three cuts leaves the formula alone; each follows from its inequality solved for rho, at the worst corner of the
  // ranges.
  const double g = cell.falloffHigh;
  double low = std::max(kRadiusCore * level.smallest, (cell.meanLow * cell.falloffLow - level.smallest) / (1.0 + cell.falloffLow));
  double high = reach;
  if (g < 1.0) {
    low = std::max(low, (level.smallest - cell.meanHigh * g) / (1.0 - g));
    high = std::min(high, (level.largest - cell.meanLow * g) / (1.0 - g));
  }
  if (low > high) return 1.0;
  // Within the core the gradient is that at its border, but for its part along the ray, which is at most 1.
  const double along = low > kRadiusCore * level.smallest ? g : 1.0;
  // |rho - r| / rho and 1 / rho are convex in 1 / rho: the ends decide.
  const auto across = [&](double rho) {
    const double away = std::max(std::abs(rho - cell.meanLow), std::abs(rho - cell.meanHigh));
    return (away * cell.falloffSlope + g * cell.meanSlope) / rho;
  };
  return std::hypot(along, std::max(across(low), across(high)));
}

}  // namespace

std::size_t texelIndex(int side, unsigned face, int i, int j) {
  const auto n = static_cast<std::size_t>(side);
  return static_cast<std::size_t>(i) + n * (static_cast<std::size_t>(j) + n * face);
}

std::size_t texelCount(int side) {
  return texelIndex(side, shared::kCubeFaces, 0, 0);
}

glm::dvec3 texelDirection(int side, unsigned face, int i, int j) {
  const auto coordinate = [&](int k) { return static_cast<float>(2 * k - (side - 1)) / static_cast<float>(side - 1); };
  return shared::cubeDirection(face, {coordinate(i), coordinate(j)});
}

std::size_t texelTowards(int side, const glm::dvec3& direction) {
  const glm::vec3 d(direction);
  const unsigned face = shared::cubeFace(d);
  const glm::vec2 at = (shared::cubeCoordinates(face, d) * 0.5f + 0.5f) * static_cast<float>(side - 1);
  return texelIndex(side, face, static_cast<int>(std::lround(at.x)), static_cast<int>(std::lround(at.y)));
}

double texelAngle(int side, const glm::dvec3& direction) {
  const double main = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
  return 2.0 / (side - 1) * std::pow(main, 1.5);
}

void derive(RadiusField& field) {
  double footprint = 1.0 / 12.0;  // the rays of level 0 fill a box of one texel
  for (std::size_t l = 0; l < field.levels.size(); ++l) {
    if (l > 0) {
      // Every level is the one before under a tent of two of its own texels.
      const double ratio = static_cast<double>(field.levels[l].side - 1) / (field.levels[l - 1].side - 1);
      footprint = 1.0 / 6.0 + footprint * ratio * ratio;
    }
    derive(field.levels[l], footprint);
  }
}

bool isWhole(const RadiusField& field) {
  if (field.levels.empty()) return false;
  const int finest = field.levels.front().side;
  if (finest < kSmallestRadiusSide || finest > kLargestRadiusSide || (finest & (finest - 1)) != 0) return false;
  if (!std::isfinite(field.centre.x) || !std::isfinite(field.centre.y) || !std::isfinite(field.centre.z)) return false;
  for (std::size_t l = 0; l < field.levels.size(); ++l) {
    const RadiusLevel& level = field.levels[l];
    if (level.side != finest >> l || level.texel.size() != texelCount(level.side)) return false;
    if (!(level.smallest > 0.0) || !(level.largest <= kLargestRadiusRatio * level.smallest)) return false;
    for (const RadiusTexel& t : level.texel)
      if (!(t.mean >= level.smallest) || !(t.mean <= level.largest) || !(t.variance >= 0.0f) || !std::isfinite(t.variance) ||
          !(t.falloff > 0.0f) || !(t.falloff <= 1.0f))
        return false;
  }
  return field.levels.back().side == 2;
}

Box bounds(const RadiusField& field) {
  const Box& box = field.levels.front().box;
  return {field.centre + box.min, field.centre + box.max};
}

double sampleRadius(const RadiusField& field, const glm::dvec3& point, int level) {
  const RadiusLevel& chosen = field.levels[static_cast<std::size_t>(level)];
  const glm::dvec3 fromCentre = point - field.centre;
  const glm::dvec3 closest = glm::clamp(fromCentre, chosen.box.min, chosen.box.max);
  const double phi = firstOrderDistance(chosen, closest);
  const double beyond = glm::length(fromCentre - closest);
  if (beyond == 0.0) return phi;
  // Never negative on the border of the box, where the closest point is far from the centre.
  const double cosine = std::max(glm::dot(fromCentre - closest, closest) / (beyond * glm::length(closest)), 0.0);
  return std::sqrt(beyond * beyond + phi * phi + 2.0 * beyond * phi * std::min(cosine, 1.0));
}

double lipschitzBound(const RadiusField& field, int level) {
  OVERCAST_REQUIRE(isWhole(field), "a radius field of {} levels is not whole", field.levels.size());
  const RadiusLevel& chosen = field.levels[static_cast<std::size_t>(level)];
  const double reach = glm::length(glm::max(chosen.box.max, -chosen.box.min));
  double largest = 1.0;
  forCells(chosen, [&](const std::array<const RadiusTexel*, 4>& corner, unsigned, int i, int j) {
    largest = std::max(largest, largestGradient(cellOf(corner, chosen.side, i, j), chosen, reach));
  });
  return largest;
}

}  // namespace overcast
