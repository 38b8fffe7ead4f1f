#include "bake/primitive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include <Eigen/Dense>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "bake/distance.h"
#include "bake/oriented_box.h"
#include "bake/repair.h"
#include "bake/sign.h"
#include "bake/volume.h"

namespace overcast {
namespace {

constexpr std::size_t kSamples = 2048;  ///< every second on the surface, the others around it
constexpr double kReach = 0.05;         ///< how far around, diagonals
constexpr int kUnknowns = 9;            ///< centre, rotation vector, logarithms of the half extents
constexpr int kScoutSteps = 12;         ///< steps from each start; the best goes on
constexpr int kMostSteps = 80;

using Step = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;

/// Points and the mesh's signed distance there, in units of its diagonal about its middle.
struct Samples {
  std::span<const glm::dvec3> points;
  std::span<const double> distance;
};

/// A primitive on its way and the sum of its squared differences.
struct Fit {
  Primitive primitive;
  double cost = 0.0;
};

/// The mesh in units of its diagonal about its middle.
Mesh normalised(const Mesh& mesh, const Box& box) {
  Mesh scaled;
  scaled.triangles = mesh.triangles;
  scaled.positions.reserve(mesh.positions.size());
  // Vertices that no triangle uses may lie anywhere.
  for (const glm::dvec3& p : mesh.positions) scaled.positions.push_back((glm::clamp(p, box.min, box.max) - centre(box)) / diagonal(box));
  return scaled;
}

double areaOf(const Mesh& mesh, const glm::uvec3& t) {
  return 0.5 * glm::length(glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
}

/// Point `index` of a sequence that fills the unit cube of `Dimensions` evenly: multiples of the powers of the generalised golden ratio
/// (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
template <std::size_t Dimensions>
std::array<double, Dimensions> evenly(std::size_t index) {
  double ratio = 2.0;
  for (int i = 0; i < 40; ++i) ratio = std::pow(1.0 + ratio, 1.0 / (Dimensions + 1.0));
  std::array<double, Dimensions> point{};
  for (std::size_t i = 0; i < Dimensions; ++i) {
    const double turns = 0.5 + static_cast<double>(index + 1) * std::pow(ratio, -static_cast<double>(i + 1));
    point[i] = turns - std::floor(turns);
  }
  return point;
}

/// Fills in the points and distances.
void takeSamples(const Mesh& mesh, PrimitiveTarget& target) {
  std::vector<double> area(mesh.triangles.size());
  std::transform(mesh.triangles.begin(), mesh.triangles.end(), area.begin(), [&](const glm::uvec3& t) { return areaOf(mesh, t); });
  std::partial_sum(area.begin(), area.end(), area.begin());
  std::vector<glm::dvec3> off;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const auto [u, v, x, y, z] = evenly<5>(i);
    // Strata in place of the sequence's own coordinate for the triangle: small triangles get their share.
    const double wanted = area.back() * (static_cast<double>(i) + 0.5) / kSamples;
    const auto found = std::upper_bound(area.begin(), area.end(), wanted) - area.begin();
    const glm::uvec3& t = mesh.triangles[std::min(static_cast<std::size_t>(found), area.size() - 1)];
    const double root = std::sqrt(u);
    glm::dvec3 p = (1.0 - root) * mesh.positions[t.x] + root * (1.0 - v) * mesh.positions[t.y] + root * v * mesh.positions[t.z];
    if (i % 2 == 1) off.push_back(p += kReach * (2.0 * glm::dvec3(x, y, z) - 1.0));
    target.points.push_back(p);
  }
  VolumeSettings around;
  around.padding = 3.0;  // voxels of a 25th of the longest side: 0.12 of that, further than kReach of the diagonal
  const Grid grid = volumeGrid(bounds(mesh), around).value();
  const std::vector<double> distance = distanceAt(mesh, off), winding = windingAt(mesh, grid, off);
  for (std::size_t i = 0; i < kSamples; ++i)
    target.distance.push_back(i % 2 == 0 ? 0.0 : std::abs(winding[i / 2]) > 0.5 ? -distance[i / 2] : distance[i / 2]);
}

/// Principal axes of the surface's covariance.
glm::dmat3 inertiaAxes(const Mesh& mesh) {
  double total = 0.0;
  glm::dvec3 first(0.0);
  glm::dmat3 second(0.0);
  for (const glm::uvec3& t : mesh.triangles) {
    const double area = areaOf(mesh, t);
    const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z], sum = a + b + c;
    total += area;
    first += area / 3.0 * sum;
    second += area / 12.0 * (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c) + glm::outerProduct(sum, sum));
  }
  const glm::dvec3 middle = first / total;
  const glm::dmat3 covariance = second / total - glm::outerProduct(middle, middle);
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m(r, c) = covariance[c][r];
  const Eigen::Matrix3d vectors = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m).eigenvectors();
  const auto column = [&](int i) { return glm::dvec3(vectors(0, i), vectors(1, i), vectors(2, i)); };
  return {column(0), column(1), glm::cross(column(0), column(1))};
}

/// The cuboid around the mesh along these axes. An ellipsoid of the same half extents lies within it and touches its faces.
Primitive around(const Mesh& mesh, const glm::dmat3& axes) {
  Box box;
  for (const glm::dvec3& p : mesh.positions) include(box, glm::transpose(axes) * p);
  const glm::dvec3 half = 0.5 * extent(box);
  const double thinnest = 2.0 * kThinnestPrimitive * std::max({half.x, half.y, half.z});
  return {PrimitiveShape::cuboid, axes * centre(box), glm::normalize(glm::quat_cast(axes)), glm::max(half, glm::dvec3(thinnest))};
}

