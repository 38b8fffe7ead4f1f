// overcast-bench-visibility MESH...: rays per second beside Embree's stream call on the same rays in the same run, the error of the
// presets, and what scale and place change.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <CLI/CLI.hpp>

#include "bake/aperture.h"
#include "bake/visibility.h"
#include "formats/normals.h"
#include "tests/bench/peer_rays.h"

namespace overcast::bench {
namespace {

struct Settings {
  std::vector<std::string> meshes;
  int rays = 256;
  int runs = 5;
  int truthRays = 65536;
  std::size_t truthPoints = 400;
};

constexpr std::size_t kRaysPerCall = std::size_t{1} << 20;

double cpuSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::vector<SurfacePoint> verticesOf(const Mesh& mesh) {
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) points.push_back({mesh.positions[i], mesh.normals[i]});
  return points;
}

/// The very rays of traceVisibility, point after point in Morton order.
void addRays(const Mesh& mesh, const SurfacePoint& point, std::uint64_t index, const std::vector<glm::dvec3>& directions,
             std::vector<PeerRay>& rays) {
  const glm::dvec3 normal(point.normal);
  const auto frame = frameOf(normal, azimuthOf(index));
  const glm::dvec3 start = point.position + kRayOffset * diagonal(bounds(mesh)) * normal;
  for (const glm::dvec3& d : directions) rays.push_back({start, frame[0] * d.x + frame[1] * d.y + frame[2] * d.z});
}

StreamResult traceAll(const StreamPeer& peer, const Mesh& mesh, std::span<const SurfacePoint> points, int count) {
  const std::vector<glm::dvec3> directions = hemisphereDirections(count);
  StreamResult sum;
  std::vector<PeerRay> rays;
  const auto flush = [&] {
    const StreamResult part = streamRays(peer, rays);
    sum.hits += part.hits;
    sum.cpuSeconds += part.cpuSeconds;
    rays.clear();
  };
  for (const std::uint32_t i : mortonOrder(points)) {
    if (rays.size() + directions.size() > kRaysPerCall) flush();
    addRays(mesh, points[i], i, directions, rays);
  }
  flush();
  return sum;
}

/// Ways to set up the peer: the first traces with our flags.
struct PeerKind {
  const char* name;
  bool watertight;
};
constexpr std::array<PeerKind, 2> kPeers = {{{"default flags, as ours:", false}, {"robust flag:", true}}};

struct Speed {
  std::vector<double> ours, bake;  ///< million rays per second of CPU
  std::array<std::vector<double>, kPeers.size()> peers;
  double differing = 0.0;  ///< share of rays that the first peer decides otherwise
};

/// Runs interleaved, on one thread.
Speed measureSpeed(const Mesh& mesh, const Settings& settings) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<SurfacePoint> points = verticesOf(mesh);
  auto scene = makeRayScene(mesh);
  std::array<StreamPeerPointer, kPeers.size()> peers;
  for (std::size_t p = 0; p < kPeers.size(); ++p) peers[p] = makeStreamPeer(mesh, kPeers[p].watertight);
  const double rays = static_cast<double>(points.size() * hemisphereDirections(settings.rays).size());
  Speed speed;
  for (int run = 0; run < settings.runs; ++run) {
    const double start = cpuSeconds();
    const std::vector<PointVisibility> seen = traceVisibility({scene.value().get(), nullptr}, points, {settings.rays, false});
    speed.ours.push_back(1e-6 * rays / (cpuSeconds() - start));
    double hidden = 0.0;
    for (const PointVisibility& point : seen) hidden += (1.0 - double{point.visible}) * rays / static_cast<double>(points.size());
    for (std::size_t p = 0; p < peers.size(); ++p) {
      const StreamResult found = traceAll(*peers[p], mesh, points, settings.rays);
      speed.peers[p].push_back(1e-6 * rays / found.cpuSeconds);
      if (p == 0) speed.differing = std::abs(hidden - static_cast<double>(found.hits)) / rays;
    }
    const double bakeStart = cpuSeconds();
    ApertureSettings bake;
    bake.visibility = {settings.rays, true};
    bake.bits = ApertureBits::packed64;
    const auto baked = bakeApertures(mesh, bake);
    speed.bake.push_back(1e-6 * static_cast<double>(baked.value().report.rays) / (cpuSeconds() - bakeStart));
  }
  return speed;
}

