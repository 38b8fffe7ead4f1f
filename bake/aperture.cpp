#include "bake/aperture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>

#include "bake/aperture_fit.h"
#include "bake/clearance.h"
#include "bake/random.h"

namespace overcast {
namespace {

constexpr std::uint64_t kFitSeed = 0x6f617473;     // away from the measurement's
constexpr std::uint64_t kChoiceSeed = 0x63686f69;  // and of the points that decide whether to fit
constexpr std::size_t kFitSamplesPerPoint = 24;
constexpr std::size_t kLeastFitSamples = 8192;
constexpr std::size_t kMostFitSamples = 131072;

/// The distinct pairs of position and normal, in their own order: it does not depend on that of the vertices, nor on place and scale.
struct Points {
  std::vector<std::uint32_t> first;  ///< of the vertices of each point
  std::vector<std::uint32_t> ofVertex;
  std::vector<glm::uvec3> triangles;  ///< over points
};

Points distinctPoints(const Mesh& mesh) {
  const auto key = [&](std::uint32_t v) {
    const glm::dvec3& p = mesh.positions[v];
    const glm::vec3& n = mesh.normals[v];
    return std::array<double, 6>{p.x, p.y, p.z, double{n.x}, double{n.y}, double{n.z}};
  };
  std::vector<std::uint32_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  Points points;
  points.ofVertex.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || key(order[i]) != key(order[i - 1])) points.first.push_back(order[i]);
    points.ofVertex[order[i]] = static_cast<std::uint32_t>(points.first.size() - 1);
  }
  for (const glm::uvec3& t : mesh.triangles)
    points.triangles.emplace_back(points.ofVertex[t.x], points.ofVertex[t.y], points.ofVertex[t.z]);
  return points;
}

/// Where each point looks from: pulled a little into its triangles, along the plane of its normal, and in front of all of them.
std::vector<SurfacePoint> vertexOrigins(const Mesh& mesh, const Points& points) {
  std::vector<glm::dvec3> inward(points.first.size(), glm::dvec3(0.0));
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const glm::dvec3 middle = (mesh.positions[t.x] + mesh.positions[t.y] + mesh.positions[t.z]) / 3.0;
    for (int c = 0; c < 3; ++c) {
      const glm::dvec3 way = middle - mesh.positions[t[c]];
      const double length = glm::length(way);
      if (length > 0.0) inward[points.triangles[i][c]] += way / length;
    }
  }
  const double pull = kVertexPull * diagonal(bounds(mesh));
  std::vector<SurfacePoint> origins;
  for (std::size_t i = 0; i < points.first.size(); ++i) {
    const glm::dvec3 normal(mesh.normals[points.first[i]]);
    const glm::dvec3 along = inward[i] - normal * glm::dot(normal, inward[i]);
    const double length = glm::length(along);
    const glm::dvec3 step = length > 1.0 ? along / length : along;
    origins.push_back({mesh.positions[points.first[i]] + pull * step, mesh.normals[points.first[i]]});
  }
  clearOfTriangles(mesh, points.triangles, points.first, origins);
  return origins;
}

void add(ApertureSample& sum, const ApertureSample& sample, double weight) {
  sum.direction += weight * sample.direction;
  sum.radius += weight * sample.radius;
  sum.ambient += weight * sample.ambient;
  for (std::size_t i = 0; i < sum.transfer.size(); ++i) sum.transfer[i] += weight * sample.transfer[i];
}

glm::dvec3 unitOr(const glm::dvec3& v, const glm::dvec3& fallback) {
  const double length = glm::length(v);
  return length > 0.0 ? v / length : fallback;
}

/// Fills the points in `open` with the mean of their neighbours that are not, ring by ring. Points that no ring reaches are left.
void fillFromNeighbours(std::span<const glm::uvec3> triangles, std::vector<char> open, std::vector<ApertureSample>& samples) {
  std::vector<std::uint32_t> ring;
  do {
    std::vector<ApertureSample> sum(samples.size(), {glm::dvec3(0.0), 0.0, 0.0, {}});
    std::vector<double> weight(samples.size(), 0.0);
    for (const glm::uvec3& t : triangles)
      for (int c = 0; c < 3; ++c)
        for (const int d : {(c + 1) % 3, (c + 2) % 3}) {
          if (!open[t[c]] || open[t[d]]) continue;
          add(sum[t[c]], samples[t[d]], 1.0);
          weight[t[c]] += 1.0;
        }
    ring.clear();
    for (std::uint32_t i = 0; i < samples.size(); ++i)
      if (weight[i] > 0.0) ring.push_back(i);
    for (const std::uint32_t i : ring) {
      const glm::dvec3 direction = unitOr(sum[i].direction, samples[i].direction);
      samples[i] = {glm::dvec3(0.0), 0.0, 0.0, {}};
      add(samples[i], sum[i], 1.0 / weight[i]);
      samples[i].direction = direction;
      open[i] = 0;
    }
  } while (!ring.empty());
}

