// overcast-bench-distance [MESH]: our distance engine and its peers in one run, interleaved, medians over the runs.
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "bake/distance.h"
#include "formats/mesh.h"
#include "tests/bench/peers.h"
#include "tests/reference/distance.h"
#include "tests/reference/shapes.h"

namespace overcast::bench {
namespace {

constexpr double kBand = 3.0;     // voxels
constexpr double kPadding = 2.0;  // voxels around the mesh, as in bake/volume.h

struct Settings {
  std::string mesh;
  int resolution = 128;
  int runs = 5;
  int samples = 20000;
  int subdivisions = 0;
  bool withPeers = true;
  bool json = false;
};

/// One contestant: how it fills the grid and what came out.
struct Contestant {
  std::string name;
  int threads = 1;
  double band = 0.0;  ///< voxels; 0: the whole box
  std::function<std::vector<float>(DistanceCost*)> fill;
  std::vector<double> seconds = {};
  std::vector<double> cpuSeconds = {};  ///< of all threads: steadier than the clock on a machine that others use too
  DistanceCost cost = {};
  double worst = 0.0;      ///< error in voxels over the samples
  double worstNear = 0.0;  ///< of those within two voxels of the surface
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// A sphere of 81,920 triangles with bumps of several sizes.
Mesh bumpySphere() {
  Mesh mesh = reference::icosphere(1.0, 6);
  for (glm::dvec3& p : mesh.positions) {
    const double bumps = 0.12 * std::sin(5.0 * p.x) * std::cos(4.0 * p.y + 1.0) + 0.04 * std::sin(17.0 * p.z + 3.0 * p.x) +
                         0.01 * std::sin(41.0 * p.y) * std::sin(37.0 * p.x);
    p *= 1.0 + bumps;
  }
  return mesh;
}

/// Every triangle into four, new vertices in the middle of edges.
Mesh subdivided(const Mesh& mesh) {
  Mesh fine;
  fine.positions = mesh.positions;
  std::map<std::pair<unsigned, unsigned>, unsigned> middles;
  const auto middle = [&](unsigned a, unsigned b) {
    const auto [at, isNew] = middles.try_emplace(std::minmax(a, b), static_cast<unsigned>(fine.positions.size()));
    if (isNew) fine.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    return at->second;
  };
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::uvec3 m(middle(t.x, t.y), middle(t.y, t.z), middle(t.z, t.x));
    for (const glm::uvec3& part : {glm::uvec3(t.x, m.x, m.z), glm::uvec3(m.x, t.y, m.y), glm::uvec3(m.z, m.y, t.z), m})
      fine.triangles.push_back(part);
  }
  return fine;
}

Grid gridFor(const Mesh& mesh, int resolution) {
  glm::dvec3 low(std::numeric_limits<double>::max());
  glm::dvec3 high = -low;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      low = glm::min(low, mesh.positions[t[k]]);
      high = glm::max(high, mesh.positions[t[k]]);
    }
  }
  const glm::dvec3 size = high - low;
  Grid grid;
  grid.voxelSize = std::max({size.x, size.y, size.z}) / (resolution - 1 - 2.0 * kPadding);
  grid.origin = low - kPadding * grid.voxelSize;
  grid.size = glm::ivec3(glm::ceil(size / grid.voxelSize - 1e-9)) + 1 + 2 * static_cast<int>(kPadding);
  return grid;
}

std::vector<Contestant> contestants(const Mesh& mesh, const Grid& grid, bool withPeers) {
  std::vector<Contestant> all;
  const auto dense = [&](const char* label, int threads, Simd simd) {
    all.push_back({label, threads, 0.0, [&mesh, &grid, simd](DistanceCost* cost) { return unsignedDistance(mesh, grid, {}, simd, cost); }});
  };
  const auto band = [&](const char* label, int threads, Simd simd) {
    all.push_back(
        {label, threads, kBand, [&mesh, &grid, simd](DistanceCost* cost) { return narrowBand(mesh, grid, kBand, {}, simd, cost); }});
  };
  dense("ours", 1, Simd::automatic);
  dense("ours, AVX2", 1, Simd::avx2);
  dense("ours, portable", 1, Simd::portable);
  dense("ours", 4, Simd::automatic);
  band("ours, band", 1, Simd::automatic);
  band("ours, band", 4, Simd::automatic);
  if (!withPeers) return all;
  for (const int threads : {1, 4}) {
    all.push_back({"Embree, warm", threads, 0.0, [&](DistanceCost*) { return embreeDistance(mesh, grid); }});
    all.push_back({"OpenVDB band", threads, kBand, [&](DistanceCost*) { return openvdbBand(mesh, grid, kBand); }});
    all.push_back({"OpenVDB sweep", threads, 0.0, [&](DistanceCost*) { return openvdbSweep(mesh, grid); }});
  }
  return all;
}

