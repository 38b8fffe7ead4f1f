#include "bake/chart_raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <tbb/parallel_for.h>

#include <glm/geometric.hpp>

#include "formats/image_mipmaps.h"

namespace overcast {
namespace {

constexpr int kBand = 16;            ///< rows that one task works on
constexpr double kReach = 2.0;       ///< square of the distance within which bilinear sampling may read a texel
constexpr double kSamePlace = 1e-6;  ///< of the diagonal
constexpr std::size_t kSamples = std::size_t{kOverlapSamples} * kOverlapSamples;

using Corners = std::array<glm::dvec2, 3>;

/// Corners of a triangle in units of texels.
Corners cornersOf(const Mesh& mesh, std::uint32_t triangle, const glm::ivec2& size) {
  Corners corners;
  for (int c = 0; c < 3; ++c)
    corners[static_cast<std::size_t>(c)] = glm::dvec2(mesh.textureCoordinates[mesh.triangles[triangle][c]]) * glm::dvec2(size);
  return corners;
}

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// Which side of the line through a and b the point is on; exactly the opposite for b and a, so that no point lies in both triangles at an
/// edge.
double side(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  const bool swaps = b.x < a.x || (b.x == a.x && b.y < a.y);
  return swaps ? -cross(a - b, p - b) : cross(b - a, p - a);
}

/// Strictly inside, whichever way the triangle turns.
bool contains(const Corners& t, const glm::dvec2& p) {
  const double a = side(t[0], t[1], p), b = side(t[1], t[2], p), c = side(t[2], t[0], p);
  return (a > 0.0 && b > 0.0 && c > 0.0) || (a < 0.0 && b < 0.0 && c < 0.0);
}

/// Weights of the corners at a point inside, or of any corner of a triangle without area.
glm::dvec3 weightsAt(const Corners& t, const glm::dvec2& p) {
  const double area = cross(t[1] - t[0], t[2] - t[0]);
  if (area == 0.0) return {1.0, 0.0, 0.0};
  const double v = cross(p - t[0], t[2] - t[0]) / area, w = cross(t[1] - t[0], p - t[0]) / area;
  return {1.0 - v - w, v, w};
}

struct Nearest {
  double squared = 0.0;
  glm::dvec3 weight{1.0, 0.0, 0.0};
};

Nearest nearestOnEdges(const Corners& t, const glm::dvec2& p) {
  Nearest best{1e300, {}};
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t d = (c + 1) % 3;
    const glm::dvec2 edge = t[d] - t[c];
    const double squared = glm::dot(edge, edge);
    const double along = squared > 0.0 ? std::clamp(glm::dot(p - t[c], edge) / squared, 0.0, 1.0) : 0.0;
    const glm::dvec2 off = p - (t[c] + along * edge);
    if (glm::dot(off, off) >= best.squared) continue;
    best = {glm::dot(off, off), glm::dvec3(0.0)};
    best.weight[static_cast<int>(c)] = 1.0 - along;
    best.weight[static_cast<int>(d)] = along;
  }
  return best;
}

Nearest nearestPoint(const Corners& t, const glm::dvec2& p) {
  return contains(t, p) ? Nearest{0.0, weightsAt(t, p)} : nearestOnEdges(t, p);
}

/// Area of the triangle within the texel whose lowest corner is `low` (Sutherland and Hodgman 1974).
double clippedArea(const Corners& t, const glm::dvec2& low) {
  std::array<glm::dvec2, 8> polygon{t[0], t[1], t[2]}, next;
  std::size_t count = 3;
  for (int plane = 0; plane < 4; ++plane) {
    const int axis = plane / 2;
    const double sign = plane % 2 == 0 ? 1.0 : -1.0, at = plane % 2 == 0 ? low[axis] : low[axis] + 1.0;
    const auto inside = [&](const glm::dvec2& p) { return sign * (p[axis] - at); };
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec2 &a = polygon[i], &b = polygon[(i + 1) % count];
      const double da = inside(a), db = inside(b);
      if (da >= 0.0) next[kept++] = a;
      if ((da >= 0.0) != (db >= 0.0)) next[kept++] = a + (b - a) * (da / (da - db));
    }
    polygon = next;
    count = kept;
  }
  double area = 0.0;
  for (std::size_t i = 1; i + 1 < count; ++i) area += cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  return 0.5 * std::abs(area);
}

/// Triangles by the bands of rows that they may matter to.
std::vector<std::vector<std::uint32_t>> binned(const Mesh& mesh, const glm::ivec2& size) {
  std::vector<std::vector<std::uint32_t>> bands(static_cast<std::size_t>((size.y + kBand - 1) / kBand));
  for (std::uint32_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
    const Corners t = cornersOf(mesh, triangle, size);
    const double low = std::min({t[0].y, t[1].y, t[2].y}) - 2.0, high = std::max({t[0].y, t[1].y, t[2].y}) + 2.0;
    const int first = static_cast<int>(std::clamp(low, 0.0, size.y - 1.0)) / kBand,
              last = static_cast<int>(std::clamp(high, 0.0, size.y - 1.0)) / kBand;
    for (int band = first; band <= last; ++band) bands[static_cast<std::size_t>(band)].push_back(triangle);
  }
  return bands;
}

