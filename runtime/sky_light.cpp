#include "runtime/sky_light.h"

#include <cmath>
#include <cstddef>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace overcast {

static_assert(sizeof(shared::SkyLight) == 144);

namespace {

/// The orthogonal factor of the polar decomposition by Newton's iteration (Higham 1986, "Computing the Polar Decomposition"), scaled so
/// that it converges for any regular matrix; a matrix too near to singular is first filled up to a regular one.
glm::dmat3 orthogonalPart(glm::dmat3 m) {
  const auto size = [](const glm::dmat3& a) { return std::sqrt(glm::dot(a[0], a[0]) + glm::dot(a[1], a[1]) + glm::dot(a[2], a[2])); };
  const double norm = size(m);
  if (!(norm > 0.0) || !std::isfinite(norm)) return glm::dmat3(1.0);
  m /= norm;
  constexpr double kSingular = 1e-12;
  if (std::abs(glm::determinant(m)) < kSingular) m += glm::dmat3(1e-3);
  if (std::abs(glm::determinant(m)) < kSingular) return glm::dmat3(1.0);
  for (int step = 0; step < 40; ++step) {
    const glm::dmat3 inverse = glm::transpose(glm::inverse(m));
    const double scale = std::sqrt(size(inverse) / size(m));
    const glm::dmat3 next = 0.5 * (scale * m + inverse / scale);
    const double change = size(next - m);
    m = next;
    if (change < 1e-14) break;
  }
  return m;
}

}  // namespace

shared::SkyLight skyLight(const SkyHarmonics& sky) {
  shared::SkyLight light;
  for (std::size_t i = 0; i < sky.coefficients.size(); ++i) light.coefficients[i] = glm::vec4(sky.coefficients[i], 0.0f);
  return light;
}

shared::SkyLight skyLight(const SkyHarmonics& sky, const glm::dmat4& worldFromLocal) {
  return skyLight(turned(sky, glm::transpose(orthogonalPart(glm::dmat3(worldFromLocal)))));
}

}  // namespace overcast