/// Sampled voxels and their true distances.
struct Truth {
  std::vector<std::size_t> voxels;
  std::vector<double> distances;
};

Truth truthFor(const Mesh& mesh, const Grid& grid, int samples) {
  Truth truth;
  std::mt19937_64 random(1);
  std::vector<glm::dvec3> points;
  const auto nx = static_cast<std::size_t>(grid.size.x);
  const auto ny = static_cast<std::size_t>(grid.size.y);
  for (int i = 0; i < samples; ++i) {
    const std::size_t voxel = random() % sampleCount(grid);
    truth.voxels.push_back(voxel);
    points.push_back(grid.origin + grid.voxelSize * glm::dvec3(voxel % nx, voxel / nx % ny, voxel / (nx * ny)));
  }
  truth.distances = reference::distance(mesh, points);
  return truth;
}

void measureError(Contestant& contestant, const std::vector<float>& distance, const Truth& truth, double voxelSize) {
  for (std::size_t i = 0; i < truth.voxels.size(); ++i) {
    const double exact = truth.distances[i] / voxelSize;
    if (contestant.band > 0.0 && exact > contestant.band) continue;
    const double error = std::abs(static_cast<double>(distance[truth.voxels[i]]) / voxelSize - exact);
    contestant.worst = std::max(contestant.worst, error);
    if (exact < 2.0) contestant.worstNear = std::max(contestant.worstNear, error);
  }
}

void runAll(std::vector<Contestant>& all, const Truth& truth, double voxelSize, int runs) {
  for (int run = 0; run < runs; ++run) {
    for (Contestant& contestant : all) {
      tbb::task_arena arena(contestant.threads);
      DistanceCost cost;
      const std::clock_t cpuStart = std::clock();
      const auto start = std::chrono::steady_clock::now();
      const std::vector<float> distance = arena.execute([&] { return contestant.fill(&cost); });
      contestant.seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
      contestant.cpuSeconds.push_back(static_cast<double>(std::clock() - cpuStart) / CLOCKS_PER_SEC);
      contestant.cost = cost;
      if (run == 0) measureError(contestant, distance, truth, voxelSize);
    }
  }
}

/// Resident bytes in use now, and the most since the counter was last reset (Linux); zero where that is not known.
double residentMegabytes(const char* field) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind(field, 0) == 0) return std::strtod(line.c_str() + line.find(':') + 1, nullptr) / 1024.0;
  }
  return 0.0;
}

/// How much one dense call adds to the memory in use at its peak, in megabytes.
double peakMegabytes(const Mesh& mesh, const Grid& grid) {
  std::ofstream("/proc/self/clear_refs") << "5";  // resets VmHWM
  const double before = residentMegabytes("VmRSS");
  unsignedDistance(mesh, grid);
  return residentMegabytes("VmHWM") - before;
}

nlohmann::ordered_json report(const Contestant& c, std::uint64_t voxels) {
  const double seconds = median(c.seconds);
  nlohmann::ordered_json row{{"name", c.name},
                             {"threads", c.threads},
                             {"bandVoxels", c.band},
                             {"seconds", seconds},
                             {"fastest", *std::min_element(c.seconds.begin(), c.seconds.end())},
                             {"slowest", *std::max_element(c.seconds.begin(), c.seconds.end())},
                             {"cpuSeconds", median(c.cpuSeconds)},
                             {"nsPerVoxel", 1e9 * seconds / static_cast<double>(voxels)},
                             {"worstErrorVoxels", c.worst},
                             {"worstErrorWithinTwoVoxels", c.worstNear}};
  if (c.cost.packets > 0) {
    const auto packets = static_cast<double>(c.cost.packets);
    row["packets"] = c.cost.packets;
    row["nodesPerPacket"] = static_cast<double>(c.cost.nodes) / packets;
    row["leavesPerPacket"] = static_cast<double>(c.cost.leaves) / packets;
    row["vertexTestsPerPacket"] = static_cast<double>(c.cost.vertices) / packets;
    row["triangleTestsPerPacket"] = static_cast<double>(c.cost.triangles) / packets;
  }
  return row;
}

