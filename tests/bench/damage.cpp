#include "tests/bench/damage.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "tests/reference/shapes.h"

namespace overcast::bench {
namespace {

using reference::insideOut;
using reference::joined;
using reference::moved;
using reference::randomPoints;
using reference::unwelded;
using reference::withFlips;
using reference::withHoles;

constexpr int kHoles = 40;
constexpr double kHoleRadius = 1.25;  // all lengths in voxels
constexpr double kCapHeight = 0.1;    // share of the extent along x
constexpr int kParts = 44;
constexpr double kPartOffset = 0.02;
constexpr double kCopyOffset = 9.0;
constexpr double kSheetThickness = 0.3;
constexpr double kJitter = 0.2;
constexpr double kLostTriangles = 0.1;

glm::dvec3 middleOf(const Mesh& mesh, const glm::uvec3& t) {
  return (mesh.positions[t.x] + mesh.positions[t.y] + mesh.positions[t.z]) / 3.0;
}

/// `count` centroids of triangles.
std::vector<glm::dvec3> places(const Mesh& mesh, int count, std::uint64_t seed) {
  std::vector<glm::dvec3> chosen;
  const Box unit{glm::dvec3(0.0), glm::dvec3(1.0)};
  for (const glm::dvec3& u : randomPoints(unit, static_cast<std::size_t>(count), seed))
    chosen.push_back(middleOf(mesh, mesh.triangles[static_cast<std::size_t>(u.x * static_cast<double>(mesh.triangles.size()))]));
  return chosen;
}

std::size_t nearestOf(const std::vector<glm::dvec3>& centres, const glm::dvec3& point) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < centres.size(); ++i)
    if (glm::distance(centres[i], point) < glm::distance(centres[best], point)) best = i;
  return best;
}

Mesh withRoundHoles(const Mesh& mesh, double radius, std::uint64_t seed) {
  const std::vector<glm::dvec3> centres = places(mesh, kHoles, seed);
  Mesh result = mesh;
  std::erase_if(result.triangles, [&](const glm::uvec3& t) {
    const glm::dvec3 middle = middleOf(mesh, t);
    return glm::distance(middle, centres[nearestOf(centres, middle)]) < radius;
  });
  return result;
}

/// What lies below the plane x = height. Points on an edge come out the same for both of its triangles, bit for bit.
Mesh cutOff(const Mesh& mesh, double height) {
  Mesh result;
  const auto crossing = [&](std::uint32_t a, std::uint32_t b) {
    const glm::dvec3 low = mesh.positions[std::min(a, b)], high = mesh.positions[std::max(a, b)];
    glm::dvec3 p = low + (height - low.x) / (high.x - low.x) * (high - low);
    p.x = height;
    return p;
  };
  for (const glm::uvec3& t : mesh.triangles) {
    std::vector<glm::dvec3> polygon;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      const bool aBelow = mesh.positions[a].x < height, bBelow = mesh.positions[b].x < height;
      if (aBelow) polygon.push_back(mesh.positions[a]);
      if (aBelow != bBelow) polygon.push_back(crossing(a, b));
    }
    const auto first = static_cast<std::uint32_t>(result.positions.size());
    result.positions.insert(result.positions.end(), polygon.begin(), polygon.end());
    for (std::uint32_t i = 2; i < polygon.size(); ++i) result.triangles.emplace_back(first, first + i - 1, first + i);
  }
  return result;
}

/// Every group of triangles with vertices of its own, moved by `offset(group)`.
Mesh takenApart(const Mesh& mesh, const std::function<std::size_t(std::size_t)>& groupOf,
                const std::function<glm::dvec3(std::size_t)>& offset) {
  Mesh result = unwelded(mesh);
  for (std::size_t t = 0; t < result.triangles.size(); ++t)
    for (int corner = 0; corner < 3; ++corner) result.positions[result.triangles[t][corner]] += offset(groupOf(t));
  return result;
}