void print(const Speed& speed, const Settings& settings) {
  const double ours = median(speed.ours), bake = median(speed.bake);
  fmt::print("  million rays per second and core, {} rays per vertex: traced {:.2f}, whole bake {:.2f}\n", settings.rays, ours, bake);
  for (std::size_t p = 0; p < kPeers.size(); ++p) {
    const double peer = median(speed.peers[p]);
    fmt::print("  Embree's stream, {:<24} {:6.2f} (traced {:.2f} times, baked {:.2f} times)\n", kPeers[p].name, peer, ours / peer,
               bake / peer);
  }
  fmt::print("  hits differ from the first stream's by {:.1e} of the rays\n", speed.differing);
}

struct Rmse {
  double ambient = 0.0;
  double radius = 0.0;
};

Rmse rmse(const std::vector<PointVisibility>& a, const std::vector<PointVisibility>& b) {
  Rmse sum;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum.ambient += std::pow(double{a[i].ambient} - double{b[i].ambient}, 2.0);
    sum.radius += std::pow(double{capRadius(double{a[i].visible})} - double{capRadius(double{b[i].visible})}, 2.0);
  }
  const auto count = static_cast<double>(a.size());
  return {std::sqrt(sum.ambient / count), std::sqrt(sum.radius / count)};
}

/// Points spread over the mesh's vertices.
std::vector<SurfacePoint> some(const std::vector<SurfacePoint>& all, std::size_t count) {
  std::vector<SurfacePoint> points;
  const std::size_t step = std::max<std::size_t>(1, all.size() / count);
  for (std::size_t i = 0; i < all.size(); i += step) points.push_back(all[i]);
  return points;
}

std::vector<PointVisibility> seen(const Mesh& mesh, const std::vector<SurfacePoint>& points, int rays) {
  const auto scene = makeRayScene(mesh);
  return traceVisibility({scene.value().get(), nullptr}, points, {rays, false});
}

Mesh placed(Mesh mesh, double scale, const glm::dvec3& offset) {
  for (glm::dvec3& p : mesh.positions) p = scale * p + offset;
  return mesh;
}

std::string rmseText(const Rmse& error) {
  return fmt::format("{:7.4f} {:7.4f}", error.ambient, error.radius);
}

bool report(const std::string& path, const Settings& settings) {
  auto file = readMesh(path);
  if (!file) {
    fmt::print(stderr, "overcast-bench-visibility: {}\n", message(file.error()));
    return false;
  }
  Mesh mesh = withNormals(std::move(file.value().mesh));
  mesh.visibility.reset();
  const Speed speed = measureSpeed(mesh, settings);
  fmt::print("{}: {} triangles, {} vertices\n", path.substr(path.rfind('/') + 1), mesh.triangles.size(), mesh.positions.size());
  print(speed, settings);

  const std::vector<SurfacePoint> all = verticesOf(mesh), points = some(all, settings.truthPoints);
  const std::vector<PointVisibility> truth = seen(mesh, points, settings.truthRays);
  for (const int rays : {128, 256, 1024})
    fmt::print("  {:4} rays against {}: RMSE of ambient and of radius {}\n", rays, settings.truthRays,
               rmseText(rmse(seen(mesh, points, rays), truth)));
  const std::vector<PointVisibility> here = seen(mesh, all, settings.rays);
  const double far = 1e5 * diagonal(bounds(mesh));
  const auto moved = [&](const char* how, double scale, double offset) {
    const Mesh other = placed(mesh, scale, glm::dvec3(offset, -offset, offset));
    fmt::print("  {:<28} RMSE of ambient and of radius {}\n", how, rmseText(rmse(seen(other, verticesOf(other), settings.rays), here)));
  };
  moved("scaled by 1e-4:", 1e-4, 0.0);
  moved("scaled by 1e4:", 1e4, 0.0);
  moved("moved by 1e5 diagonals:", 1.0, far);
  std::fflush(stdout);
  return true;
}

}  // namespace
}  // namespace overcast::bench

int main(int argc, char** argv) {
  using namespace overcast::bench;
  CLI::App app("Rays per second and errors of visibility, beside Embree's stream call on the same rays.", "overcast-bench-visibility");
  Settings settings;
  app.add_option("MESH", settings.meshes, "meshes (.obj .ply .stl .off)")->required();
  app.add_option("--rays", settings.rays, "rays per vertex")->check(CLI::Range(16, 4096))->capture_default_str();
  app.add_option("--runs", settings.runs, "runs, interleaved; medians are printed")->check(CLI::Range(1, 99))->capture_default_str();
  app.add_option("--truth-rays", settings.truthRays, "rays of the reference")->check(CLI::Range(4096, 1 << 20))->capture_default_str();
  app.add_option("--truth-points", settings.truthPoints, "vertices it is taken at")->check(CLI::Range(1, 1000000))->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  bool good = true;
  for (const std::string& mesh : settings.meshes) good = report(mesh, settings) && good;
  return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
