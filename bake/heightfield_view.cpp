#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <tbb/parallel_for.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/canonical.h"
#include "bake/height_raster.h"
#include "bake/heightfield.h"
#include "bake/lattice.h"

namespace overcast {
namespace {

constexpr int kViewLines = 128;           ///< along the longer side, to judge a direction
constexpr double kSameHeight = 1e-7;      ///< share of the diagonal
constexpr double kClearlyFlatter = 1.02;  ///< what a later direction must be better by
constexpr double kClearlySmaller = 0.95;  ///< what the rectangle of a turned frame must be smaller by
constexpr int kTurns = 30;                ///< frames tried over a quarter turn

Error failure(std::string reason) {
  return Error{"", "", std::move(reason)};
}

/// A direction with what is seen from it.
struct Candidate {
  glm::dmat3 localFromField{1.0};
  const char* name = "";
  HeightShares shares;
};

/// A right-handed frame with this third axis. Its first is the coordinate axis least along it, made orthogonal.
glm::dmat3 frameAlong(const glm::dvec3& axis) {
  int least = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(axis[a]) < std::abs(axis[least])) least = a;
  glm::dvec3 x(0.0);
  x[least] = 1.0;
  x = glm::normalize(x - axis * glm::dot(axis, x));
  return {x, glm::cross(axis, x), axis};
}

/// Eigenvectors of a symmetric matrix as columns, by Jacobi rotations.
glm::dmat3 eigenvectors(glm::dmat3 m) {
  glm::dmat3 vectors(1.0);
  constexpr int kSweeps = 30;  // convergence is quadratic; five or six do
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (const auto& [p, q] : {std::array{0, 1}, std::array{0, 2}, std::array{1, 2}}) {
      if (m[p][q] == 0.0) continue;
      const double theta = 0.5 * std::atan2(2.0 * m[p][q], m[p][p] - m[q][q]), c = std::cos(theta), s = std::sin(theta);
      glm::dmat3 turn(1.0);
      turn[p][p] = turn[q][q] = c;
      turn[p][q] = s;
      turn[q][p] = -s;
      m = glm::transpose(turn) * m * turn;
      vectors = vectors * turn;
    }
  for (int axis = 0; axis < 3; ++axis) vectors[axis] = glm::normalize(vectors[axis]);
  return vectors;
}

/// Sum over triangles of area * normal * normal^T, in any scale: its eigenvectors are the mesh's dominant normals, whatever their signs.
/// Summed in integers, so that the order of triangles does not matter.
glm::dmat3 normalCovariance(const Mesh& mesh) {
  std::array<std::array<Int128, 3>, 3> sum{};
  const double scale = 1.0 / diagonal(bounds(mesh));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = mesh.positions[t.x], ab = scale * (mesh.positions[t.y] - a), ac = scale * (mesh.positions[t.z] - a);
    const glm::dvec3 normal = glm::cross(ab, ac);  // at most 1 long
    const double area = glm::length(normal);
    if (area == 0.0) continue;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        sum[i][j] += static_cast<Int128>(normal[static_cast<int>(i)] * normal[static_cast<int>(j)] / area * 0x1p60);
  }
  glm::dmat3 covariance;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) covariance[static_cast<int>(i)][static_cast<int>(j)] = static_cast<double>(sum[i][j]) * 0x1p-60;
  return covariance;
}

std::vector<Candidate> candidatesFor(const Mesh& mesh) {
  std::vector<Candidate> candidates;
  constexpr std::array kNames = {"+y", "+z", "+x", "-y", "-z", "-x"};
  constexpr std::array kAxes = {1, 2, 0};
  for (std::size_t n = 0; n < kNames.size(); ++n) {
    glm::dvec3 axis(0.0);
    axis[kAxes[n % 3]] = n < 3 ? 1.0 : -1.0;
    candidates.push_back({frameAlong(axis), kNames[n], {}});
  }
  const glm::dmat3 dominant = eigenvectors(normalCovariance(mesh));
  for (int n = 0; n < 6; ++n) candidates.push_back({frameAlong(n < 3 ? dominant[n] : -dominant[n - 3]), "a dominant normal", {}});
  return candidates;
}