/// What is seen at samples of the surface; those in solids are left out.
std::vector<FitSample> observe(const Mesh& mesh, const Points& points, const Occluders& occluders, const VisibilitySettings& settings,
                               std::span<const SurfaceSample> samples, const Progress& progress) {
  std::vector<SurfacePoint> origins;
  for (const SurfaceSample& sample : samples) origins.push_back(surfacePoint(mesh, sample));
  const std::vector<PointVisibility> visible = traceVisibility(occluders, origins, settings, progress);
  std::vector<FitSample> observed;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (visible[i].interior) continue;
    observed.push_back({points.triangles[samples[i].triangle], samples[i].weight, sampleOf(visible[i])});
  }
  return observed;
}

ApertureSample interpolated(const std::vector<ApertureSample>& vertices, const FitSample& at) {
  ApertureSample sample{glm::dvec3(0.0), 0.0, 0.0, {}};
  for (int c = 0; c < 3; ++c) add(sample, vertices[at.corner[c]], at.weight[c]);
  return sample;
}

InterpolationError errorOf(const std::vector<ApertureSample>& vertices, const std::vector<FitSample>& observed) {
  std::vector<std::pair<ApertureSample, ApertureSample>> pairs;
  for (const FitSample& at : observed) pairs.emplace_back(interpolated(vertices, at), at.seen);
  return interpolationError(pairs);
}

bool isCoarse(const InterpolationError& error) {
  return error.radius > kCoarse || error.ambient > kCoarse;
}

/// Whether lights and sky would look more like the truth with `a` than with `b`.
bool isBetter(const InterpolationError& a, const InterpolationError& b) {
  return a.radius + a.ambient + a.direction < b.radius + b.ambient + b.direction;
}

VertexVisibility visibilityOf(const Points& points, const std::vector<ApertureSample>& samples, const ApertureSettings& settings) {
  VertexVisibility visibility;
  visibility.bits = settings.bits;
  for (const std::uint32_t point : points.ofVertex) {
    const ApertureSample& sample = samples[point];
    const auto widest = double{capRadius(1.0)};
    visibility.apertures.push_back({glm::vec3(sample.direction), static_cast<float>(std::clamp(sample.radius, 0.0, widest))});
    visibility.ambient.push_back(static_cast<float>(std::clamp(sample.ambient, 0.0, 1.0)));
    if (!settings.visibility.transfer) continue;
    visibility.transfer.emplace_back();
    std::transform(sample.transfer.begin(), sample.transfer.end(), visibility.transfer.back().begin(),
                   [](double t) { return static_cast<float>(t); });
  }
  std::vector<float> ambient = visibility.ambient;
  visibility = asStored(std::move(visibility));
  if (visibility.ambient.empty()) visibility.ambient = std::move(ambient);
  return visibility;
}

/// What is stored, as samples of the points.
std::vector<ApertureSample> storedSamples(const Points& points, const VertexVisibility& visibility) {
  std::vector<ApertureSample> samples;
  for (const std::uint32_t vertex : points.first) {
    ApertureSample sample;
    sample.direction = glm::dvec3(visibility.apertures[vertex].direction);
    sample.radius = double{visibility.apertures[vertex].radius};
    if (!visibility.ambient.empty()) sample.ambient = double{visibility.ambient[vertex]};
    if (!visibility.transfer.empty()) std::copy_n(visibility.transfer[vertex].begin(), sample.transfer.size(), sample.transfer.begin());
    samples.push_back(sample);
  }
  return samples;
}

/// The whole bake of one mesh, step by step.
struct Job {
  const Mesh& mesh;
  const ApertureSettings& settings;
  const Progress& progress;
  const Occluders& occluders;
  Points points;
  std::vector<ApertureSample> samples;  ///< of the points
  std::vector<FitSample> test;          ///< what the result is measured against
  ApertureReport report;

  std::vector<FitSample> observed(std::uint64_t count, std::uint64_t seed) {
    const std::vector<SurfaceSample> drawn = sampleSurface(mesh, count, seed);
    report.rays += drawn.size() * static_cast<std::uint64_t>(settings.visibility.rays);
    return observe(mesh, points, occluders, settings.visibility, drawn, progress);
  }
};

