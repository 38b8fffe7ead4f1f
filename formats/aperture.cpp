#include "formats/aperture.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "formats/shared/aperture.h"

namespace overcast {
namespace {

/// Octahedral coordinates of a vector of any length, [-1, 1]^2.
glm::dvec2 octahedralPoint(const glm::dvec3& v) {
  const glm::dvec2 p = glm::dvec2(v.x, v.y) / (std::abs(v.x) + std::abs(v.y) + std::abs(v.z));
  if (v.z >= 0.0) return p;
  return {(1.0 - std::abs(p.y)) * (p.x >= 0.0 ? 1.0 : -1.0), (1.0 - std::abs(p.x)) * (p.y >= 0.0 ? 1.0 : -1.0)};
}

struct OctahedralCode {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
};

/// The map's border names each direction twice, mirrored about the middle of the side; the lower code stands for both.
OctahedralCode canonical(OctahedralCode code, std::uint32_t middle) {
  const std::uint32_t last = 2 * middle;
  if (code.y == 0 || code.y == last) code.x = std::min(code.x, last - code.x);
  if (code.x == 0 || code.x == last) code.y = std::min(code.y, last - code.y);
  return code;
}

/// The nearest direction of the codes 0 .. 2 middle.
OctahedralCode octahedralCode(const glm::vec3& direction, std::uint32_t middle) {
  const glm::dvec3 unit = glm::normalize(glm::dvec3(direction));
  const glm::dvec2 point = (octahedralPoint(unit) + 1.0) * static_cast<double>(middle);
  const auto rounded = [&](double coordinate, int by) {
    return static_cast<std::uint32_t>(std::clamp(std::round(coordinate) + by, 0.0, 2.0 * middle));
  };
  OctahedralCode best;
  double least = 8.0;
  for (int j = -1; j <= 1; ++j) {
    for (int i = -1; i <= 1; ++i) {
      const OctahedralCode code{rounded(point.x, i), rounded(point.y, j)};
      const glm::vec3 decoded =
          shared::octahedralDirection({shared::octahedralCoordinate(code.x, middle), shared::octahedralCoordinate(code.y, middle)});
      const glm::dvec3 off = glm::normalize(glm::dvec3(decoded)) - unit;
      if (glm::dot(off, off) >= least) continue;
      least = glm::dot(off, off);
      best = code;
    }
  }
  return canonical(best, middle);
}

std::uint32_t codeOf(double share, std::uint32_t largest) {
  return static_cast<std::uint32_t>(std::round(std::clamp(share, 0.0, 1.0) * largest));
}

double shareOf(float radius) {
  return static_cast<double>(radius) / static_cast<double>(shared::kApertureWidest);
}

bool isAperture(const Aperture& aperture) {
  const double length = glm::length(glm::dvec3(aperture.direction));
  return std::abs(length - 1.0) < 1e-3 && aperture.radius >= 0.0f && aperture.radius <= shared::kApertureWidest;
}

}  // namespace

std::string brokenVisibility(const VertexVisibility& visibility, std::size_t positions) {
  const auto fits = [&](std::size_t size) { return size == 0 || size == positions; };
  if (visibility.bits > ApertureBits::packed64) return "has apertures of an unknown packing";
  if (!fits(visibility.apertures.size()) || !fits(visibility.ambient.size()) || !fits(visibility.transfer.size()))
    return "has visibility of another number of vertices";
  if (visibility.bits == ApertureBits::packed64 && visibility.ambient.size() != visibility.apertures.size())
    return "has apertures of 8 bytes without ambient visibility";
  if (!std::all_of(visibility.apertures.begin(), visibility.apertures.end(), isAperture)) return "has an aperture that is out of range";
  for (const float ambient : visibility.ambient)
    if (!(ambient >= 0.0f && ambient <= 1.0f)) return "has an ambient visibility that is out of range";
  for (const std::array<float, 9>& transfer : visibility.transfer)
    if (!std::all_of(transfer.begin(), transfer.end(), [](float t) { return std::isfinite(t); }))
      return "has a transfer that is not finite";
  return "";
}

VertexVisibility asStored(VertexVisibility visibility) {
  const bool wide = visibility.bits == ApertureBits::packed64;
  if (!wide) visibility.ambient.clear();
  for (std::size_t i = 0; i < visibility.apertures.size(); ++i) {
    Aperture& aperture = visibility.apertures[i];
    if (!wide) {
      aperture = unpackAperture32(packAperture32(aperture));
      continue;
    }
    const std::uint64_t code = packAperture64(aperture, visibility.ambient[i]);
    aperture = unpackAperture64(code);
    visibility.ambient[i] = unpackAmbient64(code);
  }
  return visibility;
}

float capRadius(double visible) {
  return std::min(static_cast<float>(2.0 * std::asin(std::sqrt(std::clamp(visible, 0.0, 1.0) / 2.0))), shared::kApertureWidest);
}

std::uint32_t packAperture32(const Aperture& aperture) {
  const OctahedralCode code = octahedralCode(aperture.direction, 1023);
  return code.x | code.y << 11 | codeOf(shareOf(aperture.radius), 1023) << 22;
}

std::uint64_t packAperture64(const Aperture& aperture, float ambient) {
  const OctahedralCode code = octahedralCode(aperture.direction, 32767);
  const std::uint32_t first = code.x | code.y << 16;
  const std::uint32_t second = codeOf(shareOf(aperture.radius), 65535) | codeOf(static_cast<double>(ambient), 65535) << 16;
  return first | static_cast<std::uint64_t>(second) << 32;
}

Aperture unpackAperture32(std::uint32_t code) {
  const glm::vec4 decoded = shared::apertureFromWord(code);
  return {glm::vec3(decoded.x, decoded.y, decoded.z), decoded.w};
}

Aperture unpackAperture64(std::uint64_t code) {
  const glm::vec4 decoded = shared::apertureFromWords(static_cast<std::uint32_t>(code), static_cast<std::uint32_t>(code >> 32));
  return {glm::vec3(decoded.x, decoded.y, decoded.z), decoded.w};
}

float unpackAmbient64(std::uint64_t code) {
  return shared::ambientFromWord(static_cast<std::uint32_t>(code >> 32));
}

}  // namespace overcast
