#include "runtime/passes/surfels/surfel_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "formats/result.h"

namespace overcast {
namespace {

constexpr int kMostParts = 64;

/// The discs of one triangle, divided into `parts` along each edge: those at its corners go to the vertices' own.
void addTriangle(const std::array<glm::dvec3, 3>& corners, const std::array<glm::dvec3, 3>& directions, const DiscTriangle& triangle,
                 int parts, std::vector<Disc>& discs) {
  const glm::dvec3 across = 0.5 * glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  const double third = glm::length(across) / (3.0 * parts * parts);
  for (int i = 0; i <= parts; ++i)
    for (int j = 0; i + j <= parts; ++j) {
      const int k = parts - i - j;
      const glm::dvec3 share = glm::dvec3(k, i, j) / static_cast<double>(parts);
      // Small triangles that meet here: six inside, three on an edge, one at a corner.
      const int outer = (i == 0) + (j == 0) + (k == 0);
      const double area = third * (outer == 0 ? 6.0 : outer == 1 ? 3.0 : 1.0);
      const glm::dvec3 direction = share.x * directions[0] + share.y * directions[1] + share.z * directions[2];
      const double length = glm::length(direction);
      const glm::dvec3 normal = length > 0.0 ? direction / length : glm::normalize(across);
      Disc disc{share.x * corners[0] + share.y * corners[1] + share.z * corners[2], area, area * normal,
                area * glm::dvec3(triangle.albedo)};
      if (outer < 2) {
        discs.push_back(disc);
        continue;
      }
      Disc& own = discs[triangle.corners[k == parts ? 0 : i == parts ? 1 : 2]];
      own.place = disc.place;
      own.area += disc.area;
      own.facing += disc.facing;
      own.albedo += disc.albedo;
    }
}

/// What a run of discs is together.
shared::Surfel merged(std::span<const Disc> discs, bool leaf) {
  double area = 0.0, size = 0.0;
  glm::dvec3 place(0.0), facing(0.0), albedo(0.0);
  for (const Disc& disc : discs) {
    area += disc.area;
    place += disc.area * disc.place;
    facing += disc.facing;
    albedo += disc.albedo;
  }
  place /= area;
  for (const Disc& disc : discs) size = std::max(size, glm::dot(disc.place - place, disc.place - place));
  const double length = glm::length(facing);
  const glm::dvec3 normal = length > 0.0 ? facing / length : glm::normalize(discs[0].facing);
  shared::Surfel node;
  node.place = glm::vec4(glm::vec3(place), static_cast<float>(area / std::numbers::pi));
  node.normal = glm::vec4(glm::vec3(normal), 0.0f);
  node.albedo = glm::vec4(glm::vec3(albedo / area), leaf ? 0.0f : static_cast<float>(size));
  return node;
}

struct Builder {
  std::size_t leafDiscs = 1;
  std::vector<shared::Surfel> nodes;

  void add(std::span<Disc> discs) {
    const bool leaf = discs.size() <= leafDiscs;
    const std::size_t node = nodes.size();
    nodes.push_back(merged(discs, leaf));
    if (!leaf) {
      const std::size_t middle = halve(discs);
      add(discs.first(middle));
      add(discs.subspan(middle));
    }
    nodes[node].normal.w = static_cast<float>(nodes.size());
  }

  static std::size_t halve(std::span<Disc> discs) {
    glm::dvec3 low = discs[0].place, high = low;
    for (const Disc& disc : discs) {
      low = glm::min(low, disc.place);
      high = glm::max(high, disc.place);
    }
    const glm::dvec3 sides = high - low;
    const int axis = sides.x >= sides.y && sides.x >= sides.z ? 0 : sides.y >= sides.z ? 1 : 2;
    std::stable_sort(discs.begin(), discs.end(), [axis](const Disc& a, const Disc& b) { return a.place[axis] < b.place[axis]; });
    return discs.size() / 2;
  }
};

/// 0 to 5: the axis and side that a disc faces most.
int sideOf(const Disc& disc) {
  const glm::dvec3 size = glm::abs(disc.facing);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return 2 * axis + (disc.facing[axis] < 0.0 ? 1 : 0);
}

}  // namespace

std::vector<Disc> discsOf(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals, std::span<const DiscTriangle> triangles,
                          double longestEdge) {
  OVERCAST_REQUIRE(longestEdge > 0.0 && (normals.empty() || normals.size() == positions.size()), "{} normals for {} vertices, edge {}",
                   normals.size(), positions.size(), longestEdge);
  std::vector<Disc> discs(positions.size());
  for (const DiscTriangle& triangle : triangles) {
    std::array<glm::dvec3, 3> corners, directions;
    for (int i = 0; i < 3; ++i) {
      corners[static_cast<std::size_t>(i)] = glm::dvec3(positions[triangle.corners[i]]);
      directions[static_cast<std::size_t>(i)] = normals.empty() ? glm::dvec3(0.0) : glm::dvec3(normals[triangle.corners[i]]);
    }
    const double longest = std::sqrt(
        std::max({glm::dot(corners[1] - corners[0], corners[1] - corners[0]), glm::dot(corners[2] - corners[1], corners[2] - corners[1]),
                  glm::dot(corners[0] - corners[2], corners[0] - corners[2])}));
    const glm::dvec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    if (!(glm::dot(across, across) > 0.0)) continue;
    const int parts = static_cast<int>(std::clamp(std::ceil(longest / longestEdge), 1.0, static_cast<double>(kMostParts)));
    addTriangle(corners, directions, triangle, parts, discs);
  }
  std::erase_if(discs, [](const Disc& disc) { return !(disc.area > 0.0 && glm::dot(disc.facing, disc.facing) > 0.0); });
  return discs;
}

std::vector<shared::Surfel> surfelTree(std::vector<Disc> discs, std::size_t mostLeaves) {
  OVERCAST_REQUIRE(mostLeaves > 0, "a tree of no leaves");
  std::stable_sort(discs.begin(), discs.end(), [](const Disc& a, const Disc& b) { return sideOf(a) < sideOf(b); });
  Builder builder;
  builder.leafDiscs = (discs.size() + mostLeaves - 1) / mostLeaves;
  for (auto first = discs.begin(); first != discs.end();) {
    const auto end = std::find_if(first, discs.end(), [side = sideOf(*first)](const Disc& disc) { return sideOf(disc) != side; });
    builder.add({first, end});
    first = end;
  }
  return std::move(builder.nodes);
}

}  // namespace overcast
