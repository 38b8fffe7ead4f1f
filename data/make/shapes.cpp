#include "data/make/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

namespace overcast {
namespace {

constexpr double kPi = std::numbers::pi;

std::uint32_t addVertex(Mesh& mesh, const glm::dvec3& position) {
  mesh.positions.push_back(snapped(position));
  return static_cast<std::uint32_t>(mesh.positions.size() - 1);
}

void addQuad(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  mesh.triangles.emplace_back(a, b, c);
  mesh.triangles.emplace_back(a, c, d);
}

// Area-weighted normals of shared vertices: edges that should look sharp have their vertices twice. Snapped as positions are.
Mesh finished(Mesh mesh, const std::string& name) {
  mesh.name = name;
  std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0.0));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x];
    const glm::dvec3 normal = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
    for (const std::uint32_t corner : {t.x, t.y, t.z}) sums[corner] += normal;
  }
  mesh.normals.clear();
  for (const glm::dvec3& sum : sums) mesh.normals.emplace_back(snapped(sum / glm::length(sum)));
  mesh.parts = {{0, static_cast<std::uint32_t>(mesh.triangles.size()), -1}};
  return mesh;
}

// A surface over u, v in [0, 1) that closes in both directions; du x dv points outwards.
Mesh closedSurface(int segments, int tubeSegments, const std::function<glm::dvec3(double, double)>& point) {
  Mesh mesh;
  for (int i = 0; i < segments; ++i)
    for (int j = 0; j < tubeSegments; ++j) addVertex(mesh, point(i / double(segments), j / double(tubeSegments)));
  const auto index = [&](int i, int j) { return static_cast<std::uint32_t>((i % segments) * tubeSegments + j % tubeSegments); };
  for (int i = 0; i < segments; ++i)
    for (int j = 0; j < tubeSegments; ++j) addQuad(mesh, index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
  return mesh;
}

// A disc in the plane y = height with its own vertices; `up` says where it looks.
void addDisc(Mesh& mesh, double radius, double height, int segments, bool up) {
  const std::uint32_t middle = addVertex(mesh, {0.0, height, 0.0});
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * kPi * i / segments;
    addVertex(mesh, {radius * std::cos(angle), height, radius * std::sin(angle)});
  }
  for (int i = 0; i < segments; ++i) {
    const std::uint32_t a = middle + 1 + static_cast<std::uint32_t>(i);
    const std::uint32_t b = middle + 1 + static_cast<std::uint32_t>((i + 1) % segments);
    mesh.triangles.emplace_back(middle, up ? b : a, up ? a : b);
  }
}

// Gielis' superformula with equal exponents: 1 at the middle of each of `lobes` lobes, less between them.
double superformula(double angle, double lobes) {
  const double c = std::pow(std::abs(std::cos(lobes * angle / 4.0)), 1.7);
  const double s = std::pow(std::abs(std::sin(lobes * angle / 4.0)), 1.7);
  return std::pow(c + s, -6.0);
}

// A surface from pole to pole about the y axis: `point` takes the angle about it and a share of the way up, 0 to 1.
Mesh polarSurface(int segments, int rings, const std::function<glm::dvec3(double, double)>& point) {
  Mesh mesh;
  const auto at = [&](int i, int j) { return point(-2.0 * kPi * i / segments, double(j) / rings); };
  const glm::dvec3 bottom = at(0, 0), top = at(0, rings);
  const std::uint32_t south = addVertex(mesh, bottom);
  for (int j = 1; j < rings; ++j)
    for (int i = 0; i < segments; ++i) addVertex(mesh, at(i, j));
  const std::uint32_t north = addVertex(mesh, top);
  const auto index = [&](int i, int j) { return static_cast<std::uint32_t>(1 + (j - 1) * segments + i % segments); };
  for (int i = 0; i < segments; ++i) {
    mesh.triangles.emplace_back(south, index(i + 1, 1), index(i, 1));
    for (int j = 1; j + 1 < rings; ++j) addQuad(mesh, index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
    mesh.triangles.emplace_back(north, index(i, rings - 1), index(i + 1, rings - 1));
  }
  return mesh;
}

}  // namespace

double snapped(double value) {
  return std::nearbyint(value * 1e6) / 1e6 + 0.0;
}

glm::dvec3 snapped(const glm::dvec3& value) {
  return {snapped(value.x), snapped(value.y), snapped(value.z)};
}

double lowestPoint(const Mesh& mesh, const glm::dquat& rotation) {
  double lowest = 1e300;
  for (const glm::dvec3& position : mesh.positions) lowest = std::min(lowest, (rotation * position).y);
  return lowest;
}