/// The primitive moved by a step, its turn about its own axes.
Primitive moved(const Primitive& from, const Step& step) {
  Primitive to = from;
  to.centre += glm::dvec3(step[0], step[1], step[2]);
  const glm::dvec3 turn(step[3], step[4], step[5]);
  const double angle = glm::length(turn);
  if (angle > 0.0) to.rotation = glm::normalize(from.rotation * glm::angleAxis(angle, turn / angle));
  for (int axis = 0; axis < 3; ++axis) to.halfExtents[axis] *= std::exp(std::clamp(step[6 + axis], -1.0, 1.0));
  const double largest = std::max({to.halfExtents.x, to.halfExtents.y, to.halfExtents.z});
  to.halfExtents = glm::max(to.halfExtents, glm::dvec3(2.0 * kThinnestPrimitive * largest));
  return to;
}

double costOf(const Primitive& primitive, const Samples& samples) {
  double sum = 0.0;
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    const double difference = samplePrimitive(primitive, samples.points[i]) - samples.distance[i];
    sum += difference * difference;
  }
  return sum;
}

/// The normal equations of the linearised problem, by central differences.
void linearise(const Primitive& primitive, const Samples& samples, Normal& matrix, Step& gradient) {
  constexpr double kDifference = 1e-6;
  std::array<Primitive, 2 * kUnknowns> neighbours;
  for (int k = 0; k < kUnknowns; ++k)
    for (int side = 0; side < 2; ++side)
      neighbours[static_cast<std::size_t>(2 * k + side)] = moved(primitive, (side == 0 ? kDifference : -kDifference) * Step::Unit(k));
  matrix.setZero();
  gradient.setZero();
  for (std::size_t i = 0; i < samples.points.size(); ++i) {
    Step slope;
    for (int k = 0; k < kUnknowns; ++k) {
      const auto first = static_cast<std::size_t>(2 * k);
      slope[k] = (samplePrimitive(neighbours[first], samples.points[i]) - samplePrimitive(neighbours[first + 1], samples.points[i])) /
                 (2.0 * kDifference);
    }
    matrix += slope * slope.transpose();
    gradient += slope * (samplePrimitive(primitive, samples.points[i]) - samples.distance[i]);
  }
}

/// Levenberg and Marquardt's method: at most `steps`, fewer when nothing is left to gain.
Fit refine(Fit fit, const Samples& samples, int steps) {
  const double rounding = 1e-28 * static_cast<double>(samples.points.size());
  double damping = 1e-3;
  for (int step = 0; step < steps && fit.cost > rounding && damping < 1e9; ++step) {
    Normal matrix;
    Step gradient;
    linearise(fit.primitive, samples, matrix, gradient);
    bool better = false;
    while (!better && damping < 1e9) {
      Normal damped = matrix;
      // A share of the trace too: a sphere may turn at no cost.
      for (int k = 0; k < kUnknowns; ++k) damped(k, k) += damping * (matrix(k, k) + 1e-6 * matrix.trace());
      const Primitive trial = moved(fit.primitive, -damped.ldlt().solve(gradient));
      const double cost = costOf(trial, samples);
      better = cost < fit.cost;
      damping *= better ? 0.1 : 10.0;
      const bool settled = better && cost > fit.cost * (1.0 - 1e-6);
      if (better) fit = {trial, cost};
      if (settled) return fit;
    }
  }
  return fit;
}

Error failure(std::string reason) {
  return Error{"", "", std::move(reason)};
}

}  // namespace

Result<PrimitiveTarget> primitiveTarget(const Mesh& mesh) {
  PrimitiveTarget target;
  target.box = bounds(mesh);
  if (const Result<Grid> checked = volumeGrid(target.box, VolumeSettings{}); !checked) return checked.error();
  const Mesh prepared = repair(normalised(mesh, target.box)).mesh;
  const double area = std::accumulate(prepared.triangles.begin(), prepared.triangles.end(), 0.0,
                                      [&](double sum, const glm::uvec3& t) { return sum + areaOf(prepared, t); });
  if (!(area > 0.0)) return failure("no triangle has an area");
  takeSamples(prepared, target);
  if (const std::optional<glm::dmat3> axes = orientedBoxAxes(prepared.positions)) target.around.push_back(around(prepared, *axes));
  target.around.push_back(around(prepared, inertiaAxes(prepared)));
  target.around.push_back(around(prepared, glm::dmat3(1.0)));
  return target;
}

Result<Primitive> fitPrimitive(const PrimitiveTarget& target, PrimitiveShape shape, const Progress& progress) {
  const Samples samples{target.points, target.distance};
  Fit best;
  for (std::size_t i = 0; i < target.around.size(); ++i) {
    if (progress && !progress(0.2 + 0.2 * static_cast<double>(i))) return failure("interrupted");
    Primitive start = target.around[i];
    start.shape = shape;
    const Fit fit = refine({start, costOf(start, samples)}, samples, kScoutSteps);
    if (i == 0 || fit.cost < best.cost) best = fit;
  }
  best = refine(best, samples, kMostSteps);
  if (progress && !progress(1.0)) return failure("interrupted");

  Primitive primitive = best.primitive;
  primitive.centre = centre(target.box) + diagonal(target.box) * primitive.centre;
  primitive.halfExtents *= diagonal(target.box);
  if (!isWhole(primitive)) return failure("is too large, too small, too thin or too far away for a primitive");
  return primitive;
}

Result<Primitive> bakePrimitive(const Mesh& mesh, PrimitiveShape shape, const Progress& progress) {
  const Result<PrimitiveTarget> target = primitiveTarget(mesh);
  if (!target) return target.error();
  return fitPrimitive(target.value(), shape, progress);
}

}  // namespace overcast
