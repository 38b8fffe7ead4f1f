#include "formats/trs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/gtc/matrix_transform.hpp>

namespace overcast {
namespace {

constexpr double kShear = 1e-6;
constexpr double kConverged = 1e-15;
constexpr std::pair<int, int> kPairs[] = {{0, 1}, {0, 2}, {1, 2}};

/// Largest cosine between two columns.
double largestCosine(const glm::dmat3& m) {
  double largest = 0.0;
  for (const auto& [p, q] : kPairs) {
    const double lengths = glm::length(m[p]) * glm::length(m[q]);
    if (lengths > 0.0) largest = std::max(largest, std::abs(glm::dot(m[p], m[q])) / lengths);
  }
  return largest;
}

/// Turns columns p and q of `m` in their plane until they are orthogonal, and `turned` with them.
void orthogonalise(glm::dmat3& m, glm::dmat3& turned, int p, int q) {
  const double dot = glm::dot(m[p], m[q]);
  if (dot == 0.0) return;
  const double zeta = (glm::dot(m[q], m[q]) - glm::dot(m[p], m[p])) / (2.0 * dot);
  const double t = (zeta >= 0.0 ? 1.0 : -1.0) / (std::abs(zeta) + std::hypot(1.0, zeta));
  const double c = 1.0 / std::hypot(1.0, t);
  for (glm::dmat3* each : {&m, &turned}) {
    const glm::dvec3 first = (*each)[p];
    (*each)[p] = c * (first - t * (*each)[q]);
    (*each)[q] = c * ((*each)[q] + t * first);
  }
}

/// Some unit vector at right angles to a unit vector.
glm::dvec3 perpendicular(const glm::dvec3& v) {
  const glm::dvec3 axis = std::abs(v.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(v, axis));
}

/// A right-handed orthonormal basis along columns that are orthogonal or zero; `mirrored` says that x had to be turned round.
glm::dmat3 basisOf(const glm::dmat3& m, const glm::dvec3& lengths, bool& mirrored) {
  glm::dmat3 basis(1.0);
  int order[] = {0, 1, 2};
  std::stable_sort(order, order + 3, [&](int a, int b) { return lengths[a] > lengths[b]; });
  const int a = order[0], b = order[1], c = order[2];
  mirrored = false;
  if (!(lengths[a] > 0.0)) return basis;
  basis[a] = m[a] / lengths[a];
  const glm::dvec3 second = lengths[b] > 1e-12 * lengths[a] ? m[b] / lengths[b] : perpendicular(basis[a]);
  basis[b] = glm::normalize(second - glm::dot(second, basis[a]) * basis[a]);
  const double parity = (b - a + 3) % 3 == 1 ? 1.0 : -1.0;
  basis[c] = parity * glm::cross(basis[a], basis[b]);
  if (lengths[c] > 0.0 && glm::dot(basis[c], m[c]) < 0.0) {
    mirrored = true;
    basis[c] = -basis[c];
    basis[0] = -basis[0];
  }
  return basis;
}

}  // namespace

Trs decompose(const glm::dmat4& matrix) {
  Trs trs;
  trs.translation = glm::dvec3(matrix[3]);
  glm::dmat3 m(matrix);
  glm::dmat3 turned(1.0);
  const bool shears = largestCosine(m) > kShear;
  for (int sweep = 0; shears && sweep < 60 && largestCosine(m) > kConverged; ++sweep)
    for (const auto& [p, q] : kPairs) orthogonalise(m, turned, p, q);
  trs.scale = {glm::length(m[0]), glm::length(m[1]), glm::length(m[2])};
  bool mirrored = false;
  trs.rotation = glm::normalize(glm::quat_cast(basisOf(m, trs.scale, mirrored)));
  if (mirrored) trs.scale.x = -trs.scale.x;
  if (shears) trs.inner = glm::normalize(glm::quat_cast(glm::transpose(turned)));
  return trs;
}

bool isPlainTrs(const glm::dmat4& matrix, const Trs& parts) {
  if (parts.inner) return false;
  for (int i = 0; i < 3; ++i)
    if (!(std::abs(parts.scale[i]) >= 1e-6 && std::abs(parts.scale[i]) <= 100.0)) return false;
  const glm::dmat4 again = glm::scale(glm::mat4_cast(parts.rotation), parts.scale);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r)
      if (!(std::abs(again[c][r] - matrix[c][r]) <= 1e-6)) return false;
  return true;
}

}  // namespace overcast
