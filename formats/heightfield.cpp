#include "formats/heightfield.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include <Imath/half.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "formats/image_mipmaps.h"

namespace overcast {
namespace {

constexpr double kOrthonormal = 1e-9;

bool isFinite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool sideFits(int side) {
  return side >= kMinHeightFieldSide && side <= kMaxHeightFieldSide && std::has_single_bit(static_cast<unsigned>(side));
}

bool layerIsWhole(const HeightField& field, const HeightLevels& layer) {
  if (layer.size() != static_cast<std::size_t>(levelCount(field))) return false;
  for (std::size_t l = 0; l < layer.size(); ++l) {
    const glm::ivec2 size = levelSize(field, static_cast<int>(l));
    if (layer[l].size() != static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y)) return false;
    for (const HeightTexel& texel : layer[l])
      if (!std::isfinite(texel.mean) || !std::isfinite(texel.variance) || texel.variance < 0.0f) return false;
  }
  return true;
}

/// The mean of `parts` texels that cover equal areas.
HeightTexel together(const std::array<HeightTexel, 4>& texels, std::size_t parts) {
  double mean = 0.0, variance = 0.0;
  for (std::size_t n = 0; n < parts; ++n) mean += double{texels[n].mean} / static_cast<double>(parts);
  for (std::size_t n = 0; n < parts; ++n) {
    const double off = texels[n].mean - mean;
    variance += (texels[n].variance + off * off) / static_cast<double>(parts);
  }
  return {static_cast<float>(mean), static_cast<float>(variance)};
}

void buildLevels(const HeightField& field, HeightLevels& layer) {
  layer.resize(static_cast<std::size_t>(levelCount(field)));
  for (int level = 1; level < levelCount(field); ++level) {
    const glm::ivec2 fine = levelSize(field, level - 1), size = levelSize(field, level), step = fine / size;
    const std::vector<HeightTexel>& below = layer[static_cast<std::size_t>(level - 1)];
    std::vector<HeightTexel>& texels = layer[static_cast<std::size_t>(level)];
    texels.clear();
    for (int j = 0; j < size.y; ++j)
      for (int i = 0; i < size.x; ++i) {
        std::array<HeightTexel, 4> parts;
        std::size_t count = 0;
        for (int y = 0; y < step.y; ++y)
          for (int x = 0; x < step.x; ++x) parts[count++] = below[static_cast<std::size_t>(i * step.x + x + fine.x * (j * step.y + y))];
        texels.push_back(together(parts, count));
      }
  }
}

/// The surface over a place.
struct Surface {
  double height = 0.0;
  glm::dvec2 gradient{0.0};
  double steep = 1.0;  ///< 1 + |gradient|^2 + rough
};

/// The surface of a layer over `at`, field space about the middle of the rectangle.
Surface surfaceAt(const HeightField& field, const HeightLevels& layer, int level, const glm::dvec2& place) {
  const glm::dvec2 size = cellSize(field, level), at = (place + glm::dvec2(field.halfExtent)) / size;
  const glm::ivec2 cell = glm::min(glm::ivec2(at), levelSize(field, level) - 1);
  const glm::dvec2 t = at - glm::dvec2(cell), s = 1.0 - t;
  const std::array<glm::dvec2, 3> weight{0.5 * s * s, 0.5 + t * s, 0.5 * t * t}, slope{-s, 1.0 - 2.0 * t, t};
  double height = 0.0, variance = 0.0;
  glm::dvec2 rise(0.0);
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 3; ++i) {
      const HeightTexel texel = texelBeyond(field, layer, level, cell.x + static_cast<int>(i) - 1, cell.y + static_cast<int>(j) - 1);
      height += weight[i].x * weight[j].y * texel.mean;
      variance += weight[i].x * weight[j].y * texel.variance;
      rise += glm::dvec2(slope[i].x * weight[j].y, weight[i].x * slope[j].y) * double{texel.mean};
    }
  const double unit = field.halfExtent.z;
  rise *= unit;
  const double rough = std::max(12.0 * variance * unit * unit - glm::dot(rise, rise), 0.0) / (size.x * size.y);
  const glm::dvec2 gradient = rise / size;
  return {height * unit, gradient, 1.0 + glm::dot(gradient, gradient) + rough};
}

/// The coarsest level that the search of a sheet reads: with at least two texels along the shorter side.
int coarsestSearched(const HeightField& field) {
  int level = 0;
  while (std::min(field.size.x, field.size.y) >> (level + 1) >= 2) ++level;
  return level;
}

