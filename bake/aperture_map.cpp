#include "bake/aperture_map.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <glm/geometric.hpp>

#include "bake/chart_atlas.h"
#include "bake/chart_raster.h"
#include "formats/normals.h"

namespace overcast {
namespace {

/// A site's point, off the edges of its triangle: on an edge it would lie in the plane of the wall that begins there.
SurfacePoint originOf(const Mesh& mesh, SurfaceSample sample, double pull) {
  const glm::uvec3& t = mesh.triangles[sample.triangle];
  glm::dvec3 point(0.0), middle(0.0);
  for (int c = 0; c < 3; ++c) {
    point += sample.weight[c] * mesh.positions[t[c]];
    middle += mesh.positions[t[c]] / 3.0;
  }
  const double length = glm::length(middle - point);
  const double share = length > pull ? pull / length : 1.0;
  if (length > 0.0) sample.weight = glm::mix(sample.weight, glm::dvec3(1.0 / 3.0), share);
  return surfacePoint(mesh, sample);
}

ApertureTexel texelOf(const PointVisibility& seen, float coverage) {
  return {{seen.direction, capRadius(double{seen.visible})}, seen.ambient, coverage};
}

/// Sum of texels, componentwise, as bilinear sampling has it.
struct TexelSum {
  glm::dvec3 direction{0.0};
  double radius = 0.0;
  double ambient = 0.0;
  double count = 0.0;
};

ApertureTexel mean(const TexelSum& sum, const ApertureTexel& old, const glm::vec3& fallback) {
  const double length = glm::length(sum.direction);
  const glm::vec3 direction = length > 0.0 ? glm::vec3(sum.direction / length) : fallback;
  return {{direction, static_cast<float>(sum.radius / sum.count)}, static_cast<float>(sum.ambient / sum.count), old.coverage};
}

/// Fills texels that are not known with the mean of the known ones among the eight around them, ring by ring.
void fillRings(const glm::ivec2& size, std::vector<char>& known, std::vector<ApertureTexel>& texels) {
  const auto at = [&](int i, int j) {
    return static_cast<std::size_t>(i) + static_cast<std::size_t>(size.x) * static_cast<std::size_t>(j);
  };
  const auto around = [&](std::uint32_t texel, auto visit) {
    const int i = static_cast<int>(texel) % size.x, j = static_cast<int>(texel) / size.x;
    for (int y = std::max(j - 1, 0); y <= std::min(j + 1, size.y - 1); ++y)
      for (int x = std::max(i - 1, 0); x <= std::min(i + 1, size.x - 1); ++x)
        if (x != i || y != j) visit(at(x, y));
  };
  std::vector<std::uint32_t> ring;
  std::vector<char> queued(known.begin(), known.end());
  const auto queueAround = [&](std::uint32_t texel, std::vector<std::uint32_t>& queue) {
    around(texel, [&](std::size_t n) {
      if (!queued[n]) queue.push_back(static_cast<std::uint32_t>(n));
      queued[n] = 1;
    });
  };
  for (std::uint32_t texel = 0; texel < texels.size(); ++texel)
    if (known[texel]) queueAround(texel, ring);
  while (!ring.empty()) {
    std::vector<ApertureTexel> filled;
    for (const std::uint32_t texel : ring) {
      TexelSum sum;
      glm::vec3 first(0.0f, 1.0f, 0.0f);
      around(texel, [&](std::size_t n) {
        if (!known[n]) return;
        if (sum.count == 0.0) first = texels[n].aperture.direction;
        sum.direction += glm::dvec3(texels[n].aperture.direction);
        sum.radius += double{texels[n].aperture.radius};
        sum.ambient += double{texels[n].ambient};
        sum.count += 1.0;
      });
      filled.push_back(mean(sum, texels[texel], first));
    }
    std::vector<std::uint32_t> next;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      texels[ring[i]] = filled[i];
      known[ring[i]] = 1;
    }
    for (const std::uint32_t texel : ring) queueAround(texel, next);
    ring = std::move(next);
  }
}

/// Looks out of all texels that have a site.
void traceTexels(const Mesh& mesh, const Occluders& occluders, const ApertureMapSettings& settings, const ChartRaster& raster,
                 const Progress& progress, BakedApertureMap& baked) {
  const double pull = kVertexPull * diagonal(bounds(mesh));
  std::vector<SurfacePoint> origins;
  std::vector<std::uint32_t> place;
  for (std::uint32_t texel = 0; texel < raster.sites.size(); ++texel) {
    if (raster.sites[texel].at.triangle == kNoTriangle) continue;
    origins.push_back(originOf(mesh, raster.sites[texel].at, pull));
    place.push_back(texel);
  }
  const std::vector<PointVisibility> seen = traceVisibility(occluders, origins, settings.visibility, progress);
  std::vector<ApertureTexel>& texels = baked.map.levels.emplace_back(raster.sites.size());
  std::vector<char> known(texels.size(), 0);
  ApertureMapReport& report = baked.report;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    texels[place[i]] = texelOf(seen[i], raster.sites[place[i]].coverage);
    known[place[i]] = static_cast<char>(!seen[i].interior);
    report.interior += seen[i].interior;
    report.shut += !seen[i].interior && seen[i].visible == 0.0f;
  }
  report.traced = seen.size();
  report.rays += seen.size() * static_cast<std::uint64_t>(settings.visibility.rays);
  if (report.interior == report.traced)  // nothing better is known than what it looks like from within
    for (const std::uint32_t texel : place) known[texel] = 1;
  fillRings(raster.size, known, texels);
}

