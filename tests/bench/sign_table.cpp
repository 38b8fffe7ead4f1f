// overcast-bench-sign: the sign of hard meshes. First a table of generated damage with ours as a row beside other methods, then, for every
// mesh of the folders given, the agreement with a brute-force winding number in double (tests/reference, which shares no code with bake).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "bake/prepare.h"
#include "bake/sign.h"
#include "bake/volume.h"
#include "formats/mesh.h"
#include "tests/bake/test_meshes.h"
#include "tests/bench/damage.h"
#include "tests/bench/mesh_files.h"
#include "tests/bench/peers.h"
#include "tests/bench/sign_methods.h"
#include "tests/reference/distance.h"
#include "tests/reference/shapes.h"
#include "tests/reference/winding_number.h"

namespace overcast::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kDecided = 0.1;     ///< the winding number is this near to an integer where it decides
constexpr double kEven = 0.01;       ///< percent: so much may differ without being worse; nobody knows what filled a hole
constexpr double kOnSurface = 1e-5;  ///< voxels: nearer ones lie on the surface

struct Options {
  std::vector<fs::path> meshes;
  std::vector<fs::path> folders;
  std::vector<int> resolutions = {64, 48};
  std::size_t voxels = 20000;
  std::uint64_t seed = 1;
};

Result<Grid> gridAround(const Mesh& mesh, int resolution) {
  VolumeSettings settings;
  settings.resolution = resolution;
  return volumeGrid(bounds(mesh), settings);
}

Inside ourInside(const Mesh& mesh, const Grid& grid) {
  const PreparedMesh prepared = prepare(mesh);
  Grid centred = grid;
  centred.origin -= prepared.middle;
  return signField(prepared.repaired.mesh, centred).inside;
}

struct Method {
  const char* name;
  std::function<Inside(const Mesh&, const Grid&)> inside;
};

const std::vector<Method>& methods() {
  static const std::vector<Method> all = {{"flood fill (OpenVDB)", openvdbInside},         {"parity along rows", parityInside},
                                          {"pseudonormals", pseudonormalInside},           {"fast winding number", fastWindingInside},
                                          {"signed crossings, non-zero", crossingsInside}, {"ours", ourInside}};
  return all;
}

/// Groups of samples on one side of a surface: no triangle passes between two neighbours whose distances add up to more than their spacing.
/// Returns for every sample the first one of its group.
std::vector<std::uint32_t> sidesOf(const std::vector<float>& distance, const Grid& grid) {
  std::vector<std::uint32_t> first(distance.size(), 0xffffffffu), stack;
  const std::int64_t nx = grid.size.x, ny = grid.size.y, nz = grid.size.z;
  for (std::uint32_t start = 0; start < first.size(); ++start) {
    if (first[start] != 0xffffffffu) continue;
    first[start] = start;
    stack.push_back(start);
    while (!stack.empty()) {
      const std::uint32_t at = stack.back();
      stack.pop_back();
      const std::int64_t x = at % nx, y = at / nx % ny, z = at / (nx * ny);
      const auto visit = [&](bool within, std::int64_t step) {
        if (!within) return;
        const auto next = static_cast<std::uint32_t>(at + step);
        if (first[next] != 0xffffffffu || !(distance[at] + distance[next] > 1.001 * grid.voxelSize)) return;
        first[next] = start;
        stack.push_back(next);
      };
      visit(x > 0, -1), visit(x + 1 < nx, 1), visit(y > 0, -nx), visit(y + 1 < ny, nx), visit(z > 0, -nx * ny), visit(z + 1 < nz, nx * ny);
    }
  }
  return first;
}

/// Per sample 1 inside, 0 outside, 2 where either is right. Brute force decides one sample of every group.
std::vector<std::uint8_t> truthOf(const Damage& damage, const Grid& grid) {
  const std::vector<float> distance = unsignedDistance(damage.closed, grid);
  const std::vector<std::uint32_t> first = sidesOf(distance, grid);
  std::vector<glm::dvec3> points;
  std::vector<std::size_t> place(first.size());
  for (std::uint32_t i = 0; i < first.size(); ++i) {
    if (first[i] != i) continue;
    place[i] = points.size();
    points.push_back(test::samplePoint(grid, i));
  }
  const std::vector<double> winding = reference::windingNumber(damage.closed, points);
  std::vector<std::uint8_t> truth(first.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool inside = std::abs(winding[place[first[i]]]) > 0.5 && test::samplePoint(grid, i).x < damage.lid;
    truth[i] = distance[i] < damage.moved + 1e-5 * grid.voxelSize ? 2 : inside ? 1 : 0;
  }
  return truth;
}