/// The same of the front layer `blur` levels (not negative) above level `base`.
Surface surfaceBlurred(const HeightField& field, int base, double blur, const glm::dvec2& place) {
  const int coarsest = std::max(base, coarsestSearched(field));
  const double at = std::min(base + blur, static_cast<double>(coarsest));
  const int low = static_cast<int>(at);
  const Surface fine = surfaceAt(field, field.front, low, place);
  if (low == coarsest) return fine;
  const Surface coarse = surfaceAt(field, field.front, low + 1, place);
  const double t = at - low;
  return {fine.height + t * (coarse.height - fine.height), fine.gradient + t * (coarse.gradient - fine.gradient),
          fine.steep + t * (coarse.steep - fine.steep)};
}

/// Control values of the B-spline over one texel, in local units.
struct Patch {
  std::array<std::array<double, 3>, 3> height{};
  std::array<std::array<double, 3>, 3> variance{};
};

/// Bounds of |d/du| and its derivatives over a patch; the other direction by transposing.
struct Rise {
  double least = 0.0;     ///< smallest |dh/du|
  double most = 0.0;      ///< largest |dh/du|
  double along = 0.0;     ///< largest |d2h/du2|
  double variance = 0.0;  ///< largest |dv/du|
};

Rise riseOf(const Patch& patch, bool alongX) {
  const auto at = [&](const auto& values, std::size_t i, std::size_t j) { return alongX ? values[j][i] : values[i][j]; };
  Rise rise;
  double low = 1e300, high = -1e300;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 2; ++i) {
      const double step = at(patch.height, i + 1, j) - at(patch.height, i, j);
      low = std::min(low, step);
      high = std::max(high, step);
      rise.variance = std::max(rise.variance, std::abs(at(patch.variance, i + 1, j) - at(patch.variance, i, j)));
    }
    rise.along = std::max(rise.along, std::abs(at(patch.height, 2, j) - 2.0 * at(patch.height, 1, j) + at(patch.height, 0, j)));
  }
  rise.most = std::max(std::abs(low), std::abs(high));
  if (low > 0.0 || high < 0.0) rise.least = std::min(std::abs(low), std::abs(high));
  return rise;
}

/// Largest |d2h/dudv| over the patch: bilinear in the differences of its four quarters.
double twistOf(const Patch& patch) {
  double most = 0.0;
  for (std::size_t j = 0; j < 2; ++j)
    for (std::size_t i = 0; i < 2; ++i)
      most = std::max(most, std::abs(patch.height[j + 1][i + 1] - patch.height[j + 1][i] - patch.height[j][i + 1] + patch.height[j][i]));
  return most;
}

/// Bound of |grad phi| over the patch, within the box.
double patchBound(const Patch& patch, const glm::dvec2& cell, double halfHeight) {
  const Rise x = riseOf(patch, true), y = riseOf(patch, false);
  const double twist = twistOf(patch), area = cell.x * cell.y;
  // q is |grad h|^2 where nothing is rough, and elsewhere the same with 1 / area taken from the factors of the squared rises and 12 v /
  // area added.
  const auto change = [&](double fx, double fy, double fv) {
    const double dx = 2.0 * fx * x.most * x.along + 2.0 * fy * y.most * twist + fv * x.variance;
    const double dy = 2.0 * fx * x.most * twist + 2.0 * fy * y.most * y.along + fv * y.variance;
    return std::hypot(dx / cell.x, dy / cell.y);
  };
  const double fx = 1.0 / (cell.x * cell.x), fy = 1.0 / (cell.y * cell.y);
  const double steepest = std::max(change(fx, fy, 0.0), change(std::abs(fx - 1.0 / area), std::abs(fy - 1.0 / area), 12.0 / area));
  double low = 1e300, high = -1e300;
  for (const auto& row : patch.height)
    for (const double h : row) low = std::min(low, h), high = std::max(high, h);
  const double away = std::max({halfHeight - low, high + halfHeight, 0.0});
  const double slope2 = 1.0 + fx * x.least * x.least + fy * y.least * y.least;
  return 1.0 + away * steepest / (2.0 * slope2 * std::sqrt(slope2));
}