/// Vertices that see the sky from their other side alone, given what is seen from `origins`.
std::uint64_t countInward(Job& job, std::span<const SurfacePoint> origins, std::span<const PointVisibility> before) {
  std::vector<SurfacePoint> behind;
  std::vector<std::size_t> point;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    if (!before[i].interior && before[i].visible > 0.0f) continue;
    behind.push_back({origins[i].position, -origins[i].normal});
    point.push_back(i);
  }
  const std::vector<PointVisibility> seen = traceVisibility(job.occluders, behind, job.settings.visibility, job.progress);
  job.report.rays += seen.size() * static_cast<std::uint64_t>(job.settings.visibility.rays);
  std::vector<char> inward(origins.size(), 0);
  for (std::size_t i = 0; i < seen.size(); ++i) inward[point[i]] = static_cast<char>(!seen[i].interior && seen[i].visible > 0.0f);
  std::uint64_t count = 0;
  for (const std::uint32_t of : job.points.ofVertex) count += static_cast<std::uint64_t>(inward[of]);
  return count;
}

void bakeVertices(Job& job) {
  const std::vector<SurfacePoint> origins = vertexOrigins(job.mesh, job.points);
  const std::vector<PointVisibility> seen = traceVisibility(job.occluders, origins, job.settings.visibility, job.progress);
  job.report.rays += seen.size() * static_cast<std::uint64_t>(job.settings.visibility.rays);
  std::vector<char> interior;
  for (const PointVisibility& point : seen) {
    interior.push_back(static_cast<char>(point.interior));
    job.samples.push_back(sampleOf(point));
  }
  for (const std::uint32_t point : job.points.ofVertex) job.report.interior += static_cast<std::uint64_t>(interior[point]);
  job.report.inward = countInward(job, origins, seen);
  fillFromNeighbours(job.points.triangles, std::move(interior), job.samples);
}

/// Fits where the mesh is coarse, if that lowers the error at points that neither the fit nor the measurement sees.
void refine(Job& job) {
  const std::vector<FitSample> choice = job.observed((job.settings.errorSamples + 1) / 2, job.settings.seed ^ kChoiceSeed);
  const InterpolationError plain = errorOf(job.samples, choice);
  if (choice.empty() || !isCoarse(plain)) return;
  const std::size_t wanted = std::clamp(kFitSamplesPerPoint * job.points.first.size(), kLeastFitSamples, kMostFitSamples);
  const std::vector<FitSample> training = job.observed(wanted, job.settings.seed ^ kFitSeed);
  std::vector<ApertureSample> fitted = fitApertures(job.samples, job.points.triangles, training);
  if (!isBetter(errorOf(fitted, choice), plain)) return;
  job.samples = std::move(fitted);
  job.report.fitted = true;
}

}  // namespace

BakedApertures bakeApertures(const Mesh& mesh, const Occluders& occluders, const ApertureSettings& settings, const Progress& progress) {
  OVERCAST_REQUIRE(mesh.normals.size() == mesh.positions.size(), "{} normals for {} vertices", mesh.normals.size(), mesh.positions.size());
  const auto start = std::chrono::steady_clock::now();
  Job job{mesh, settings, progress, occluders, distinctPoints(mesh), {}, {}, {}};
  job.report.vertices = mesh.positions.size();
  job.report.points = job.points.first.size();
  bakeVertices(job);
  if (settings.errorSamples > 0) {
    job.test = job.observed(settings.errorSamples, settings.seed);
    job.report.samples = job.test.size();
    job.report.sampled = errorOf(job.samples, job.test);
    refine(job);
  }
  BakedApertures baked{visibilityOf(job.points, job.samples, settings), {}};
  job.report.error = errorOf(storedSamples(job.points, baked.visibility), job.test);
  for (const Aperture& aperture : baked.visibility.apertures) job.report.shut += aperture.radius == 0.0f;
  job.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  baked.report = job.report;
  return baked;
}

InterpolationError measureApertures(const Mesh& mesh, const Occluders& occluders, const ApertureSettings& settings) {
  const Progress progress;
  Job job{mesh, settings, progress, occluders, distinctPoints(mesh), {}, {}, {}};
  return errorOf(storedSamples(job.points, *mesh.visibility), job.observed(settings.errorSamples, settings.seed));
}