/// Share of samples on the wrong side, in percent.
double wrongPercent(const Inside& inside, const std::vector<std::uint8_t>& truth) {
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) wrong += truth[i] != 2 && inside[i] != truth[i] ? 1 : 0;
  return 100.0 * static_cast<double>(wrong) / static_cast<double>(truth.size());
}

/// Prints the table of one mesh; true when ours is as good as the best in every column.
bool printTable(const Mesh& closed, const Options& options) {
  const int resolution = options.resolutions.front();
  const double voxel = gridAround(closed, resolution).value().voxelSize;
  const std::vector<Damage> all = damages(closed, voxel, options.seed);
  std::vector<std::vector<double>> wrong(methods().size());
  std::string header = "| method |", line = "|---|";
  for (const Damage& damage : all) {
    const Grid grid = gridAround(damage.closed, resolution).value();
    const std::vector<std::uint8_t> truth = truthOf(damage, grid);
    for (std::size_t m = 0; m < methods().size(); ++m) wrong[m].push_back(wrongPercent(methods()[m].inside(damage.mesh, grid), truth));
    header += fmt::format(" {} |", damage.name);
    line += "---:|";
  }
  fmt::print("\n{} ({} triangles), wrong voxels in percent at {}^3:\n\n{}\n{}\n", closed.name, closed.triangles.size(), resolution, header,
             line);
  for (std::size_t m = 0; m < methods().size(); ++m) {
    fmt::print("| {} |", methods()[m].name);
    for (const double percent : wrong[m]) fmt::print(" {:.3g} |", percent);
    fmt::print("\n");
  }
  std::string worse;
  for (std::size_t column = 0; column < all.size(); ++column)
    for (std::size_t m = 0; m + 1 < methods().size(); ++m)
      if (wrong[m][column] + kEven < wrong.back()[column])
        worse += fmt::format("{}{} by {}", worse.empty() ? "" : ", ", all[column].name, methods()[m].name);
  fmt::print("ours is {}\n", worse.empty() ? fmt::format("the best, or within {} %, in every column", kEven) : "beaten in: " + worse);
  std::fflush(stdout);
  return worse.empty();
}

/// How the signs of some voxels compare with a winding number.
struct Agreement {
  std::size_t decided = 0;
  std::size_t agreed = 0;

  bool whole() const { return agreed == decided; }
  double percent() const { return decided == 0 ? 100.0 : 100.0 * static_cast<double>(agreed) / static_cast<double>(decided); }
};

/// Voxels of a grid, and what signField says of them.
struct Samples {
  std::vector<glm::dvec3> points;
  std::vector<std::uint8_t> inside;
};

/// Brute force against `samples`. A voxel on the surface itself, where w is not defined, is not decided.
Agreement compare(const Samples& samples, const Mesh& mesh, double voxelSize) {
  const std::vector<double> winding = reference::windingNumber(mesh, samples.points);
  Agreement result;
  std::vector<glm::dvec3> doubtful;
  for (std::size_t i = 0; i < winding.size(); ++i) {
    if (std::abs(winding[i] - std::round(winding[i])) > kDecided) continue;
    const bool agrees = (std::round(winding[i]) != 0.0) == (samples.inside[i] != 0);
    if (!agrees) doubtful.push_back(samples.points[i]);
    result.agreed += agrees ? 1 : 0;
  }
  result.decided = result.agreed;
  for (const double distance : reference::distance(mesh, doubtful)) result.decided += distance > kOnSurface * voxelSize ? 1 : 0;
  return result;
}

std::string findings(const MeshDiagnosis& found) {
  std::string text = found.closed ? "closed" : "open";
  const auto add = [&](std::uint64_t count, const char* what) {
    if (count > 0) text += fmt::format(", {} {}", count, what);
  };
  if (found.insideOut) text += ", inside-out";
  add(found.components > 1 ? found.components : 0, "components");
  add(found.nonManifoldEdges, "non-manifold edges");
  add(found.duplicateTriangles, "duplicates out");
  add(found.degenerateTriangles, "degenerate");
  add(found.reorientedTriangles, "turned to agree");
  add(found.turnedOutward, "turned outward");
  return text;
}

