// Table of searched centres: the margin of the kernel's centre beside the best one known, for every mesh of a list.
//   overcast-bench-star meshes/STAR.tsv
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "bake/kernel.h"
#include "bake/radius.h"
#include "bake/repair.h"

namespace {

using namespace overcast;
namespace fs = std::filesystem;

constexpr double kRequired = 0.9;  ///< of the listed margin
constexpr int kRuns = 5;

std::vector<std::string> columns(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream in(line);
  for (std::string part; std::getline(in, part, '\t');) all.push_back(part);
  return all;
}

/// Median milliseconds of the search.
double timeOf(const Mesh& mesh) {
  std::vector<double> times;
  for (int run = 0; run < kRuns; ++run) {
    const auto start = std::chrono::steady_clock::now();
    const Kernel kernel = findKernel(mesh);
    times.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count() + 0.0 * kernel.margin);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

/// One row; true when the margin reaches what is required.
bool row(const fs::path& folder, const std::string& path, double listed) {
  const auto file = readMesh(folder / path);
  if (!file) {
    fmt::print("{:<50} {}\n", path, message(file.error()));
    return false;
  }
  RepairedMesh repaired = repair(file.value().mesh);
  if (repaired.found.insideOut)
    for (glm::uvec3& t : repaired.mesh.triangles) std::swap(t.y, t.z);
  const Kernel kernel = findKernel(repaired.mesh);
  const double margin = kernel.margin / diagonal(bounds(repaired.mesh));
  const double check = starMargin(repaired.mesh, kernel.centre) / diagonal(bounds(repaired.mesh));
  const bool enough = std::min(margin, check) >= kRequired * listed && margin > 0.0;
  fmt::print("{:<50} {:>8} {:>9.5f} {:>9.5f} {:>7.1f} % {:>6} {:>9.3f}  {}\n", path, repaired.mesh.triangles.size(), margin, listed,
             100.0 * margin / listed, kernel.steps, timeOf(repaired.mesh), enough ? "ok" : "TOO SMALL");
  return enough;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Margins of searched centres beside the best known ones"};
  std::string list;
  app.add_option("list", list, "tab-separated: path beside the list, ..., star_shaped, ..., best_margin_over_diag")->required();
  CLI11_PARSE(app, argc, argv);
  std::ifstream in(list);
  std::string line;
  if (!std::getline(in, line)) {
    fmt::print(stderr, "{}: cannot be read\n", list);
    return 2;
  }
  std::map<std::string, std::size_t> place;
  for (const std::string& name : columns(line)) place.emplace(name, place.size());
  for (const char* name : {"path", "star_shaped", "best_margin_over_diag"})
    if (!place.contains(name)) {
      fmt::print(stderr, "{}: has no column {}\n", list, name);
      return 2;
    }
  fmt::print("{:<50} {:>8} {:>9} {:>9} {:>9} {:>6} {:>9}\n", "mesh", "faces", "margin", "listed", "share", "steps", "ms");
  int rows = 0, good = 0;
  while (std::getline(in, line)) {
    const std::vector<std::string> parts = columns(line);
    if (parts.size() < place.size()) continue;
    ++rows;
    good += row(fs::path(list).parent_path(), parts[place["path"]], std::stod(parts[place["best_margin_over_diag"]])) ? 1 : 0;
  }
  fmt::print("{} of {} reach {:.0f} % of the listed margin (margins over the diagonal; medians of {} runs)\n", good, rows,
             100.0 * kRequired, kRuns);
  return good == rows ? 0 : 1;
}
