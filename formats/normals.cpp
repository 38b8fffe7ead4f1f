#include "formats/normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>

namespace overcast {
namespace {

const glm::vec3 kUp{0.0f, 1.0f, 0.0f};

/// Unit normal of every triangle; zero where it has no area. Scaled by the largest coordinate, so that tiny meshes do not underflow.
std::vector<glm::dvec3> faceNormals(const Mesh& mesh) {
  std::vector<glm::dvec3> normals(mesh.triangles.size(), glm::dvec3(0.0));
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    const glm::dvec3 a = mesh.positions[t.y] - mesh.positions[t.x];
    const glm::dvec3 b = mesh.positions[t.z] - mesh.positions[t.x];
    const double scale = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z), std::abs(b.x), std::abs(b.y), std::abs(b.z)});
    if (!(scale > 0.0)) continue;
    const glm::dvec3 n = glm::cross(a / scale, b / scale);
    const double length = glm::length(n);
    if (length > 0.0) normals[i] = n / length;
  }
  return normals;
}

double angleBetween(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// Angle of triangle `t` at its corner `c`. The edges are scaled first, as in faceNormals.
double cornerAngle(const Mesh& mesh, const glm::uvec3& t, int c) {
  glm::dvec3 a = mesh.positions[t[(c + 1) % 3]] - mesh.positions[t[c]];
  glm::dvec3 b = mesh.positions[t[(c + 2) % 3]] - mesh.positions[t[c]];
  const double scaleA = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  const double scaleB = std::max({std::abs(b.x), std::abs(b.y), std::abs(b.z)});
  if (!(scaleA > 0.0) || !(scaleB > 0.0)) return 0.0;
  return angleBetween(a / scaleA, b / scaleB);
}

/// For every vertex the lowest vertex with the same position.
std::vector<std::uint32_t> weld(const Mesh& mesh) {
  const auto key = [&](std::uint32_t v) {
    const glm::dvec3& p = mesh.positions[v];
    return std::array<double, 3>{p.x, p.y, p.z};
  };
  std::vector<std::uint32_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  std::vector<std::uint32_t> welded(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    welded[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? welded[order[i - 1]] : order[i];
  return welded;
}

std::uint32_t find(std::vector<std::uint32_t>& parents, std::uint32_t i) {
  while (parents[i] != i) {
    parents[i] = parents[parents[i]];
    i = parents[i];
  }
  return i;
}

/// The lower corner leads, so that the result does not depend on the order of unions.
void unite(std::vector<std::uint32_t>& parents, std::uint32_t a, std::uint32_t b) {
  a = find(parents, a);
  b = find(parents, b);
  parents[std::max(a, b)] = std::min(a, b);
}

/// One side of a triangle: welded end points in ascending order and the corners there.
struct Side {
  std::uint32_t low, high;
  std::uint32_t lowCorner, highCorner;
};

/// Leader of every corner's smooth group (corner = 3 * triangle + 0..2): corners of faces that meet in an edge that is no crease.
std::vector<std::uint32_t> smoothGroups(const Mesh& mesh, const std::vector<glm::dvec3>& faces, const std::vector<std::uint32_t>& welded) {
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (faces[t] == glm::dvec3(0.0)) continue;
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t d = (c + 1) % 3;
      Side side{welded[mesh.triangles[t][static_cast<int>(c)]], welded[mesh.triangles[t][static_cast<int>(d)]], 3 * t + c, 3 * t + d};
      if (side.low > side.high) side = {side.high, side.low, side.highCorner, side.lowCorner};
      sides.push_back(side);
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::array{a.low, a.high, a.lowCorner} < std::array{b.low, b.high, b.lowCorner};
  });
  std::vector<std::uint32_t> parents(3 * mesh.triangles.size());
  std::iota(parents.begin(), parents.end(), 0u);
  for (std::size_t i = 1; i < sides.size(); ++i) {
    const Side& a = sides[i - 1];
    const Side& b = sides[i];
    if (a.low != b.low || a.high != b.high) continue;
    if (glm::dot(faces[a.lowCorner / 3], faces[b.lowCorner / 3]) < kCreaseCosine) continue;
    unite(parents, a.lowCorner, b.lowCorner);
    unite(parents, a.highCorner, b.highCorner);
  }
  for (std::uint32_t i = 0; i < parents.size(); ++i) parents[i] = find(parents, i);
  return parents;
}

/// A vertex that shows in the output: an input vertex together with the smooth group it is seen from.
struct Use {
  std::uint32_t vertex, group, corner;
};

}  // namespace

Mesh withNormals(Mesh mesh) {
  const std::vector<glm::dvec3> faces = faceNormals(mesh);
  const std::vector<std::uint32_t> groups = smoothGroups(mesh, faces, weld(mesh));
  std::vector<glm::dvec3> sums(groups.size(), glm::dvec3(0.0));
  std::vector<Use> uses;
  for (std::uint32_t corner = 0; corner < groups.size(); ++corner) {
    const glm::uvec3& t = mesh.triangles[corner / 3];
    const int c = static_cast<int>(corner % 3);
    sums[groups[corner]] += cornerAngle(mesh, t, c) * faces[corner / 3];
    if (faces[corner / 3] != glm::dvec3(0.0)) uses.push_back({t[c], groups[corner], corner});
  }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
    return std::array{a.vertex, a.group, a.corner} < std::array{b.vertex, b.group, b.corner};
  });
  mesh.normals.assign(mesh.positions.size(), kUp);
  for (std::size_t i = 0; i < uses.size();) {
    const Use first = uses[i];
    const bool staysInPlace = i == 0 || uses[i - 1].vertex != first.vertex;
    const std::uint32_t index = staysInPlace ? first.vertex : static_cast<std::uint32_t>(mesh.positions.size());
    if (!staysInPlace) {
      mesh.positions.push_back(glm::dvec3(mesh.positions[first.vertex]));
      mesh.normals.push_back(kUp);
      if (!mesh.textureCoordinates.empty()) mesh.textureCoordinates.push_back(glm::vec2(mesh.textureCoordinates[first.vertex]));
    }
    const double length = glm::length(sums[first.group]);
    mesh.normals[index] = glm::vec3(length > 0.0 ? sums[first.group] / length : faces[first.corner / 3]);
    for (; i < uses.size() && uses[i].vertex == first.vertex && uses[i].group == first.group; ++i)
      mesh.triangles[uses[i].corner / 3][static_cast<int>(uses[i].corner % 3)] = index;
  }
  return mesh;
}

void mendNormals(Mesh& mesh) {
  for (glm::vec3& normal : mesh.normals) {
    const double length = glm::length(glm::dvec3(normal));
    if (std::abs(length - 1.0) <= 1e-4) continue;
    normal = length > 0.0 ? glm::vec3(glm::dvec3(normal) / length) : kUp;
  }
}

}  // namespace overcast