/// The frame turned about its third axis to where the mesh's rectangle is smallest.
glm::dmat3 turned(const glm::dmat3& frame, const Mesh& mesh) {
  const glm::dvec3 middle = centre(bounds(mesh));
  glm::dmat3 best = frame;
  double smallest = 0.0;
  for (int n = 0; n < kTurns; ++n) {
    const double angle = 0.5 * std::numbers::pi * n / kTurns;
    const glm::dvec3 x = std::cos(angle) * frame[0] + std::sin(angle) * frame[1], y = glm::cross(frame[2], x);
    glm::dvec2 low(1e300), high(-1e300);
    for (const glm::uvec3& t : mesh.triangles)
      for (const auto corner : {t.x, t.y, t.z}) {
        const glm::dvec3 p = mesh.positions[corner] - middle;
        const glm::dvec2 at(glm::dot(x, p), glm::dot(y, p));
        low = glm::min(low, at);
        high = glm::max(high, at);
      }
    const double area = (high.x - low.x) * (high.y - low.y);
    if (n > 0 && area >= (best == frame ? kClearlySmaller : 1.0) * smallest) continue;
    smallest = area;
    best = {x, y, frame[2]};
  }
  return best;
}

HeightShares sharesFrom(const Mesh& mesh, const glm::dmat3& frame) {
  const Box local = bounds(mesh);
  std::vector<glm::dvec3> points;
  points.reserve(mesh.positions.size());
  for (const glm::dvec3& p : mesh.positions) points.push_back((p - centre(local)) * frame);
  Box box;
  for (const glm::uvec3& t : mesh.triangles)
    for (const auto corner : {t.x, t.y, t.z}) include(box, points[corner]);
  const glm::dvec2 size(extent(box));
  const double longer = std::max(size.x, size.y);
  if (!(std::min(size.x, size.y) > 1e-9 * longer)) return {};
  const double step = longer / kViewLines;
  const glm::ivec2 lines = glm::max(glm::ivec2(glm::ceil(size / step - 1e-9)), glm::ivec2(8));
  return measureShares(points, mesh.triangles, {lines, glm::dvec2(box.min), size / glm::dvec2(lines)}, kSameHeight * diagonal(local));
}

/// Of the candidates that are seen well enough the flattest, or null.
const Candidate* flattest(const std::vector<Candidate>& candidates, bool pair) {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : candidates) {
    const HeightShares& shares = candidate.shares;
    if (shares.flatness == 0.0 || (pair ? shares.either : shares.top) < kLeastSeen) continue;
    const bool faces = shares.facing > 0.5, bestFaces = best && best->shares.facing > 0.5;
    const bool better = !best || (faces != bestFaces && !pair ? faces : shares.flatness > kClearlyFlatter * best->shares.flatness);
    if (better) best = &candidate;
  }
  return best;
}

}  // namespace

Result<HeightView> bestHeightView(const Mesh& given) {
  if (given.triangles.empty()) return failure("mesh has no triangle");
  const Mesh mesh = canonicalOrder(given);
  const double size = diagonal(bounds(mesh));
  if (!std::isfinite(size) || size == 0.0) return failure("mesh has no extent");
  std::vector<Candidate> candidates = candidatesFor(mesh);
  tbb::parallel_for(std::size_t{0}, candidates.size(),
                    [&](std::size_t n) { candidates[n].shares = sharesFrom(mesh, candidates[n].localFromField); });
  for (const bool pair : {false, true})
    if (const Candidate* best = flattest(candidates, pair))
      return HeightView{turned(best->localFromField, mesh), pair, pair ? best->shares.either : best->shares.top, best->shares.flatness};
  const auto most = std::max_element(candidates.begin(), candidates.end(),
                                     [](const Candidate& a, const Candidate& b) { return a.shares.either < b.shares.either; });
  if (most->shares.flatness == 0.0) return failure("no line meets the mesh from any side");
  return failure(fmt::format("from its best side, {}, and the opposite one {:.0f} % of the surface is seen, a heightfield needs {:.0f} %",
                             most->name, 100.0 * most->shares.either, 100.0 * kLeastSeen));
}

}  // namespace overcast