Mesh inParts(const Mesh& mesh, double offset, std::uint64_t seed) {
  const std::vector<glm::dvec3> centres = places(mesh, kParts, seed);
  const auto shifts = randomPoints({glm::dvec3(-offset), glm::dvec3(offset)}, centres.size(), seed + 1);
  return takenApart(
      mesh, [&](std::size_t t) { return nearestOf(centres, middleOf(mesh, mesh.triangles[t])); },
      [&](std::size_t part) { return shifts[part] / std::numbers::sqrt3; });
}

Mesh soupOf(const Mesh& mesh, double jitter, std::uint64_t seed) {
  const auto shifts = randomPoints({glm::dvec3(-jitter), glm::dvec3(jitter)}, mesh.triangles.size(), seed);
  const Mesh apart = takenApart(
      mesh, [](std::size_t t) { return t; }, [&](std::size_t t) { return shifts[t] / std::numbers::sqrt3; });
  return withHoles(apart, kLostTriangles, seed + 1);
}

/// Pushed back and forth along x so far that it passes through itself.
Mesh throughItself(const Mesh& mesh) {
  const Box box = bounds(mesh);
  const double length = extent(box).x;
  Mesh result = mesh;
  for (glm::dvec3& p : result.positions) {
    const double phase = 4.0 * std::numbers::pi * (p.x - box.min.x) / length;
    p.x += 0.15 * length * std::sin(phase) * (1.0 + 0.3 * std::sin(5.0 * p.y / length));
  }
  return result;
}

Mesh sheetLike(const Mesh& mesh, double thickness) {
  const Box box = bounds(mesh);
  Mesh sheet = reference::boxMesh(glm::dvec3(0.35, 0.3, 0.0) * extent(box) + glm::dvec3(0.0, 0.0, 0.5 * thickness));
  const glm::dquat turn = glm::angleAxis(0.37, glm::normalize(glm::dvec3(1.0, 0.4, 0.2)));
  for (glm::dvec3& p : sheet.positions) p = centre(box) + turn * p;
  return sheet;
}

}  // namespace

Mesh pebble() {
  Mesh mesh = reference::icosphere(1.0, 5);
  for (glm::dvec3& p : mesh.positions)
    p *= 1.0 + 0.10 * std::sin(3.0 * p.x + 1.0) * std::cos(4.0 * p.z) + 0.05 * std::sin(7.0 * p.y + 2.0 * p.z) * std::cos(6.0 * p.x);
  mesh.name = "pebble";
  return mesh;
}

std::vector<Damage> damages(const Mesh& closed, double voxel, std::uint64_t seed) {
  const Box box = bounds(closed);
  const double lid = box.max.x - kCapHeight * extent(box).x;
  const glm::dvec3 shift = kCopyOffset * voxel * glm::normalize(glm::dvec3(1.0, 0.7, -0.4));
  const Mesh copies = joined(joined(closed, moved(closed, shift)), moved(closed, -0.6 * shift));
  const Mesh folded = throughItself(closed);
  const Mesh sheet = sheetLike(closed, kSheetThickness * voxel);
  const Mesh soup = soupOf(closed, kJitter * voxel, seed);
  return {{"holes", withRoundHoles(closed, kHoleRadius * voxel, seed), closed},
          {"cut-off cap", cutOff(closed, lid), closed, lid},
          {fmt::format("{} open parts", kParts), inParts(closed, kPartOffset * voxel, seed), closed, kNoLid, kPartOffset * voxel},
          {"inside-out", insideOut(closed), closed},
          {"overlapping copies", copies, copies},
          {"self-intersecting", folded, folded},
          {"sub-voxel sheet", sheet, sheet},
          {"oriented soup", soup, closed, kNoLid, kJitter * voxel},
          {"unoriented soup", withFlips(soup, 0.5, seed), closed, kNoLid, kJitter * voxel}};
}

}  // namespace overcast::bench
