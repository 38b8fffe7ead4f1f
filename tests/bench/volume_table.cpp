// overcast-bench-volumes: bakes every mesh of a folder and prints what it cost and how far off it is, against brute force over every
// triangle of the mesh as read, in double (tests/reference, which shares no code with bake).
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <unistd.h>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bake/volume.h"
#include "formats/mesh.h"
#include "formats/volume.h"
#include "tests/bench/mesh_files.h"
#include "tests/reference/distance.h"
#include "tests/reference/shapes.h"
#include "tests/reference/winding_number.h"

namespace overcast {
namespace {

constexpr int kRuns = 3;
constexpr double kNearSurface = 0.1;  ///< voxels; nearer points count in no sign error

struct Options {
  std::filesystem::path folder;
  int resolution = 64;
  std::size_t points = 20000;
  std::uint64_t seed = 1;
  std::size_t threads = static_cast<std::size_t>(tbb::info::default_concurrency());
  bool json = false;
};

/// Differences from the truth, in voxels.
struct Deviation {
  double max = 0.0;
  double squares = 0.0;
  std::uint64_t points = 0;
  std::uint64_t signErrors = 0;

  double rms() const { return points == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(points)); }
  void operator+=(const Deviation& other) {
    max = std::max(max, other.max);
    squares += other.squares;
    points += other.points;
    signErrors += other.signErrors;
  }
};

struct Row {
  std::string mesh;
  std::string reason;  ///< why there is nothing else; empty when all went well
  std::uint64_t faces = 0;
  std::array<double, kRuns> seconds{};  ///< sorted
  std::uint64_t bytes = 0;
  std::uint64_t samples = 0;
  double peakMegabytes = 0.0;
  std::string signMethod;
  bool closed = false;
  Deviation atSamples;
  Deviation between;
};

/// The largest resident size of this process since forgetPeak, 0 where the system does not tell.
double peakMegabytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024.0;
  return 0.0;
}

void forgetPeak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

Deviation deviation(const Mesh& mesh, const std::vector<glm::dvec3>& points, const std::vector<double>& phi, double voxelSize) {
  const auto distance = reference::distance(mesh, points);
  const auto winding = reference::windingNumber(mesh, points);
  Deviation result;
  result.points = points.size();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool inside = std::abs(winding[i]) > 0.5;
    const double error = std::abs(phi[i] - (inside ? -distance[i] : distance[i])) / voxelSize;
    result.max = std::max(result.max, error);
    result.squares += error * error;
    if (distance[i] > kNearSurface * voxelSize && (phi[i] < 0.0) != inside) ++result.signErrors;
  }
  return result;
}

Deviation deviationAtSamples(const Mesh& mesh, const Volume& volume, const Options& options) {
  std::mt19937_64 engine(options.seed);
  const auto below = [&](int side) { return static_cast<int>(engine() % static_cast<std::uint64_t>(side)); };
  std::vector<glm::dvec3> points;
  std::vector<double> phi;
  for (std::size_t n = 0; n < options.points; ++n) {
    const int i = below(volume.size.x);
    const int j = below(volume.size.y);
    const int k = below(volume.size.z);
    points.push_back(volume.origin + volume.voxelSize * glm::dvec3(i, j, k));
    phi.push_back(volume.distance[sampleIndex(volume, i, j, k)]);
  }
  return deviation(mesh, points, phi, volume.voxelSize);
}

Deviation deviationBetween(const Mesh& mesh, const Volume& volume, const Options& options) {
  const auto points = reference::randomPoints(bounds(volume), options.points, options.seed);
  std::vector<double> phi;
  for (const glm::dvec3& point : points) phi.push_back(sampleVolume(volume, point));
  return deviation(mesh, points, phi, volume.voxelSize);
}