/// What bilinear sampling shows at random points of the surface against what is visible there.
void measure(const Mesh& mesh, const Occluders& occluders, const ApertureMapSettings& settings, const Progress& progress,
             BakedApertureMap& baked) {
  const std::vector<SurfaceSample> samples = sampleSurface(mesh, settings.errorSamples, settings.seed);
  std::vector<SurfacePoint> origins;
  for (const SurfaceSample& sample : samples) origins.push_back(surfacePoint(mesh, sample));
  const std::vector<PointVisibility> seen = traceVisibility(occluders, origins, settings.visibility, progress);
  baked.report.rays += seen.size() * static_cast<std::uint64_t>(settings.visibility.rays);
  std::vector<std::pair<ApertureSample, ApertureSample>> pairs;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].interior) continue;
    glm::dvec2 coordinate(0.0);
    for (int c = 0; c < 3; ++c)
      coordinate += samples[i].weight[c] * glm::dvec2(mesh.textureCoordinates[mesh.triangles[samples[i].triangle][c]]);
    const ApertureTexel shown = sampleApertureMap(baked.map, coordinate);
    ApertureSample there;
    there.direction = glm::dvec3(shown.aperture.direction);
    there.radius = double{shown.aperture.radius};
    there.ambient = double{shown.ambient};
    pairs.emplace_back(there, sampleOf(seen[i]));
  }
  baked.report.samples = pairs.size();
  baked.report.error = interpolationError(pairs);
}

/// Moves and shrinks texture coordinates that leave [0, 1] into it.
void fitCoordinates(Mesh& mesh) {
  glm::dvec2 low(1e300), high(-1e300);
  for (const glm::uvec3& t : mesh.triangles)
    for (int c = 0; c < 3; ++c) {
      low = glm::min(low, glm::dvec2(mesh.textureCoordinates[t[c]]));
      high = glm::max(high, glm::dvec2(mesh.textureCoordinates[t[c]]));
    }
  if (std::min(low.x, low.y) >= 0.0 && std::max(high.x, high.y) <= 1.0) return;
  const double size = std::max({high.x - low.x, high.y - low.y, 1.0});  // what is small enough keeps its number of texels
  for (glm::vec2& c : mesh.textureCoordinates) c = glm::clamp(glm::vec2((glm::dvec2(c) - low) / size), glm::vec2(0.0f), glm::vec2(1.0f));
}

/// Why the texture coordinates of a mesh carry no map; empty when they do.
std::string unusableCoordinates(const Mesh& mesh, int texels) {
  const ChartRaster raster = rasteriseCharts(mesh, glm::ivec2(texels));
  if (raster.covered == 0) return "has texture coordinates without area";
  const double share = static_cast<double>(raster.overlapping) / static_cast<double>(raster.covered);
  if (share <= kMostOverlap) return "";
  return fmt::format("has texture coordinates whose charts overlap on {:.3g} % of the texels they cover", 100.0 * share);
}

}  // namespace

Result<Done> layOut(Mesh& mesh, const ApertureMapSettings& settings) {
  if (settings.atlas) {
    auto packed = packTriangles(mesh, settings.texels);
    if (!packed) return packed.error();
    mesh = std::move(packed).value();
    return Done{};
  }
  const char* help = "; --atlas makes it some of its own";
  if (mesh.textureCoordinates.empty()) return Error{"", "", std::string("has no texture coordinates on all its triangles") + help};
  fitCoordinates(mesh);
  const std::string why = unusableCoordinates(mesh, settings.texels);
  if (!why.empty()) return Error{"", "", why + help};
  return Done{};
}

BakedApertureMap bakeApertureMap(const Mesh& mesh, const Occluders& occluders, const ApertureMapSettings& settings,
                                 const Progress& progress) {
  OVERCAST_REQUIRE(mesh.normals.size() == mesh.positions.size(), "{} normals for {} vertices", mesh.normals.size(), mesh.positions.size());
  const auto start = std::chrono::steady_clock::now();
  const ChartRaster raster = rasteriseCharts(mesh, glm::ivec2(settings.texels));
  BakedApertureMap baked{{raster.size, {}, usableLevels(raster)}, {}};
  baked.report.size = raster.size;
  baked.report.covered = raster.covered;
  baked.report.overlapping = raster.overlapping;
  baked.report.charts = raster.charts;
  baked.report.levels = baked.map.usableLevels;
  traceTexels(mesh, occluders, settings, raster, progress, baked);
  buildLevels(baked.map);
  baked.map = asStored(std::move(baked.map));
  if (settings.errorSamples > 0) measure(mesh, occluders, settings, progress, baked);
  baked.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return baked;
}

Result<BakedApertureMap> bakeApertureMap(Mesh& mesh, const ApertureMapSettings& settings, const Progress& progress) {
  if (mesh.normals.empty()) mesh = withNormals(std::move(mesh));
  mendNormals(mesh);
  if (const auto laidOut = layOut(mesh, settings); !laidOut) return laidOut.error();
  auto scene = makeRayScene(mesh);
  if (!scene) return scene.error();
  return bakeApertureMap(mesh, {scene.value().get(), nullptr}, settings, progress);
}

}  // namespace overcast