/// A band of rows under way.
struct Band {
  const Mesh& mesh;
  double diagonal = 0.0;
  int firstRow = 0, lastRow = 0;
  std::vector<double> squared;  ///< of each texel, to its site
  std::vector<double> coverage;
  std::vector<std::uint32_t> claims;  ///< kSamples of each texel: the first triangle there
  std::vector<char> overlapping;
};

/// Whether two triangles show the same surface at a point of the texture.
bool agree(const Band& band, const glm::ivec2& size, std::uint32_t a, std::uint32_t b, const glm::dvec2& p) {
  std::array<glm::dvec3, 2> place{}, face{};
  for (std::size_t k = 0; k < 2; ++k) {
    const std::uint32_t triangle = k == 0 ? a : b;
    const glm::dvec3 weight = weightsAt(cornersOf(band.mesh, triangle, size), p);
    const glm::uvec3& t = band.mesh.triangles[triangle];
    for (int c = 0; c < 3; ++c) place[k] += weight[c] * band.mesh.positions[t[c]];
    face[k] = glm::cross(band.mesh.positions[t.y] - band.mesh.positions[t.x], band.mesh.positions[t.z] - band.mesh.positions[t.x]);
  }
  return glm::length(place[0] - place[1]) <= kSamePlace * band.diagonal && glm::dot(face[0], face[1]) >= 0.0;
}

void claim(Band& band, const glm::ivec2& size, std::size_t texel, const glm::dvec2& low, std::uint32_t triangle, const Corners& t) {
  for (std::size_t s = 0; s < kSamples; ++s) {
    const auto i = static_cast<double>(s % kOverlapSamples), j = static_cast<double>(s / kOverlapSamples);
    const glm::dvec2 p = low + (glm::dvec2(i, j) + 0.5) / static_cast<double>(kOverlapSamples);
    if (!contains(t, p)) continue;
    std::uint32_t& owner = band.claims[texel * kSamples + s];
    if (owner == kNoTriangle)
      owner = triangle;
    else if (!agree(band, size, owner, triangle, p))
      band.overlapping[texel] = 1;
  }
}

void add(Band& band, ChartRaster& raster, std::uint32_t triangle) {
  const Corners t = cornersOf(band.mesh, triangle, raster.size);
  const glm::dvec2 low = glm::min(glm::min(t[0], t[1]), t[2]), high = glm::max(glm::max(t[0], t[1]), t[2]);
  const auto limited = [](double value, int last) {
    return static_cast<int>(std::clamp(std::floor(value), 0.0, static_cast<double>(last)));
  };
  const int rows = raster.size.y - 1, columns = raster.size.x - 1;
  for (int j = std::max(limited(low.y - 1.5, rows), band.firstRow); j <= std::min(limited(high.y + 1.5, rows), band.lastRow); ++j) {
    for (int i = limited(low.x - 1.5, columns); i <= limited(high.x + 1.5, columns); ++i) {
      const glm::dvec2 corner(i, j);
      const auto here = static_cast<std::size_t>(i) + static_cast<std::size_t>(raster.size.x) * static_cast<std::size_t>(j - band.firstRow);
      const Nearest nearest = nearestPoint(t, corner + 0.5);
      if (nearest.squared < std::min(band.squared[here], kReach)) {
        band.squared[here] = nearest.squared;
        raster.sites[here + static_cast<std::size_t>(raster.size.x) * static_cast<std::size_t>(band.firstRow)].at = {triangle,
                                                                                                                     nearest.weight};
      }
      const double area = nearest.squared <= 0.5 ? clippedArea(t, corner) : 0.0;
      if (area <= 0.0) continue;
      band.coverage[here] += area;
      claim(band, raster.size, here, corner, triangle, t);
    }
  }
}

