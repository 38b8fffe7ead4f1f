#include "tests/bench/sign_methods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "tests/bench/peers.h"

namespace overcast::bench {
namespace {

constexpr double kAccuracy = 2.0;  ///< a node is a dipole from this many of its radii on, as in libigl
constexpr std::size_t kLeaf = 8;

glm::dvec3 samplePoint(const Grid& grid, int i, int j, int k) {
  return grid.origin + grid.voxelSize * glm::dvec3(i, j, k);
}

/// For every row along x, calls visit(count, odd) at each sample: entries less exits, and whether the number of crossings is odd.
template <class Decide>
Inside alongRows(const Mesh& mesh, const Grid& grid, Decide decide) {
  Inside inside(sampleCount(grid), 0);
  tbb::parallel_for(0, grid.size.z, [&](int k) {
    struct Crossing {
      double x;
      int way;
    };
    std::vector<std::vector<Crossing>> rows(static_cast<std::size_t>(grid.size.y));
    const double z = samplePoint(grid, 0, 0, k).z;
    for (const glm::uvec3& t : mesh.triangles) {
      const std::array<glm::dvec3, 3> p = {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
      if (std::min({p[0].z, p[1].z, p[2].z}) > z || std::max({p[0].z, p[1].z, p[2].z}) < z) continue;
      const double lowest = (std::min({p[0].y, p[1].y, p[2].y}) - grid.origin.y) / grid.voxelSize;
      const double highest = (std::max({p[0].y, p[1].y, p[2].y}) - grid.origin.y) / grid.voxelSize;
      const int last = std::min(static_cast<int>(std::floor(highest)), grid.size.y - 1);
      for (int j = std::max(static_cast<int>(std::ceil(lowest)), 0); j <= last; ++j) {
        const double y = samplePoint(grid, 0, j, k).y;
        std::array<double, 3> weight{};
        for (std::size_t i = 0; i < 3; ++i) {
          const glm::dvec3 &a = p[(i + 1) % 3], &b = p[(i + 2) % 3];
          weight[i] = (b.y - a.y) * (z - a.z) - (b.z - a.z) * (y - a.y);
        }
        const bool left = weight[0] > 0.0 && weight[1] > 0.0 && weight[2] > 0.0;
        const bool right = weight[0] < 0.0 && weight[1] < 0.0 && weight[2] < 0.0;
        if (!left && !right) continue;
        const double x = (weight[0] * p[0].x + weight[1] * p[1].x + weight[2] * p[2].x) / (weight[0] + weight[1] + weight[2]);
        rows[static_cast<std::size_t>(j)].push_back({x, right ? 1 : -1});
      }
    }
    for (int j = 0; j < grid.size.y; ++j) {
      std::vector<Crossing>& row = rows[static_cast<std::size_t>(j)];
      std::sort(row.begin(), row.end(), [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
      std::size_t next = 0;
      int count = 0;
      for (int i = 0; i < grid.size.x; ++i) {
        for (; next < row.size() && row[next].x < samplePoint(grid, i, j, k).x; ++next) count += row[next].way;
        inside[static_cast<std::size_t>((k * grid.size.y + j) * grid.size.x + i)] = decide(count, next % 2 != 0) ? 1 : 0;
      }
    }
  });
  return inside;
}

/// Positions that are equal get one number.
std::vector<std::uint32_t> welded(const Mesh& mesh) {
  std::map<std::tuple<double, double, double>, std::uint32_t> known;
  std::vector<std::uint32_t> number;
  for (const glm::dvec3& p : mesh.positions)
    number.push_back(known.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(known.size())).first->second);
  return number;
}

/// Face normals, their sums over edges, and over vertices weighted by angle.
struct Pseudonormals {
  std::vector<std::uint32_t> number;
  std::vector<glm::dvec3> face;
  std::map<std::pair<std::uint32_t, std::uint32_t>, glm::dvec3> edge;
  std::vector<glm::dvec3> vertex;

  explicit Pseudonormals(const Mesh& mesh) : number(welded(mesh)), vertex(mesh.positions.size(), glm::dvec3(0.0)) {
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 area = glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
      const double length = glm::length(area);
      face.push_back(length > 0.0 ? area / length : glm::dvec3(0.0));
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
        edge[std::minmax(number[a], number[b])] += face.back();
        const glm::dvec3 toB = mesh.positions[b] - mesh.positions[a], toC = mesh.positions[c] - mesh.positions[a];
        vertex[number[a]] += std::atan2(glm::length(glm::cross(toB, toC)), glm::dot(toB, toC)) * face.back();
      }
    }
  }

  /// Of the feature of triangle `index` with these barycentric coordinates.
  glm::dvec3 at(const Mesh& mesh, std::uint32_t index, const glm::dvec3& weights) const {
    constexpr double kZero = 1e-5;
    const glm::uvec3& t = mesh.triangles[index];
    for (int i = 0; i < 3; ++i)
      if (weights[i] > 1.0 - kZero) return vertex[number[t[i]]];
    for (int i = 0; i < 3; ++i)
      if (weights[i] < kZero) return edge.at(std::minmax(number[t[(i + 1) % 3]], number[t[(i + 2) % 3]]));
    return face[index];
  }
};

/// Coordinates of a point of the triangle's plane with respect to its corners.
glm::dvec3 barycentric(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double whole = glm::dot(normal, normal);
  if (whole == 0.0) return glm::dvec3(1.0 / 3.0);
  const double first = glm::dot(normal, glm::cross(c - b, p - b)) / whole, second = glm::dot(normal, glm::cross(a - c, p - c)) / whole;
  return {first, second, 1.0 - first - second};
}

/// A box tree of dipoles.
struct DipoleNode {
  glm::dvec3 centre{0.0}, area{0.0};
  glm::dmat3 moment{0.0};
  double radius = 0.0;
  std::size_t first = 0, last = 0;  ///< triangles, in the tree's order
  int left = -1, right = -1;
};

class DipoleTree {
 public:
  explicit DipoleTree(const Mesh& mesh) : mesh_(mesh), order_(mesh.triangles) { build(0, order_.size()); }