void fitToSize(Mesh& mesh, double longestSide) {
  const Box box = bounds(mesh);
  const glm::dvec3 sides = extent(box);
  const double factor = longestSide / std::max({sides.x, sides.y, sides.z});
  for (glm::dvec3& position : mesh.positions) position = (position - centre(box)) * factor;
}

Mesh makeBox(const glm::dvec3& extent) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      glm::dvec3 normal(0.0), u(0.0), v(0.0);
      normal[axis] = side;
      u[(axis + 1) % 3] = side;
      v[(axis + 2) % 3] = 1.0;
      const auto corner = [&](double s, double t) { return addVertex(mesh, 0.5 * extent * (normal + s * u + t * v)); };
      const std::uint32_t first = corner(-1.0, -1.0);
      corner(1.0, -1.0);
      corner(1.0, 1.0);
      corner(-1.0, 1.0);
      addQuad(mesh, first, first + 1, first + 2, first + 3);
    }
  }
  return finished(std::move(mesh), "box");
}

Mesh makeIcosphere(double radius, int subdivisions) {
  const double g = std::numbers::phi;
  std::vector<glm::dvec3> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                    {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  Mesh mesh;
  mesh.triangles = {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2}, {3, 2, 6}, {3, 6, 8},  {3, 8, 9},   {4, 9, 5}, {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < subdivisions; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, isNew] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
      if (isNew) points.push_back(glm::normalize(points[a]) + glm::normalize(points[b]));
      return entry->second;
    };
    std::vector<glm::uvec3> finer;
    for (const glm::uvec3& t : mesh.triangles) {
      const std::uint32_t ab = middle(t.x, t.y), bc = middle(t.y, t.z), ca = middle(t.z, t.x);
      finer.insert(finer.end(), {{t.x, ab, ca}, {ab, t.y, bc}, {ca, bc, t.z}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (const glm::dvec3& point : points) addVertex(mesh, radius * glm::normalize(point));
  return finished(std::move(mesh), "icosphere");
}

Mesh makeTorus(double radius, double tubeRadius, int segments, int tubeSegments) {
  return finished(closedSurface(segments, tubeSegments,
                                [&](double u, double v) {
                                  const double a = -2.0 * kPi * u, b = 2.0 * kPi * v;
                                  const double fromAxis = radius + tubeRadius * std::cos(b);
                                  return glm::dvec3(fromAxis * std::cos(a), tubeRadius * std::sin(b), fromAxis * std::sin(a));
                                }),
                  "torus");
}

Mesh makeCone(double radius, double height, int segments) {
  Mesh mesh;
  addDisc(mesh, radius, -0.5 * height, segments, false);
  const auto ring = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * kPi * i / segments;
    addVertex(mesh, {radius * std::cos(angle), -0.5 * height, radius * std::sin(angle)});
    addVertex(mesh, {0.0, 0.5 * height, 0.0});
  }
  for (int i = 0; i < segments; ++i) {
    const std::uint32_t a = ring + 2 * static_cast<std::uint32_t>(i);
    mesh.triangles.emplace_back(a, a + 1, ring + 2 * static_cast<std::uint32_t>((i + 1) % segments));
  }
  return finished(std::move(mesh), "cone");
}

Mesh makeCylinder(double radius, double height, int segments) {
  Mesh mesh;
  addDisc(mesh, radius, -0.5 * height, segments, false);
  addDisc(mesh, radius, 0.5 * height, segments, true);
  const auto ring = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i < segments; ++i) {
    const double angle = 2.0 * kPi * i / segments;
    for (const double y : {-0.5, 0.5}) addVertex(mesh, {radius * std::cos(angle), y * height, radius * std::sin(angle)});
  }
  for (int i = 0; i < segments; ++i) {
    const std::uint32_t a = ring + 2 * static_cast<std::uint32_t>(i), b = ring + 2 * static_cast<std::uint32_t>((i + 1) % segments);
    addQuad(mesh, a, a + 1, b + 1, b);
  }
  return finished(std::move(mesh), "cylinder");
}

Mesh makeTorusKnot(double radius, double tubeRadius, int p, int q, int segments, int tubeSegments) {
  const double scale = (radius - tubeRadius) / 3.0;
  const auto curve = [&](double t) {
    const double around = 2.0 * kPi * p * t, across = 2.0 * kPi * q * t;
    const double fromAxis = 2.0 + std::cos(across);
    return scale * glm::dvec3(fromAxis * std::cos(around), fromAxis * std::sin(around), std::sin(across));
  };
  return finished(closedSurface(segments, tubeSegments,
                                [&](double u, double v) {
                                  const glm::dvec3 here = curve(u), ahead = curve(u + 1e-4);
                                  const glm::dvec3 tangent = glm::normalize(ahead - here);
                                  const glm::dvec3 side = glm::normalize(glm::cross(tangent, ahead + here));
                                  const glm::dvec3 out = glm::cross(side, tangent);
                                  const double angle = 2.0 * kPi * v;
                                  return here + tubeRadius * (std::cos(angle) * out - std::sin(angle) * side);
                                }),
                  "torus_knot");
}

Mesh makeStar(double radius, int arms, int segments, int rings) {
  return finished(polarSurface(segments, rings,
                               [&](double around, double share) {
                                 const double up = kPi * (share - 0.5), fromMiddle = radius * superformula(up, 4.0);
                                 const double fromAxis = fromMiddle * superformula(around, arms) * std::cos(up);
                                 return glm::dvec3(fromAxis * std::cos(around), fromMiddle * std::sin(up), fromAxis * std::sin(around));
                               }),
                  "star");
}

Mesh makeStatue(double height, int segments, int rings) {
  // Widths of feet, hips, chest, neck and head, in heights, as bells about where they are: place, width, radius.
  constexpr double kBody[][3] = {{-0.50, 0.13, 0.215}, {-0.13, 0.15, 0.130}, {0.16, 0.115, 0.150}, {0.40, 0.060, 0.092}};
  const auto point = [&](double around, double share) {
    const double y = 0.5 * std::sin(kPi * (share - 0.5));
    double radius = 0.018;
    for (const auto& bell : kBody) radius += bell[2] * std::exp(-std::pow((y - bell[0]) / bell[1], 2.0));
    const double closing = std::pow(std::max(0.0, 1.0 - 4.0 * y * y), y < 0.0 ? 0.12 : 0.35);
    const double folds = 1.0 / (1.0 + std::exp(26.0 * (y - 0.27)));  // the head has none
    const double fold = 0.5 + 0.5 * std::sin(7.0 * around + 9.0 * y), crease = 0.5 + 0.5 * std::sin(17.0 * around - 14.0 * y);
    radius *= closing * (1.0 + folds * (0.30 * std::pow(fold, 1.6) - 0.17 + 0.07 * crease * (0.3 - y)));
    const glm::dvec3 spine(0.050 * std::sin(7.0 * y + 0.4), y, 0.035 * std::sin(5.0 * y - 0.8));
    return height * (spine + radius * glm::dvec3(1.12 * std::cos(around), 0.0, 0.86 * std::sin(around)));
  };
  return finished(polarSurface(segments, rings, point), "statue");
}

Mesh makeSlab(const glm::dvec3& extent, double cell) {
  const glm::ivec3 cells(std::max(1L, std::lround(extent.x / cell)), 1, std::max(1L, std::lround(extent.z / cell)));
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    const int across = (axis + 1) % 3, along = (axis + 2) % 3;
    for (const double side : {-1.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (int j = 0; j <= cells[along]; ++j)
        for (int i = 0; i <= cells[across]; ++i) {
          glm::dvec3 place;
          place[axis] = side;
          place[across] = side * (2.0 * i / cells[across] - 1.0);
          place[along] = 2.0 * j / cells[along] - 1.0;
          addVertex(mesh, 0.5 * extent * place);
        }
      const auto index = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (cells[across] + 1) + i); };
      for (int j = 0; j < cells[along]; ++j)
        for (int i = 0; i < cells[across]; ++i) addQuad(mesh, index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
    }
  }
  return finished(std::move(mesh), "slab");
}