/// Charts as the smallest triangle of each, by edges whose ends agree in place and texture.
std::vector<std::uint32_t> chartsOf(const Mesh& mesh, std::uint32_t& count) {
  using Key = std::array<double, 5>;
  std::vector<Key> keys;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3& p = mesh.positions[v];
    keys.push_back({p.x, p.y, p.z, double{mesh.textureCoordinates[v].x}, double{mesh.textureCoordinates[v].y}});
  }
  std::vector<std::uint32_t> order(keys.size()), point(keys.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  for (std::size_t i = 0, id = 0; i < order.size(); ++i) {
    id += i > 0 && keys[order[i]] != keys[order[i - 1]];
    point[order[i]] = static_cast<std::uint32_t>(id);
  }
  std::vector<std::array<std::uint32_t, 3>> edges;  // two points and a triangle
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t a = point[mesh.triangles[t][c]], b = point[mesh.triangles[t][(c + 1) % 3]];
      edges.push_back({std::min(a, b), std::max(a, b), t});
    }
  std::sort(edges.begin(), edges.end());
  std::vector<std::uint32_t> parent(mesh.triangles.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t t) {
    while (parent[t] != t) t = parent[t] = parent[parent[t]];
    return t;
  };
  for (std::size_t e = 1; e < edges.size(); ++e) {
    if (edges[e][0] != edges[e - 1][0] || edges[e][1] != edges[e - 1][1]) continue;
    const std::uint32_t a = root(edges[e][2]), b = root(edges[e - 1][2]);
    parent[std::max(a, b)] = std::min(a, b);
  }
  count = 0;
  for (std::uint32_t t = 0; t < parent.size(); ++t) {
    parent[t] = root(t);
    count += parent[t] == t;
  }
  return parent;
}

}  // namespace

ChartRaster rasteriseCharts(const Mesh& mesh, const glm::ivec2& size) {
  OVERCAST_REQUIRE(mesh.textureCoordinates.size() == mesh.positions.size(), "{} texture coordinates for {} vertices",
                   mesh.textureCoordinates.size(), mesh.positions.size());
  ChartRaster raster;
  raster.size = size;
  raster.sites.resize(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y));
  raster.chart = chartsOf(mesh, raster.charts);
  const std::vector<std::vector<std::uint32_t>> bands = binned(mesh, size);
  const double extent = diagonal(bounds(mesh));
  std::vector<std::uint64_t> overlapping(bands.size(), 0), covered(bands.size(), 0);
  tbb::parallel_for(std::size_t{0}, bands.size(), [&](std::size_t b) {
    Band band{mesh, extent, static_cast<int>(b) * kBand, std::min(static_cast<int>(b + 1) * kBand, size.y) - 1, {}, {}, {}, {}};
    const std::size_t texels = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(band.lastRow - band.firstRow + 1);
    band.squared.assign(texels, 1e300);
    band.coverage.assign(texels, 0.0);
    band.claims.assign(texels * kSamples, kNoTriangle);
    band.overlapping.assign(texels, 0);
    for (const std::uint32_t triangle : bands[b]) add(band, raster, triangle);
    TexelSite* sites = raster.sites.data() + static_cast<std::size_t>(size.x) * static_cast<std::size_t>(band.firstRow);
    for (std::size_t i = 0; i < texels; ++i) {
      sites[i].coverage = static_cast<float>(std::min(band.coverage[i], 1.0));
      covered[b] += band.coverage[i] > 0.0;
      overlapping[b] += static_cast<std::uint64_t>(band.overlapping[i]);
    }
  });
  raster.covered = std::accumulate(covered.begin(), covered.end(), std::uint64_t{0});
  raster.overlapping = std::accumulate(overlapping.begin(), overlapping.end(), std::uint64_t{0});
  return raster;
}

int usableLevels(const ChartRaster& raster) {
  constexpr std::uint32_t kMixed = kNoTriangle - 1;
  std::vector<std::uint32_t> chart;  // of each texel of a level; kNoTriangle off the surface
  for (const TexelSite& site : raster.sites) chart.push_back(site.coverage > 0.0f ? raster.chart[site.at.triangle] : kNoTriangle);
  glm::ivec2 size = raster.size;
  const int levels = mipmapLevels(size.x, size.y);
  for (int level = 1; level < levels; ++level) {
    const glm::ivec2 coarse = glm::max(size / 2, glm::ivec2(1));
    std::vector<std::uint32_t> next(static_cast<std::size_t>(coarse.x) * static_cast<std::size_t>(coarse.y), kNoTriangle);
    for (int j = 0; j < size.y; ++j)
      for (int i = 0; i < size.x; ++i) {
        const std::uint32_t here = chart[static_cast<std::size_t>(i) + static_cast<std::size_t>(size.x) * static_cast<std::size_t>(j)];
        std::uint32_t& there = next[static_cast<std::size_t>(i * coarse.x / size.x) +
                                    static_cast<std::size_t>(coarse.x) * static_cast<std::size_t>(j * coarse.y / size.y)];
        if (here != kNoTriangle) there = there == kNoTriangle || there == here ? here : kMixed;
      }
    const auto mixed = static_cast<double>(std::count(next.begin(), next.end(), kMixed));
    const auto off = static_cast<double>(std::count(next.begin(), next.end(), kNoTriangle));
    if (mixed > kMostMixed * (static_cast<double>(next.size()) - off)) return level;
    chart = std::move(next);
    size = coarse;
  }
  return levels;
}

}  // namespace overcast