void printTable(const nlohmann::ordered_json& result) {
  fmt::print("{} triangles, grid {} x {} x {}; seconds are medians of {} interleaved runs; errors in voxels at {} voxels\n",
             result["triangles"].get<std::uint64_t>(), result["grid"][0].get<int>(), result["grid"][1].get<int>(),
             result["grid"][2].get<int>(), result["runs"].get<int>(), result["samples"].get<int>());
  fmt::print("a dense call adds {:.0f} MB at its peak, {:.2f} times its output\n\n", result["peakMegabytes"].get<double>(),
             result["peakOverOutput"].get<double>());
  fmt::print("{:<16}{:>8}{:>10}{:>20}{:>10}{:>10}{:>12}{:>12}{:>12}\n", "", "threads", "seconds", "fastest..slowest", "cpu s", "ns/voxel",
             "error", "error < 2", "tri/packet");
  for (const auto& row : result["rows"]) {
    fmt::print("{:<16}{:>8}{:>10.4f}{:>20}{:>10.4f}{:>10.1f}{:>12.1e}{:>12.1e}{:>12}\n", row["name"].get<std::string>(),
               row["threads"].get<int>(), row["seconds"].get<double>(),
               fmt::format("{:.4f}..{:.4f}", row["fastest"].get<double>(), row["slowest"].get<double>()), row["cpuSeconds"].get<double>(),
               row["nsPerVoxel"].get<double>(), row["worstErrorVoxels"].get<double>(), row["worstErrorWithinTwoVoxels"].get<double>(),
               row.contains("packets") ? fmt::format("{:.1f}", row["triangleTestsPerPacket"].get<double>()) : "");
  }
}

int run(const Settings& settings) {
  Mesh mesh;
  if (settings.mesh.empty()) {
    mesh = bumpySphere();
  } else {
    Result<MeshFile> file = readMesh(settings.mesh);
    if (!file) {
      fmt::print(stderr, "{}\n", message(file.error()));
      return 1;
    }
    mesh = std::move(file.value().mesh);
  }
  for (int i = 0; i < settings.subdivisions; ++i) mesh = subdivided(mesh);
  const Grid grid = gridFor(mesh, settings.resolution);
  const double peak = peakMegabytes(mesh, grid);
  const Truth truth = truthFor(mesh, grid, settings.samples);
  std::vector<Contestant> all = contestants(mesh, grid, settings.withPeers);
  runAll(all, truth, grid.voxelSize, settings.runs);
  nlohmann::ordered_json result{{"triangles", mesh.triangles.size()},
                                {"grid", {grid.size.x, grid.size.y, grid.size.z}},
                                {"runs", settings.runs},
                                {"samples", settings.samples},
                                {"peakMegabytes", peak},
                                {"peakOverOutput", peak * 1048576.0 / static_cast<double>(sizeof(float) * sampleCount(grid))},
                                {"rows", nlohmann::ordered_json::array()}};
  for (const Contestant& contestant : all) result["rows"].push_back(report(contestant, sampleCount(grid)));
  if (settings.json) {
    fmt::print("{}\n", result.dump(2));
  } else {
    printTable(result);
  }
  return 0;
}

}  // namespace
}  // namespace overcast::bench

int main(int argc, char** argv) {
  overcast::bench::Settings settings;
  CLI::App app("Times exact distance volumes against Embree and OpenVDB in one run");
  app.add_option("mesh", settings.mesh, "Mesh file; without one, a bumpy sphere of 81,920 triangles");
  app.add_option("--resolution", settings.resolution, "Voxels along the longest side")->check(CLI::Range(8, 1024))->capture_default_str();
  app.add_option("--runs", settings.runs, "Runs of each contestant")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--samples", settings.samples, "Voxels whose error is measured by brute force")
      ->check(CLI::Range(0, 10000000))
      ->capture_default_str();
  app.add_option("--subdivide", settings.subdivisions, "Times every triangle is cut into four")
      ->check(CLI::Range(0, 6))
      ->capture_default_str();
  app.add_flag("!--no-peers", settings.withPeers, "Ours alone");
  app.add_flag("--json", settings.json, "JSON on stdout");
  CLI11_PARSE(app, argc, argv);
  return overcast::bench::run(settings);
}