namespace {

// A flat face with vertices of its own, counter-clockwise from outside; turned over when `reversed`.
void addFace(Mesh& mesh, const std::array<glm::dvec3, 4>& corners, bool reversed = false) {
  std::array<std::uint32_t, 4> v{};
  for (std::size_t i = 0; i < 4; ++i) v[i] = addVertex(mesh, corners[i]);
  if (reversed) {
    addQuad(mesh, v[3], v[2], v[1], v[0]);
  } else {
    addQuad(mesh, v[0], v[1], v[2], v[3]);
  }
}

// A face in the plane y = `y` or x = `x`, through the whole depth `z` to both sides, looking along +y or +x, or against it.
void addLevel(Mesh& mesh, double x0, double x1, double y, double z, bool up) {
  addFace(mesh, {glm::dvec3(x0, y, -z), {x0, y, z}, {x1, y, z}, {x1, y, -z}}, !up);
}
void addSide(Mesh& mesh, double x, double y0, double y1, double z, bool right) {
  addFace(mesh, {glm::dvec3(x, y0, -z), {x, y1, -z}, {x, y1, z}, {x, y0, z}}, !right);
}

}  // namespace

Mesh makeStairs(int steps, double run, double rise, double width) {
  Mesh mesh;
  const double z = 0.5 * width, length = run * steps, left = -0.5 * length, bottom = -0.5 * rise * steps;
  std::vector<glm::dvec2> profile = {{-left, bottom}, {left, bottom}};  // all of it is seen from its first corner
  for (int i = 0; i < steps; ++i)
    for (const int across : {0, 1}) profile.emplace_back(left + run * (i + across), bottom + rise * (i + 1));
  for (const double side : {z, -z}) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::dvec2& corner : profile) addVertex(mesh, {corner, side});
    for (std::uint32_t i = 1; i + 1 < profile.size(); ++i)
      mesh.triangles.emplace_back(first, first + (side > 0.0 ? i + 1 : i), first + (side > 0.0 ? i : i + 1));
  }
  for (int i = 0; i < steps; ++i) {
    addSide(mesh, left + run * i, bottom + rise * i, bottom + rise * (i + 1), z, false);
    addLevel(mesh, left + run * i, left + run * (i + 1), bottom + rise * (i + 1), z, true);
  }
  addSide(mesh, -left, bottom, -bottom, z, true);
  addLevel(mesh, left, -left, bottom, z, false);
  return finished(std::move(mesh), "stairs");
}

