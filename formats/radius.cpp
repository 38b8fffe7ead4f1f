#include "formats/radius.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "formats/shared/cube_map.h"

namespace overcast {
namespace {

/// What a level says of a direction.
struct Look {
  double mean = 0.0;
  glm::dvec3 slope{0.0};
};

/// Bilinear interpolation in a direction of any length.
Look look(const RadiusLevel& level, const glm::dvec3& direction) {
  const glm::vec3 d(direction / std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z), 1e-300}));
  const unsigned face = shared::cubeFace(d);
  const glm::dvec2 at = (glm::dvec2(shared::cubeCoordinates(face, d)) * 0.5 + 0.5) * double(level.side - 1);
  const glm::ivec2 cell = glm::clamp(glm::ivec2(at), glm::ivec2(0), glm::ivec2(level.side - 2));
  const glm::dvec2 t = at - glm::dvec2(cell);
  const std::size_t first = texelIndex(level.side, face, cell.x, cell.y), next = first + static_cast<std::size_t>(level.side);
  Look sum;
  const auto add = [&](std::size_t texel, double weight) {
    sum.mean += weight * level.texel[texel].mean;
    sum.slope += weight * glm::dvec3(level.texel[texel].slope);
  };
  add(first, (1.0 - t.x) * (1.0 - t.y));
  add(first + 1, t.x * (1.0 - t.y));
  add(next, (1.0 - t.x) * t.y);
  add(next + 1, t.x * t.y);
  return sum;
}

/// The same `blur` levels (not negative) above level `base`.
Look lookBlurred(const RadiusField& field, std::size_t base, double blur, const glm::dvec3& direction) {
  const double at = std::min(static_cast<double>(base) + blur, static_cast<double>(field.levels.size() - 1));
  const auto low = static_cast<std::size_t>(at);
  const Look fine = look(field.levels[low], direction);
  if (low + 1 == field.levels.size()) return fine;
  const Look coarse = look(field.levels[low + 1], direction);
  const double t = at - static_cast<double>(low);
  return {fine.mean + t * (coarse.mean - fine.mean), fine.slope + t * (coarse.slope - fine.slope)};
}

/// Gradient of the mean over directions, per radian, by central differences one texel each way.
glm::dvec3 meanGradient(const RadiusLevel& level, const glm::dvec3& direction) {
  const glm::dvec3 d = glm::normalize(direction);
  const glm::dvec3 across = std::abs(d.x) < std::abs(d.y) ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  const glm::dvec3 u = glm::normalize(glm::cross(d, across));
  const double step = texelAngle(level.side, d);
  glm::dvec3 gradient(0.0);
  for (const glm::dvec3& axis : {u, glm::cross(d, u)}) {
    const glm::dvec3 along = axis * std::tan(step);
    gradient += axis * ((look(level, d + along).mean - look(level, d - along).mean) / (2.0 * step));
  }
  return gradient;
}

double coreOf(const RadiusLevel& level) {
  return kRadiusCore * level.smallest;
}

/// A value at distance s from the centre within what solids between the two spheres allow.
double betweenSpheres(const RadiusLevel& level, double s, double phi) {
  return std::clamp(phi, std::max(-level.smallest - s, s - level.largest), s - level.smallest);
}

/// The signed distance at `p`, outside the core, about the centre, by the search that radius.h describes.
double searchedDistance(const RadiusField& field, std::size_t base, const glm::dvec3& p) {
  const RadiusLevel& level = field.levels[base];
  const double s = glm::length(p), texel = 0.5 * std::numbers::pi / (level.side - 1);
  glm::dvec3 d = p / s;
  const double v = s - look(level, d).mean;
  const Look near = lookBlurred(field, base, std::log2(std::max(kRadiusBlur * std::abs(v) / (s * texel), 1.0)), d);
  double best = std::abs(v) / std::sqrt(1.0 + glm::dot(near.slope, near.slope) / (near.mean * s));
  // Newton's step of |p - r d|^2 over directions: the Hessian is g g^T + r rho I, inverted by Sherman and Morrison's formula.
  const glm::dvec3 g = near.slope - d * glm::dot(near.slope, d);
  d = glm::normalize(d + g * ((s - near.mean) / (near.mean * s + glm::dot(g, g))));
  best = std::min(best, glm::length(p - look(level, d).mean * d));
  best = std::max(best, level.gentlest * std::abs(v));
  return v < 0.0 ? -best : best;
}