/// Bakes kRuns times and keeps the last; the measuring of errors that a bake may do itself is left out of the time.
Result<BakedVolume> timedBake(const Mesh& mesh, const Options& options, Row& row) {
  VolumeSettings settings;
  settings.resolution = options.resolution;
  settings.errorSamples = 0;
  forgetPeak();
  std::optional<BakedVolume> baked;
  for (double& seconds : row.seconds) {
    const auto start = std::chrono::steady_clock::now();
    auto result = bakeVolume(mesh, settings);
    seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!result) return result.error();
    baked = std::move(result).value();
  }
  row.peakMegabytes = peakMegabytes();
  std::sort(row.seconds.begin(), row.seconds.end());
  return std::move(*baked);
}

Result<Row> measured(const std::filesystem::path& path, const std::filesystem::path& stored, const Options& options) {
  Row row;
  const auto file = readMesh(path);
  if (!file) return file.error();
  const Mesh& mesh = file.value().mesh;
  row.faces = mesh.triangles.size();
  const auto baked = timedBake(mesh, options, row);
  if (!baked) return baked.error();
  const auto bytes = writeVolume(stored, baked.value().volume);
  if (!bytes) return bytes.error();
  const auto volume = readVolume(stored);
  if (!volume) return volume.error();
  row.bytes = bytes.value();
  row.samples = volume.value().distance.size();
  row.signMethod = volume.value().signMethod;
  row.closed = baked.value().found.closed;
  row.atSamples = deviationAtSamples(mesh, volume.value(), options);
  row.between = deviationBetween(mesh, volume.value(), options);
  return row;
}

Row rowOf(const std::filesystem::path& path, const std::filesystem::path& stored, const Options& options) {
  auto result = measured(path, stored, options);
  Row row;
  if (result) {
    row = std::move(result).value();
  } else {
    Error error = result.error();
    error.file.clear();  // the row names it already
    row.reason = message(error);
  }
  row.mesh = path.filename().string();
  return row;
}

Row total(const std::vector<Row>& rows) {
  Row sum;
  for (const Row& row : rows) {
    if (!row.reason.empty()) continue;
    sum.faces += row.faces;
    sum.bytes += row.bytes;
    sum.samples += row.samples;
    for (std::size_t run = 0; run < kRuns; ++run) sum.seconds[run] += row.seconds[run];
    sum.peakMegabytes = std::max(sum.peakMegabytes, row.peakMegabytes);
    sum.atSamples += row.atSamples;
    sum.between += row.between;
  }
  return sum;
}

/// "0.00041": two significant digits without an exponent.
std::string figure(double value) {
  if (value == 0.0) return "0";
  const int digits = std::clamp(1 - static_cast<int>(std::floor(std::log10(value))), 0, 9);
  return fmt::format("{:.{}f}", value, digits);
}

std::string cells(const Deviation& deviation) {
  return fmt::format("{} | {} | {}", figure(deviation.max), figure(deviation.rms()), deviation.signErrors);
}

std::string markdown(const Row& row) {
  if (!row.reason.empty()) return fmt::format("| {} | | | | | | | | | | | {} |", row.mesh, row.reason);
  const auto& s = row.seconds;
  return fmt::format("| {} | {} | {:.3f} ({:.3f} to {:.3f}) | {} | {:.0f} | {} | {} | {} |", row.mesh, row.faces, s[kRuns / 2], s.front(),
                     s.back(), row.bytes, row.peakMegabytes, cells(row.atSamples), cells(row.between),
                     row.signMethod + (row.signMethod.empty() || row.closed ? "" : ", open"));
}

void printHeader() {
  fmt::print(
      "| mesh | faces | seconds | bytes | peak MB | at samples: max | RMS | sign errors | between samples: max | RMS | sign errors | sign "
      "|\n"
      "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---|\n");
}

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