/// One row of the agreement table; true when the mesh as repaired agrees everywhere.
bool agreementRow(const fs::path& path, int resolution, const Options& options) {
  const auto file = readMesh(path);
  if (!file) {
    fmt::print("| {} | | | | | | | cannot be read: {} |\n", path.filename().string(), file.error().reason);
    return true;
  }
  const Mesh& mesh = file.value().mesh;
  const PreparedMesh prepared = prepare(mesh);
  const Mesh& repaired = prepared.repaired.mesh;
  const Result<Grid> made = gridAround(repaired, resolution);
  if (!made) {
    fmt::print("| {} | | | | | | | cannot be baked: {} |\n", path.filename().string(), made.error().reason);
    return true;
  }
  const Grid& grid = made.value();
  const SignField field = signField(repaired, grid);
  std::mt19937_64 random(options.seed);
  Samples samples;
  for (std::size_t n = 0; n < options.voxels; ++n) {
    const std::uint64_t voxel = random() % field.inside.size();
    samples.points.push_back(test::samplePoint(grid, voxel));
    samples.inside.push_back(field.inside[voxel]);
  }
  const Agreement asRepaired = compare(samples, repaired, grid.voxelSize);
  const Agreement asRead = compare(samples, reference::moved(mesh, -prepared.middle), grid.voxelSize);
  fmt::print("| {} | {} | {} | {}^3 | {} of {} ({:.3f} %) | {} of {} ({:.3f} %) | {:.1f} % | {} |\n", path.filename().string(),
             mesh.triangles.size(), prepared.repaired.found.boundaryEdges, resolution, asRepaired.agreed, asRepaired.decided,
             asRepaired.percent(), asRead.agreed, asRead.decided, asRead.percent(), 100.0 * field.ambiguous,
             findings(prepared.repaired.found));
  std::fflush(stdout);
  return asRepaired.whole();
}

bool printAgreement(const Options& options) {
  std::vector<fs::path> files;
  for (const fs::path& folder : options.folders)
    for (const fs::path& file : meshFiles(folder)) files.push_back(file);
  if (files.empty()) return true;
  fmt::print(
      "\nSign of {} random voxels of each mesh against a brute-force winding number w in double, where w is within {} of an integer:\n\n"
      "| mesh | triangles | boundary edges | grid | agree, mesh as repaired | agree, mesh as read | ambiguous | found |\n"
      "|---|---:|---:|---:|---:|---:|---:|---|\n",
      options.voxels, kDecided);
  std::size_t rows = 0, whole = 0;
  for (const int resolution : options.resolutions)
    for (const fs::path& file : files) {
      ++rows;
      whole += agreementRow(file, resolution, options) ? 1 : 0;
    }
  fmt::print(
      "\n{} of {} rows agree at every decided voxel of the mesh as repaired. The mesh as read differs where the repair turned triangles "
      "or\n"
      "left duplicates out: there its own winding number says what nobody meant. ambiguous: share of all voxels with 0.2 < |w| < 0.8.\n",
      whole, rows);
  return whole == rows;
}

int run(const Options& options) {
  bool good = true;
  std::vector<Mesh> closed;
  for (const fs::path& path : options.meshes) {
    auto file = readMesh(path);
    if (!file) {
      fmt::print(stderr, "{}\n", message(file.error()));
      return 2;
    }
    closed.push_back(repair(file.value().mesh).mesh);
    closed.back().name = path.filename().string();
  }
  if (closed.empty()) closed.push_back(pebble());
  for (const Mesh& mesh : closed) good = printTable(mesh, options) && good;
  good = printAgreement(options) && good;
  return good ? 0 : 1;
}

}  // namespace
}  // namespace overcast::bench

int main(int argc, char** argv) {
  overcast::bench::Options options;
  CLI::App app{
      "The sign of hard meshes: wrong voxels of several methods on generated damage, then agreement with brute force. Exit codes: 0 ours "
      "is "
      "the best in every column and agrees everywhere, 1 it does not, 2 a mesh cannot be read."};
  app.add_option("meshes", options.meshes, "closed meshes to damage [a pebble of the program's own]");
  app.add_option("--agreement", options.folders, "folders of meshes to compare with brute force")->check(CLI::ExistingDirectory);
  app.add_option("--resolution", options.resolutions, "samples along the longest side; the table takes the first")
      ->check(CLI::Range(16, 256))
      ->capture_default_str();
  app.add_option("--voxels", options.voxels, "voxels of each mesh")->check(CLI::Range(1, 10000000))->capture_default_str();
  app.add_option("--seed", options.seed, "seed of damage and voxels")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return overcast::bench::run(options);
}