/// Draws `outside`, values at points outside the core, out to the centre, and keeps them at least as large as the distance to the box.
template <class Outside>
double everywhere(const RadiusLevel& level, const glm::dvec3& fromCentre, const Outside& outside) {
  const double rho = glm::length(fromCentre), core = coreOf(level), s = std::max(rho, core);
  const glm::dvec3 p = rho > 0.0 ? fromCentre * (s / rho) : glm::dvec3(s, 0.0, 0.0);
  const double phi = betweenSpheres(level, s, outside(p, s));
  const double gap = glm::length(fromCentre - glm::clamp(fromCentre, level.box.min, level.box.max));
  const double blended = -level.smallest + std::min(rho / core, 1.0) * (phi + level.smallest);
  return gap > 0.0 ? std::max(blended, gap) : blended;
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

/// Largest gradient over directions of a bilinear mean: from differences along the edges of each cell and the metric of the face,
/// (1 + |x|^2) (I + x x^T).
void deriveSteepest(RadiusLevel& level) {
  const double width = 2.0 / (level.side - 1);
  level.steepest = 0.0;
  forCells(level, [&](const std::array<const RadiusTexel*, 4>& corner, unsigned, int i, int j) {
    const auto farthest = [&](int k) { return std::max(std::abs(-1.0 + k * width), std::abs(-1.0 + (k + 1) * width)); };
    const auto difference = [&](std::size_t a, std::size_t b) { return std::abs(double{corner[a]->mean} - corner[b]->mean) / width; };
    const glm::dvec2 x(farthest(i), farthest(j));
    const glm::dvec2 g(std::max(difference(0, 1), difference(2, 3)), std::max(difference(0, 2), difference(1, 3)));
    const double radial = glm::dot(x, g);
    level.steepest = std::max(level.steepest, std::sqrt((1.0 + glm::dot(x, x)) * (glm::dot(g, g) + radial * radial)));
  });
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
  deriveSteepest(level);
  for (unsigned face = 0; face < shared::kCubeFaces; ++face)
    for (int j = 0; j < level.side; ++j)
      for (int i = 0; i < level.side; ++i) {
        RadiusTexel& texel = level.texel[texelIndex(level.side, face, i, j)];
        const glm::dvec3 direction = texelDirection(level.side, face, i, j);
        const double angle = texelAngle(level.side, glm::normalize(direction));
        const glm::dvec3 gradient = meanGradient(level, direction);
        const double rough = texel.variance / (footprint * angle * angle) - glm::dot(gradient, gradient);
        texel.slope = glm::vec3(gradient + std::sqrt(std::max(rough, 0.0)) * glm::normalize(direction));
      }
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
  double longest = 0.0;
  for (auto level = field.levels.rbegin(); level != field.levels.rend(); ++level) {
    for (const RadiusTexel& texel : level->texel) longest = std::max(longest, glm::length(glm::dvec3(texel.slope)));
    // Lateral distances are at least 2 / pi of the arc.
    const double k = std::max(0.5 * std::numbers::pi * level->steepest, longest);
    level->gentlest = 1.0 / std::sqrt(1.0 + k * k / (coreOf(*level) * level->smallest));
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
          !std::isfinite(glm::dot(glm::dvec3(t.slope), glm::dvec3(t.slope))))
        return false;
  }
  return field.levels.back().side == 2;
}

Box bounds(const RadiusField& field) {
  const Box& box = field.levels.front().box;
  return {field.centre + box.min, field.centre + box.max};
}

double sampleRadius(const RadiusField& field, const glm::dvec3& point, int level) {
  const auto base = static_cast<std::size_t>(level);
  return everywhere(field.levels[base], point - field.centre,
                    [&](const glm::dvec3& p, double) { return searchedDistance(field, base, p); });
}

glm::dvec2 radiusRange(const RadiusField& field, const glm::dvec3& point, int level) {
  const RadiusLevel& base = field.levels[static_cast<std::size_t>(level)];
  const auto bound = [&](bool upper) {
    return everywhere(base, point - field.centre, [&](const glm::dvec3& p, double s) {
      const double v = s - look(base, p).mean;
      return (v > 0.0) == upper ? v : base.gentlest * v;
    });
  };
  return {bound(false), bound(true)};
}

double lipschitzBound(const RadiusField& field, int level) {
  OVERCAST_REQUIRE(isWhole(field), "a radius field of {} levels is not whole", field.levels.size());
  const RadiusLevel& chosen = field.levels[static_cast<std::size_t>(level)];
  return std::hypot(1.0, chosen.steepest / coreOf(chosen));
}

}  // namespace overcast