std::vector<VertexLook> lookAgain(const Mesh& mesh, const Occluders& occluders, const VisibilitySettings& settings, std::size_t count,
                                  std::uint64_t seed) {
  const Points points = distinctPoints(mesh);
  const std::vector<SurfacePoint> origins = vertexOrigins(mesh, points);
  const std::vector<ApertureSample> stored = storedSamples(points, *mesh.visibility);
  std::vector<SurfacePoint> from;
  std::vector<VertexLook> looks;
  const double every = std::max(1.0, static_cast<double>(origins.size()) / static_cast<double>(count));
  for (double at = every > 1.0 ? every * uniform(seed, 0) : 0.0; at < static_cast<double>(origins.size()); at += every) {
    const auto point = static_cast<std::size_t>(at);
    from.push_back(origins[point]);
    looks.push_back({points.first[point], stored[point], {}});
  }
  const std::vector<PointVisibility> seen = traceVisibility(occluders, from, settings);
  for (std::size_t i = 0; i < looks.size(); ++i) looks[i].seen = sampleOf(seen[i]);
  return looks;
}

Result<BakedApertures> bakeApertures(const Mesh& mesh, const ApertureSettings& settings, const Progress& progress) {
  auto scene = makeRayScene(mesh);
  if (!scene) return scene.error();
  return bakeApertures(mesh, {scene.value().get(), nullptr}, settings, progress);
}

ApertureSample sampleOf(const PointVisibility& seen) {
  ApertureSample sample;
  sample.direction = glm::dvec3(seen.direction);
  sample.radius = double{capRadius(double{seen.visible})};
  sample.ambient = double{seen.ambient};
  std::copy(seen.transfer.begin(), seen.transfer.end(), sample.transfer.begin());
  return sample;
}

InterpolationError interpolationError(std::span<const std::pair<ApertureSample, ApertureSample>> shownAndSeen) {
  InterpolationError sum;
  double directions = 0.0;
  for (const auto& [shown, seen] : shownAndSeen) {
    sum.radius += std::pow(shown.radius - seen.radius, 2.0);
    sum.ambient += std::pow(shown.ambient - seen.ambient, 2.0);
    if (seen.radius <= 0.0) continue;
    const glm::dvec3 across = glm::cross(shown.direction, seen.direction);
    sum.direction += std::pow(std::atan2(glm::length(across), glm::dot(shown.direction, seen.direction)), 2.0);
    directions += 1.0;
  }
  const auto rms = [](double total, double count) { return count > 0.0 ? std::sqrt(total / count) : 0.0; };
  const auto count = static_cast<double>(shownAndSeen.size());
  return {rms(sum.radius, count), rms(sum.ambient, count), rms(sum.direction, directions)};
}

std::vector<SurfaceSample> sampleSurface(const Mesh& mesh, std::uint64_t count, std::uint64_t seed) {
  std::vector<double> until;
  double total = 0.0;
  const double scale = diagonal(bounds(mesh));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = (mesh.positions[t.y] - mesh.positions[t.x]) / scale, b = (mesh.positions[t.z] - mesh.positions[t.x]) / scale;
    until.push_back(total += glm::length(glm::cross(a, b)));
  }
  std::vector<SurfaceSample> samples;
  for (std::uint64_t i = 0; i < count && total > 0.0; ++i) {
    const double at = uniform(seed, 3 * i) * total;
    const auto triangle = std::upper_bound(until.begin(), until.end(), at) - until.begin();
    double u = uniform(seed, 3 * i + 1), v = uniform(seed, 3 * i + 2);
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    samples.push_back({static_cast<std::uint32_t>(triangle), {1.0 - u - v, u, v}});
  }
  return samples;
}

glm::dvec3 liftAt(const std::array<glm::dvec3, 3>& corners, const std::array<glm::dvec3, 3>& normals, const glm::dvec3& weight) {
  const glm::dvec3 point = weight.x * corners[0] + weight.y * corners[1] + weight.z * corners[2];
  glm::dvec3 lift(0.0);
  for (std::size_t c = 0; c < 3; ++c)
    lift -= weight[static_cast<int>(c)] * std::min(0.0, glm::dot(point - corners[c], normals[c])) * normals[c];
  return lift;
}

SurfacePoint surfacePoint(const Mesh& mesh, const SurfaceSample& sample) {
  const glm::uvec3& t = mesh.triangles[sample.triangle];
  std::array<glm::dvec3, 3> corners, normals;
  glm::dvec3 point(0.0), normal(0.0);
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    corners[i] = mesh.positions[t[c]];
    normals[i] = glm::dvec3(mesh.normals[t[c]]);
    point += sample.weight[c] * corners[i];
    normal += sample.weight[c] * normals[i];
  }
  const glm::dvec3 face = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  return {point + liftAt(corners, normals, sample.weight), glm::vec3(unitOr(normal, unitOr(face, glm::dvec3(0.0, 1.0, 0.0))))};
}

}  // namespace overcast
