#include "bake/heightfield.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/canonical.h"
#include "bake/height_raster.h"

namespace overcast {
namespace {

constexpr int kLinesPerTexel = 4;       ///< along each side
constexpr double kPaddingTexels = 2.0;  ///< below the lowest and above the highest point

Error failure(std::string reason) {
  return Error{"", "", std::move(reason)};
}

/// Where a texel got its height from.
enum class Cover : char { met, hole, beyond };

/// One layer in the making, local units.
struct Layers {
  glm::ivec2 size{0};
  std::vector<double> front, frontVariance, back, backVariance;
  std::vector<Cover> cover;
};

std::vector<glm::dvec3> inField(const Mesh& mesh, const glm::dmat3& localFromField, const glm::dvec3& origin) {
  std::vector<glm::dvec3> points;
  points.reserve(mesh.positions.size());
  for (const glm::dvec3& p : mesh.positions) points.push_back((p - origin) * localFromField);
  return points;
}

Box boxOf(const std::vector<glm::dvec3>& points, const Mesh& mesh) {
  Box box;
  for (const glm::uvec3& t : mesh.triangles)
    for (const auto corner : {t.x, t.y, t.z}) include(box, points[corner]);
  return box;
}

/// Place of (x, y) in a row-major grid of that width.
std::size_t placeOf(int width, int x, int y) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

void fillTexel(Layers& layers, std::size_t texel, const std::vector<double>& top, const std::vector<double>& bottom) {
  const auto moments = [](const std::vector<double>& heights, double& mean, double& variance) {
    mean = variance = 0.0;
    for (const double h : heights) mean += h / static_cast<double>(heights.size());
    for (const double h : heights) variance += (h - mean) * (h - mean) / static_cast<double>(heights.size());
  };
  layers.cover[texel] = top.empty() ? Cover::hole : Cover::met;
  if (top.empty()) return;
  moments(top, layers.front[texel], layers.frontVariance[texel]);
  moments(bottom, layers.back[texel], layers.backVariance[texel]);
}

Layers gather(const HeightRaster& raster, const glm::ivec2& size) {
  const std::size_t texels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
  Layers layers;
  layers.size = size;
  for (std::vector<double>* values : {&layers.front, &layers.frontVariance, &layers.back, &layers.backVariance})
    values->assign(texels, 0.0);
  layers.cover.assign(texels, Cover::met);
  std::vector<double> top, bottom;
  for (int j = 0; j < size.y; ++j)
    for (int i = 0; i < size.x; ++i) {
      top.clear();
      bottom.clear();
      for (int y = 0; y < kLinesPerTexel; ++y)
        for (int x = 0; x < kLinesPerTexel; ++x) {
          const auto line = placeOf(size.x * kLinesPerTexel, i * kLinesPerTexel + x, j * kLinesPerTexel + y);
          if (!std::isfinite(raster.top[line])) continue;
          top.push_back(raster.top[line]);
          bottom.push_back(raster.bottom[line]);
        }
      fillTexel(layers, placeOf(size.x, i, j), top, bottom);
    }
  return layers;
}

/// Calls visit(i, j) for the neighbours of a texel by side.
template <class Visit>
void forNeighbours(const glm::ivec2& size, int i, int j, Visit visit) {
  if (i > 0) visit(i - 1, j);
  if (i + 1 < size.x) visit(i + 1, j);
  if (j > 0) visit(i, j - 1);
  if (j + 1 < size.y) visit(i, j + 1);
}

/// Empty texels that are reached from the border are beyond the outline; for a pair every empty one is.
void markBeyond(Layers& layers, bool pair) {
  std::vector<std::pair<int, int>> open;
  const auto reach = [&](int i, int j) {
    Cover& cover = layers.cover[placeOf(layers.size.x, i, j)];
    if (cover != Cover::hole) return;
    cover = Cover::beyond;
    open.emplace_back(i, j);
  };
  for (int j = 0; j < layers.size.y; ++j)
    for (int i = 0; i < layers.size.x; ++i)
      if (pair || i == 0 || j == 0 || i + 1 == layers.size.x || j + 1 == layers.size.y) reach(i, j);
  while (!open.empty()) {
    const auto [i, j] = open.back();
    open.pop_back();
    forNeighbours(layers.size, i, j, reach);
  }
}

/// Texels that lines met and that have an empty neighbour.
std::vector<glm::ivec2> rimOf(const Layers& layers) {
  std::vector<glm::ivec2> rim;
  for (int j = 0; j < layers.size.y; ++j)
    for (int i = 0; i < layers.size.x; ++i) {
      const auto coverAt = [&](int x, int y) { return layers.cover[placeOf(layers.size.x, x, y)]; };
      if (coverAt(i, j) != Cover::met) continue;
      bool atEdge = false;
      forNeighbours(layers.size, i, j, [&](int x, int y) { atEdge = atEdge || coverAt(x, y) != Cover::met; });
      if (atEdge) rim.emplace_back(i, j);
    }
  return rim;
}

/// Gives heights to the texels that no line met (bakeHeightField says which).
void fillRest(Layers& layers, const glm::dvec2& cell, bool pair) {
  markBeyond(layers, pair);
  const std::vector<glm::ivec2> rim = rimOf(layers);
  tbb::parallel_for(0, layers.size.y, [&](int j) {
    for (int i = 0; i < layers.size.x; ++i) {
      const std::size_t texel = placeOf(layers.size.x, i, j);
      if (layers.cover[texel] == Cover::met) continue;
      double nearest = std::numeric_limits<double>::infinity();
      std::size_t from = 0;
      for (const glm::ivec2& r : rim) {
        const glm::dvec2 gap = cell * glm::dvec2(r - glm::ivec2(i, j));
        if (glm::dot(gap, gap) >= nearest) continue;
        nearest = glm::dot(gap, gap);
        from = placeOf(layers.size.x, r.x, r.y);
      }
      const double fall = layers.cover[texel] == Cover::beyond ? std::sqrt(nearest) : 0.0;
      const double middle = 0.5 * (layers.front[from] + layers.back[from]);
      layers.front[texel] = (pair ? middle : layers.front[from]) - fall;
      layers.back[texel] = middle + fall;
    }
  });
}

HeightLevels levelsOf(const std::vector<double>& mean, const std::vector<double>& variance, double unit) {
  HeightLevels layer(1);
  for (std::size_t n = 0; n < mean.size(); ++n)
    layer[0].push_back({static_cast<float>(mean[n] / unit), static_cast<float>(variance[n] / (unit * unit))});
  return layer;
}

/// Texels along both sides: the longer gets `resolution`.
glm::ivec2 sizeFor(const glm::dvec3& extent, int resolution) {
  const double cell = std::max(extent.x, extent.y) / resolution;
  const auto side = [&](double length) {
    const double texels = std::exp2(std::round(std::log2(std::max(length / cell, 1.0))));
    return std::clamp(static_cast<int>(texels), kMinHeightFieldSide, resolution);
  };
  return {side(extent.x), side(extent.y)};
}

}  // namespace

Result<HeightField> bakeHeightField(const Mesh& given, const HeightView& view, int resolution) {
  if (resolution < kMinHeightFieldSide || resolution > kMaxHeightFieldSide || !std::has_single_bit(static_cast<unsigned>(resolution)))
    return failure(fmt::format("{} texels are not a power of two within {} to {}", resolution, kMinHeightFieldSide, kMaxHeightFieldSide));
  if (given.triangles.empty()) return failure("mesh has no triangle");
  const Mesh mesh = canonicalOrder(given);
  const glm::dvec3 middle = centre(bounds(mesh));
  std::vector<glm::dvec3> points = inField(mesh, view.localFromField, middle);
  const Box box = boxOf(points, mesh);
  const glm::dvec3 size = extent(box);
  if (!(std::min(size.x, size.y) > 0.0)) return failure("mesh has no area seen along the axis of its heights");

  HeightField field;
  field.localFromField = view.localFromField;
  field.size = sizeFor(size, resolution);
  const glm::dvec2 cell = glm::dvec2(size) / glm::dvec2(field.size);
  field.halfExtent = 0.5 * size;
  field.halfExtent.z += kPaddingTexels * std::max(cell.x, cell.y);
  field.origin = middle + view.localFromField * centre(box);
  for (glm::dvec3& p : points) p -= centre(box);
  const LineGrid grid{kLinesPerTexel * field.size, -glm::dvec2(field.halfExtent), cell / double{kLinesPerTexel}};
  const HeightRaster raster = rasterHeights(points, mesh.triangles, grid);
  Layers layers = gather(raster, field.size);
  if (std::count(layers.cover.begin(), layers.cover.end(), Cover::met) == 0) return failure("no line along the axis meets the mesh");
  fillRest(layers, cell, view.pair);
  field.front = levelsOf(layers.front, layers.frontVariance, field.halfExtent.z);
  if (view.pair) field.back = levelsOf(layers.back, layers.backVariance, field.halfExtent.z);
  field = asStored(std::move(field));
  buildLevels(field);
  field = asStored(std::move(field));
  if (!isWhole(field)) return failure("its heights do not fit half floats");
  return field;
}

Result<HeightField> bakeHeightField(const Mesh& mesh, int resolution) {
  const Result<HeightView> view = bestHeightView(mesh);
  if (!view) return view.error();
  return bakeHeightField(mesh, view.value(), resolution);
}

}  // namespace overcast
