#include "bake/outside.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/distance.h"
#include "bake/edges.h"
#include "bake/sign.h"

namespace overcast {
namespace {

constexpr double kUndecided = 0.01;     ///< share of samples above which the orientation is looked at
constexpr double kLess = 0.5;           ///< share of the undecided samples that may be left for a turn to be kept
constexpr int kJudgingResolution = 32;  ///< of the grid on which that is counted
constexpr int kPadding = 2;             ///< voxels, so that the flood can go all around
constexpr double kWall = 0.87;          ///< voxels: nearer samples stop the flood; half the diagonal of a voxel
constexpr double kClearVote = 0.1;      ///< share of a piece's area

Grid gridAbout(const Mesh& mesh, int resolution) {
  const Box box = bounds(mesh);
  const glm::dvec3 size = extent(box);
  Grid grid;
  grid.voxelSize = std::max({size.x, size.y, size.z}) / (resolution - 1 - 2 * kPadding);
  grid.size = glm::ivec3(glm::ceil(size / grid.voxelSize - 1e-9)) + 1 + 2 * kPadding;
  grid.origin = centre(box) - 0.5 * grid.voxelSize * glm::dvec3(grid.size - 1);
  return grid;
}

enum class Label : std::uint8_t { wall, enclosed, outside };

/// What a flood from the border of the grid makes of every sample.
struct Flood {
  Grid grid;
  std::vector<Label> labels;
  bool encloses = false;  ///< some sample is neither wall nor reached

  Label at(const glm::dvec3& point) const {
    const glm::ivec3 sample(glm::round((point - grid.origin) / grid.voxelSize));
    for (int axis = 0; axis < 3; ++axis)
      if (sample[axis] < 0 || sample[axis] >= grid.size[axis]) return Label::outside;
    return labels[(static_cast<std::size_t>(sample.z) * grid.size.y + sample.y) * grid.size.x + sample.x];
  }
};

Flood floodAbout(const Mesh& mesh, int resolution) {
  Flood flood{gridAbout(mesh, resolution), {}, false};
  const std::vector<float> distance = unsignedDistance(mesh, flood.grid);
  for (const float d : distance) flood.labels.push_back(d > kWall * flood.grid.voxelSize ? Label::enclosed : Label::wall);
  const std::int64_t nx = flood.grid.size.x, ny = flood.grid.size.y, nz = flood.grid.size.z;
  std::vector<std::int64_t> stack;
  const auto reach = [&](bool within, std::int64_t sample) {
    if (!within || flood.labels[static_cast<std::size_t>(sample)] != Label::enclosed) return;
    flood.labels[static_cast<std::size_t>(sample)] = Label::outside;
    stack.push_back(sample);
  };
  reach(true, 0);  // the padding joins all of the border
  while (!stack.empty()) {
    const std::int64_t at = stack.back();
    stack.pop_back();
    const std::int64_t x = at % nx, y = at / nx % ny, z = at / (nx * ny);
    reach(x > 0, at - 1);
    reach(x + 1 < nx, at + 1);
    reach(y > 0, at - nx);
    reach(y + 1 < ny, at + nx);
    reach(z > 0, at - nx * ny);
    reach(z + 1 < nz, at + nx * ny);
  }
  flood.encloses = std::find(flood.labels.begin(), flood.labels.end(), Label::enclosed) != flood.labels.end();
  return flood;
}

/// Which side of a triangle is outside: +1 that of its normal, -1 the other, 0 when the flood does not say.
int facing(const Flood& flood, const glm::dvec3& middle, const glm::dvec3& normal) {
  for (const double steps : {1.0, 1.5, 2.0, 3.0}) {
    const glm::dvec3 step = steps * flood.grid.voxelSize * normal;
    const Label front = flood.at(middle + step), back = flood.at(middle - step);
    if (front == Label::wall || back == Label::wall) continue;
    return front == back ? 0 : front == Label::outside ? 1 : -1;
  }
  return 0;
}

/// Turns the pieces that face inward; returns how many triangles that were.
std::uint64_t turnOutward(Mesh& mesh, const Flood& flood) {
  TriangleSets pieces = consistentPieces(mesh.triangles);
  std::vector<double> votes(mesh.triangles.size(), 0.0), areas(mesh.triangles.size(), 0.0);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const glm::dvec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double area = glm::length(normal);
    if (!(area > 0.0)) continue;
    areas[pieces.find(i)] += area;
    votes[pieces.find(i)] += area * facing(flood, (a + b + c) / 3.0, normal / area);
  }
  std::uint64_t turned = 0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (votes[pieces.find(i)] > -kClearVote * areas[pieces.find(i)] || areas[pieces.find(i)] == 0.0) continue;
    std::swap(mesh.triangles[i].y, mesh.triangles[i].z);
    ++turned;
  }
  return turned;
}

/// Share of samples whose side the winding number leaves open, or decides otherwise than the flood.
double undecided(const SignField& sign, const Grid& grid, const Flood& flood) {
  std::uint64_t against = 0;
  std::size_t i = 0;
  for (int z = 0; z < grid.size.z; ++z)
    for (int y = 0; y < grid.size.y; ++y)
      for (int x = 0; x < grid.size.x; ++x, ++i) {
        const Label label = flood.at(grid.origin + grid.voxelSize * glm::dvec3(x, y, z));
        against += label == (sign.inside[i] != 0 ? Label::outside : Label::enclosed) ? 1 : 0;
      }
  return sign.ambiguous + static_cast<double>(against) / static_cast<double>(i);
}

}  // namespace

std::uint64_t orientByOutside(RepairedMesh& repaired) {
  if (repaired.found.closed || extent(bounds(repaired.mesh)) == glm::dvec3(0.0)) return 0;
  const Grid judging = gridAbout(repaired.mesh, kJudgingResolution);
  const SignField given = signField(repaired.mesh, judging);
  // The winding number of a fine soup of any orientation cancels: it is small everywhere and looks decided.
  const bool soup = 2 * repaired.found.boundaryEdges > repaired.mesh.triangles.size();
  if (given.ambiguous <= kUndecided && !soup) return 0;
  for (const int resolution : {64, 32, 16}) {
    const Flood flood = floodAbout(repaired.mesh, resolution);
    if (!flood.encloses) continue;
    const double before = undecided(given, judging, flood);
    Mesh turnedMesh = repaired.mesh;
    const std::uint64_t turned = before > kUndecided ? turnOutward(turnedMesh, flood) : 0;
    if (turned == 0 || undecided(signField(turnedMesh, judging), judging, flood) > kLess * before) continue;
    repaired.mesh.triangles = std::move(turnedMesh.triangles);
    repaired.found.turnedOutward = turned;
    countBoundary(repaired.mesh, repaired.found);
    return turned;
  }
  return 0;
}

}  // namespace overcast