Mesh makeFrame(const glm::dvec3& extent, const glm::dvec2& holeMin, const glm::dvec2& holeMax) {
  Mesh mesh;
  const double z = 0.5 * extent.z;
  const std::array<double, 4> xs = {-0.5 * extent.x, holeMin.x, holeMax.x, 0.5 * extent.x};
  const std::array<double, 4> ys = {-0.5 * extent.y, holeMin.y, holeMax.y, 0.5 * extent.y};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (i == 1 && j == 1) continue;
      for (const double side : {z, -z})
        addFace(mesh, {glm::dvec3(xs[i], ys[j], side), {xs[i + 1], ys[j], side}, {xs[i + 1], ys[j + 1], side}, {xs[i], ys[j + 1], side}},
                side < 0.0);
    }
    addLevel(mesh, xs[i], xs[i + 1], ys[3], z, true);
    addLevel(mesh, xs[i], xs[i + 1], ys[0], z, false);
    addSide(mesh, xs[3], ys[i], ys[i + 1], z, true);
    addSide(mesh, xs[0], ys[i], ys[i + 1], z, false);
  }
  addLevel(mesh, xs[1], xs[2], ys[1], z, true);
  addLevel(mesh, xs[1], xs[2], ys[2], z, false);
  addSide(mesh, xs[1], ys[1], ys[2], z, true);
  addSide(mesh, xs[2], ys[1], ys[2], z, false);
  return finished(std::move(mesh), "frame");
}

Mesh makeLeaf(double length, double width, double fold, double thickness) {
  constexpr int kRows = 3;
  Mesh mesh;
  for (const double side : {1.0, -1.0}) {
    const std::uint32_t base = addVertex(mesh, {0.0, 0.0, 0.0});
    for (int row = 1; row <= kRows; ++row) {
      const double along = row / (kRows + 1.0), half = 0.5 * width * std::sin(kPi * std::pow(along, 0.8));
      addVertex(mesh, {-half, fold * 2.0 * half / width, length * along});
      addVertex(mesh, {0.0, 0.5 * side * thickness, length * along});
      addVertex(mesh, {half, fold * 2.0 * half / width, length * along});
    }
    const std::uint32_t tip = addVertex(mesh, {0.0, 0.0, length}), last = tip - 3;
    const std::size_t first = mesh.triangles.size();
    mesh.triangles.insert(mesh.triangles.end(), {{base, base + 1, base + 2}, {base, base + 2, base + 3}});
    for (std::uint32_t left = base + 1; left < last; left += 3) {
      addQuad(mesh, left, left + 3, left + 4, left + 1);
      addQuad(mesh, left + 1, left + 4, left + 5, left + 2);
    }
    mesh.triangles.insert(mesh.triangles.end(), {{last, tip, last + 1}, {last + 1, tip, last + 2}});
    if (side < 0.0)
      for (std::size_t t = first; t < mesh.triangles.size(); ++t) std::swap(mesh.triangles[t].y, mesh.triangles[t].z);
  }
  return finished(std::move(mesh), "leaf");
}

Mesh merged(const std::vector<Mesh>& meshes, const char* name) {
  Mesh whole;
  for (const Mesh& mesh : meshes) {
    const auto first = static_cast<std::uint32_t>(whole.positions.size());
    whole.positions.insert(whole.positions.end(), mesh.positions.begin(), mesh.positions.end());
    for (const glm::uvec3& t : mesh.triangles) whole.triangles.push_back(t + glm::uvec3(first));
  }
  return finished(std::move(whole), name);
}

Mesh transformed(Mesh mesh, const glm::dvec3& translation, const glm::dquat& rotation) {
  for (glm::dvec3& position : mesh.positions) position = snapped(translation + rotation * position);
  return finished(mesh, mesh.name);
}

}  // namespace overcast