void printNotes(const Options& options) {
  fmt::print(
      "\n* faces: triangles as read. Grids have {} samples along the longest side, cubic voxels, two of them padding on every side.\n"
      "* seconds: median (fastest to slowest) of {} bakes, from mesh in memory to volume in memory; the last row adds them up.\n"
      "* bytes: of the .vdb on disk. peak MB: largest resident size of the whole process while baking.\n"
      "* at samples: the stored values of {} random samples (seed {}) against the exact distance there. between samples: trilinear\n"
      "  interpolation at {} random points of the box. Both in voxels, against every triangle of the mesh as read, in double.\n"
      "* sign errors: points further than {} voxel from the surface with the wrong sign; inside is where the winding number exceeds 1/2.\n"
      "  Between samples an exact grid has them too: its interpolant rounds edges and loses parts thinner than a voxel.\n"
      "* {}, {} threads.\n",
      options.resolution, kRuns, options.points, options.seed, options.points, kNearSurface, processor(), options.threads);
}

nlohmann::json json(const Deviation& deviation) {
  return {{"max", deviation.max}, {"rms", deviation.rms()}, {"sign_errors", deviation.signErrors}, {"points", deviation.points}};
}

nlohmann::json json(const Row& row) {
  if (!row.reason.empty()) return {{"mesh", row.mesh}, {"error", row.reason}};
  return {{"mesh", row.mesh},
          {"faces", row.faces},
          {"seconds", row.seconds},
          {"bytes", row.bytes},
          {"samples", row.samples},
          {"peak_megabytes", row.peakMegabytes},
          {"sign_method", row.signMethod},
          {"closed", row.closed},
          {"at_samples_voxels", json(row.atSamples)},
          {"between_samples_voxels", json(row.between)}};
}

int run(const Options& options) {
  const auto files = bench::meshFiles(options.folder);
  if (files.empty()) {
    fmt::print(stderr, "{}: holds no .obj, .ply, .stl or .off file\n", options.folder.string());
    return 1;
  }
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, options.threads);
  const auto stored = std::filesystem::temp_directory_path() / fmt::format("overcast-bench-{}.vdb", ::getpid());
  std::vector<Row> rows;
  if (!options.json) printHeader();
  for (const auto& file : files) {
    rows.push_back(rowOf(file, stored, options));
    if (options.json) continue;
    fmt::print("{}\n", markdown(rows.back()));
    std::fflush(stdout);
  }
  std::error_code ignored;
  std::filesystem::remove(stored, ignored);
  Row sum = total(rows);
  sum.mesh = fmt::format("all {}", std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.reason.empty(); }));
  if (options.json) {
    nlohmann::json result{{"resolution", options.resolution}, {"points", options.points}, {"seed", options.seed},
                          {"threads", options.threads},       {"processor", processor()}, {"total", json(sum)},
                          {"meshes", nlohmann::json::array()}};
    for (const Row& row : rows) result["meshes"].push_back(json(row));
    fmt::print("{}\n", result.dump(2));
    return 0;
  }
  fmt::print("{}\n", markdown(sum));
  printNotes(options);
  return 0;
}

}  // namespace
}  // namespace overcast

int main(int argc, char** argv) {
  overcast::Options options;
  CLI::App app{
      "Bakes every mesh of a folder as a volume and prints cost and error as a Markdown table. Exit codes: 0 done (files that cannot "
      "be baked are rows with the reason), 1 no mesh file in the folder, others: wrong arguments."};
  app.add_option("folder", options.folder, "folder with .obj, .ply, .stl and .off files")->required()->check(CLI::ExistingDirectory);
  app.add_option("--resolution", options.resolution, "samples along the longest side")
      ->capture_default_str()
      ->check(CLI::Range(overcast::kMinResolution, overcast::kMaxResolution));
  app.add_option("--points", options.points, "points of each of the two comparisons")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000000));
  app.add_option("--seed", options.seed, "seed of their places")->capture_default_str();
  app.add_option("--threads", options.threads, "threads")->capture_default_str()->check(CLI::Range(1, 1024));
  app.add_flag("--json", options.json, "JSON instead of Markdown, at the end");
  CLI11_PARSE(app, argc, argv);
  return overcast::run(options);
}