  double winding(const glm::dvec3& point) const { return visit(0, point) / (4.0 * std::numbers::pi); }

 private:
  glm::dvec3 middle(const glm::uvec3& t) const { return (mesh_.positions[t.x] + mesh_.positions[t.y] + mesh_.positions[t.z]) / 3.0; }
  glm::dvec3 areaOf(const glm::uvec3& t) const {
    return 0.5 * glm::cross(mesh_.positions[t.y] - mesh_.positions[t.x], mesh_.positions[t.z] - mesh_.positions[t.x]);
  }

  int build(std::size_t first, std::size_t last) {
    const auto index = nodes_.size();
    nodes_.emplace_back();
    DipoleNode node;
    node.first = first;
    node.last = last;
    Box box;
    double weight = 0.0;
    glm::dvec3 sum(0.0);
    for (std::size_t i = first; i < last; ++i) {
      include(box, middle(order_[i]));
      const glm::dvec3 area = areaOf(order_[i]);
      node.area += area;
      weight += glm::length(area);
      sum += glm::length(area) * middle(order_[i]);
    }
    node.centre = weight > 0.0 ? sum / weight : centre(box);
    for (std::size_t i = first; i < last; ++i) {
      node.moment += glm::outerProduct(areaOf(order_[i]), middle(order_[i]) - node.centre);
      for (int c = 0; c < 3; ++c) node.radius = std::max(node.radius, glm::distance(mesh_.positions[order_[i][c]], node.centre));
    }
    if (last - first > kLeaf) {
      const glm::dvec3 size = extent(box);
      const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
      const std::size_t half = (first + last) / 2;
      const auto begin = order_.begin();
      std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(half),
                       begin + static_cast<std::ptrdiff_t>(last),
                       [&](const glm::uvec3& a, const glm::uvec3& b) { return middle(a)[axis] < middle(b)[axis]; });
      node.left = build(first, half);
      node.right = build(half, last);
    }
    nodes_[index] = node;
    return static_cast<int>(index);
  }

  double visit(int index, const glm::dvec3& point) const {
    const DipoleNode& node = nodes_[static_cast<std::size_t>(index)];
    const glm::dvec3 r = node.centre - point;
    const double distance = glm::length(r);
    if (distance > kAccuracy * node.radius) {
      const double trace = node.moment[0][0] + node.moment[1][1] + node.moment[2][2];
      const double cubed = distance * distance * distance;
      return (glm::dot(node.area, r) + trace - 3.0 * glm::dot(r, node.moment * r) / (distance * distance)) / cubed;
    }
    if (node.left >= 0) return visit(node.left, point) + visit(node.right, point);
    double sum = 0.0;
    for (std::size_t i = node.first; i < node.last; ++i) {
      const glm::dvec3 a = mesh_.positions[order_[i].x] - point, b = mesh_.positions[order_[i].y] - point,
                       c = mesh_.positions[order_[i].z] - point;
      const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
      sum +=
          2.0 * std::atan2(glm::dot(a, glm::cross(b, c)), la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
    return sum;
  }

  const Mesh& mesh_;
  std::vector<glm::uvec3> order_;
  std::vector<DipoleNode> nodes_;
};

}  // namespace

Inside parityInside(const Mesh& mesh, const Grid& grid) {
  return alongRows(mesh, grid, [](int, bool odd) { return odd; });
}

Inside crossingsInside(const Mesh& mesh, const Grid& grid) {
  return alongRows(mesh, grid, [](int count, bool) { return count != 0; });
}

Inside pseudonormalInside(const Mesh& mesh, const Grid& grid) {
  const Pseudonormals normals(mesh);
  const std::vector<NearestPoint> nearest = embreeNearest(mesh, grid);
  Inside inside(nearest.size(), 0);
  for (int k = 0; k < grid.size.z; ++k)
    for (int j = 0; j < grid.size.y; ++j)
      for (int i = 0; i < grid.size.x; ++i) {
        const auto sample = static_cast<std::size_t>((k * grid.size.y + j) * grid.size.x + i);
        const NearestPoint& found = nearest[sample];
        const glm::uvec3& t = mesh.triangles[found.triangle];
        const glm::dvec3 weights = barycentric(found.point, mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]);
        inside[sample] = glm::dot(samplePoint(grid, i, j, k) - found.point, normals.at(mesh, found.triangle, weights)) < 0.0 ? 1 : 0;
      }
  return inside;
}

Inside fastWindingInside(const Mesh& mesh, const Grid& grid) {
  const DipoleTree tree(mesh);
  Inside inside(sampleCount(grid), 0);
  tbb::parallel_for(0, grid.size.z, [&](int k) {
    for (int j = 0; j < grid.size.y; ++j)
      for (int i = 0; i < grid.size.x; ++i)
        inside[static_cast<std::size_t>((k * grid.size.y + j) * grid.size.x + i)] =
            std::abs(tree.winding(samplePoint(grid, i, j, k))) > 0.5 ? 1 : 0;
  });
  return inside;
}

}  // namespace overcast::bench