/// Calls visit(patch) for every texel of a layer's level.
template <class Visit>
void forPatches(const HeightField& field, const HeightLevels& layer, int level, const Visit& visit) {
  const glm::ivec2 size = levelSize(field, level);
  const double unit = field.halfExtent.z;
  for (int j = 0; j < size.y; ++j)
    for (int i = 0; i < size.x; ++i) {
      Patch patch;
      for (std::size_t y = 0; y < 3; ++y)
        for (std::size_t x = 0; x < 3; ++x) {
          const HeightTexel texel = texelBeyond(field, layer, level, i + static_cast<int>(x) - 1, j + static_cast<int>(y) - 1);
          patch.height[y][x] = texel.mean * unit;
          patch.variance[y][x] = texel.variance * unit * unit;
        }
      visit(patch);
    }
}

double layerBound(const HeightField& field, const HeightLevels& layer, int level) {
  double largest = 1.0;
  forPatches(field, layer, level,
             [&](const Patch& patch) { largest = std::max(largest, patchBound(patch, cellSize(field, level), field.halfExtent.z)); });
  return largest;
}

/// Bound of sqrt(1 + |gradient|^2 + rough) over the levels that the search reads from this one on.
double sheetBound(const HeightField& field, int base) {
  double largest = 1.0;
  for (int level = base; level <= std::max(base, coarsestSearched(field)); ++level) {
    const glm::dvec2 cell = cellSize(field, level);
    forPatches(field, field.front, level, [&](const Patch& patch) {
      double variance = 0.0;
      for (const auto& row : patch.variance)
        for (const double v : row) variance = std::max(variance, v);
      const double x = riseOf(patch, true).most / cell.x, y = riseOf(patch, false).most / cell.y;
      const double wide = cell.x / cell.y;  // where heights are rough, the slopes they have count only by how far texels are from square
      const double rough =
          12.0 * variance / (cell.x * cell.y) + x * x * std::max(1.0 - wide, 0.0) + y * y * std::max(1.0 - 1.0 / wide, 0.0);
      largest = std::max(largest, std::sqrt(1.0 + std::max(x * x + y * y, rough)));
    });
  }
  return largest;
}

/// Signed distance of a pair at a point of the box, field space.
double boxedDistance(const HeightField& field, const glm::dvec3& p, int level) {
  const Surface top = surfaceAt(field, field.front, level, glm::dvec2(p)), bottom = surfaceAt(field, field.back, level, glm::dvec2(p));
  const glm::dvec3 wall = glm::abs(p) - field.halfExtent;
  return std::max({(p.z - top.height) / std::sqrt(top.steep), (bottom.height - p.z) / std::sqrt(bottom.steep), wall.x, wall.y, wall.z});
}

/// A place seen from the closest point of the rectangle.
struct Above {
  glm::dvec2 place;   ///< that point
  glm::dvec2 across;  ///< from there, horizontally
  double up = 0.0;    ///< above the surface there
  double straight() const { return std::hypot(glm::length(across), up); }
};

Above aboveSheet(const HeightField& field, const glm::dvec3& p, int level) {
  const glm::dvec2 half(field.halfExtent), place = glm::clamp(glm::dvec2(p), -half, half);
  return {place, glm::dvec2(p) - place, p.z - surfaceAt(field, field.front, level, place).height};
}

/// Distance of a sheet, field space.
double sheetDistance(const HeightField& field, const glm::dvec3& p, int level) {
  const glm::dvec2 half(field.halfExtent), cell = cellSize(field, level);
  const Above above = aboveSheet(field, p, level);
  const double blur = std::log2(std::max(kSheetBlur * above.straight() / std::max(cell.x, cell.y), 1.0));
  const Surface near = surfaceBlurred(field, level, blur, above.place);
  // The closest point over the rectangle of the tangent plane.
  const double tilt = 1.0 + glm::dot(near.gradient, near.gradient);
  const double behind = above.up - glm::dot(near.gradient, above.across);
  const glm::dvec2 foot = glm::clamp(glm::dvec2(p) + near.gradient * (behind / tilt), -half, half);
  const double across = glm::length(glm::dvec2(p) - foot), up = above.up - glm::dot(near.gradient, foot - above.place);
  const double there = p.z - surfaceAt(field, field.front, level, foot).height;
  return std::min({above.straight(), std::hypot(across, up * std::sqrt(tilt / near.steep)), std::hypot(across, there)});
}

}  // namespace

bool isWhole(const HeightField& field) {
  for (int a = 0; a < 3; ++a) {
    if (!isFinite(field.localFromField[a])) return false;
    for (int b = 0; b < 3; ++b)
      if (std::abs(glm::dot(field.localFromField[a], field.localFromField[b]) - (a == b ? 1.0 : 0.0)) > kOrthonormal) return false;
  }
  return glm::determinant(field.localFromField) > 0.0 && isFinite(field.origin) && isFinite(field.halfExtent) &&
         std::min({field.halfExtent.x, field.halfExtent.y, field.halfExtent.z}) > 0.0 && sideFits(field.size.x) && sideFits(field.size.y) &&
         layerIsWhole(field, field.front) && (field.back.empty() || layerIsWhole(field, field.back));
}

int levelCount(const HeightField& field) {
  return mipmapLevels(field.size.x, field.size.y);
}

glm::ivec2 levelSize(const HeightField& field, int level) {
  return glm::max(glm::ivec2(field.size.x >> level, field.size.y >> level), glm::ivec2(1));
}

glm::dvec2 cellSize(const HeightField& field, int level) {
  return 2.0 * glm::dvec2(field.halfExtent) / glm::dvec2(levelSize(field, level));
}

void buildLevels(HeightField& field) {
  buildLevels(field, field.front);
  if (!field.back.empty()) buildLevels(field, field.back);
}

Box bounds(const HeightField& field) {
  glm::dvec3 reach(0.0);
  for (int axis = 0; axis < 3; ++axis) reach += glm::abs(field.localFromField[axis]) * field.halfExtent[axis];
  return {field.origin - reach, field.origin + reach};
}

HeightTexel texelBeyond(const HeightField& field, const HeightLevels& layer, int level, int i, int j) {
  const glm::ivec2 size = levelSize(field, level);
  const auto inside = [&](int x, int y) { return layer[static_cast<std::size_t>(level)][static_cast<std::size_t>(x + size.x * y)]; };
  const int x = std::clamp(i, 0, size.x - 1), y = std::clamp(j, 0, size.y - 1);
  HeightTexel texel = inside(x, y);
  if (x == i && y == j) return texel;
  const int x1 = std::clamp(2 * x - i, 0, size.x - 1), y1 = std::clamp(2 * y - j, 0, size.y - 1);
  texel.mean += (texel.mean - inside(x1, y).mean) + (texel.mean - inside(x, y1).mean);
  return texel;
}

double sampleHeightField(const HeightField& field, const glm::dvec3& point, int level) {
  const glm::dvec3 p = (point - field.origin) * field.localFromField;
  const glm::dvec3 q = glm::clamp(p, -field.halfExtent, field.halfExtent);
  if (field.back.empty()) return std::max(sheetDistance(field, p, level), glm::length(p - q));
  const double phi = boxedDistance(field, q, level);
  if (p == q) return phi;
  const glm::dvec3 beyond = p - q;
  const double gap = glm::length(beyond), unit = std::max(cellSize(field).x, cellSize(field).y);
  const glm::dvec3 step = beyond * (unit / std::max({std::abs(beyond.x), std::abs(beyond.y), std::abs(beyond.z)}));
  const double cosine = std::clamp((phi - boxedDistance(field, q - step, level)) / glm::length(step), 0.0, 1.0);
  return std::hypot(gap + cosine * phi, std::sqrt(1.0 - cosine * cosine) * phi);
}

glm::dvec2 sheetRange(const HeightField& field, const glm::dvec3& point, int level) {
  OVERCAST_REQUIRE(field.back.empty(), "a sheet of {} back layers", field.back.size());
  const glm::dvec3 p = (point - field.origin) * field.localFromField;
  const double gap = glm::length(p - glm::clamp(p, -field.halfExtent, field.halfExtent));
  const double straight = aboveSheet(field, p, level).straight();
  return {std::max(straight / sheetBound(field, level), gap), std::max(straight, gap)};
}

double lipschitzBound(const HeightField& field, int level) {
  OVERCAST_REQUIRE(isWhole(field), "a heightfield of {} x {} texels is not whole", field.size.x, field.size.y);
  if (field.back.empty()) return sheetBound(field, level);
  return std::max(layerBound(field, field.front, level), layerBound(field, field.back, level));
}

HeightField asStored(HeightField field) {
  for (HeightLevels* layer : {&field.front, &field.back})
    for (std::vector<HeightTexel>& level : *layer)
      for (HeightTexel& texel : level)
        texel = {static_cast<float>(Imath::half(texel.mean)), static_cast<float>(Imath::half(texel.variance))};
  return field;
}

}  // namespace overcast
