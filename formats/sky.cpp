#include "formats/sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "formats/files.h"
#include "formats/image_mipmaps.h"
#include "formats/uri.h"

namespace overcast {
namespace {

constexpr double kPi = std::numbers::pi;

/// Constants of the real orthonormal basis: of Y_0; of those linear in w; of xy, yz and xz; of 3 z^2 - 1; of x^2 - y^2.
const double kConstant = std::sqrt(0.25 / kPi);
const double kLinear = std::sqrt(3.0) * kConstant;
const double kMixed = std::sqrt(15.0) * kConstant;
const double kPolar = 0.5 * std::sqrt(5.0) * kConstant;
const double kDifference = 0.5 * kMixed;

/// Integrals of 1, w and w w^T over some solid angle, weighted by one channel's radiance or not.
struct Moments {
  double zeroth = 0.0;
  glm::dvec3 first{0.0};
  glm::dmat3 second{0.0};
};

std::array<double, 9> harmonicsOf(const Moments& m) {
  return {kConstant * m.zeroth,
          kLinear * m.first.y,
          kLinear * m.first.z,
          kLinear * m.first.x,
          kMixed * m.second[0][1],
          kMixed * m.second[1][2],
          kPolar * (3.0 * m.second[2][2] - m.zeroth),
          kMixed * m.second[0][2],
          kDifference * (m.second[0][0] - m.second[1][1])};
}

/// Where rows or columns end, and integrals over them of what the moments are made of.
struct Band {
  double one = 0.0, sine = 0.0, cosine = 0.0, sine2 = 0.0, cosine2 = 0.0, mixed = 0.0;
};

/// Of latitudes from `low` to `high`, with the cosine of the area: integrals of 1, sin, cos, sin^2, cos^2 and sin cos.
Band latitudes(double low, double high) {
  const auto difference = [&](const auto& f) { return f(high) - f(low); };
  Band band;
  band.one = difference([](double a) { return std::sin(a); });
  band.sine = difference([](double a) { return 0.5 * std::sin(a) * std::sin(a); });
  band.cosine = difference([](double a) { return 0.5 * (a + std::sin(a) * std::cos(a)); });
  band.sine2 = difference([](double a) { return std::pow(std::sin(a), 3.0) / 3.0; });
  band.cosine2 = band.one - band.sine2;
  band.mixed = difference([](double a) { return -std::pow(std::cos(a), 3.0) / 3.0; });
  return band;
}

/// The same of longitudes.
Band longitudes(double low, double high) {
  const auto difference = [&](const auto& f) { return f(high) - f(low); };
  Band band;
  band.one = high - low;
  band.sine = difference([](double a) { return -std::cos(a); });
  band.cosine = difference([](double a) { return std::sin(a); });
  band.sine2 = difference([](double a) { return 0.5 * (a - std::sin(a) * std::cos(a)); });
  band.cosine2 = band.one - band.sine2;
  band.mixed = difference([](double a) { return 0.5 * std::sin(a) * std::sin(a); });
  return band;
}

/// w = (cos latitude sin longitude, sin latitude, cos latitude cos longitude).
Moments cellMoments(const Band& latitude, const Band& longitude) {
  Moments m;
  m.zeroth = latitude.one * longitude.one;
  m.first = {latitude.cosine * longitude.sine, latitude.sine * longitude.one, latitude.cosine * longitude.cosine};
  m.second[0][0] = latitude.cosine2 * longitude.sine2;
  m.second[1][1] = latitude.sine2 * longitude.one;
  m.second[2][2] = latitude.cosine2 * longitude.cosine2;
  m.second[0][1] = latitude.mixed * longitude.sine;
  m.second[1][2] = latitude.mixed * longitude.cosine;
  m.second[0][2] = latitude.cosine2 * longitude.mixed;
  return m;
}

/// Solid angle of the part of the plane z = 1 between the origin and (x, y).
double cornerAngle(double x, double y) {
  return std::atan2(x * y, std::sqrt(x * x + y * y + 1.0));
}

/// Of the texel of a cube map in `direction`, whose neighbours are `step` away on a face that reaches from -1 to 1.
Moments texelMoments(const glm::dvec3& direction, double step) {
  const glm::dvec3 size = glm::abs(direction);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const double a = direction[(axis + 1) % 3] / size[axis], b = direction[(axis + 2) % 3] / size[axis];
  const auto inside = [](double coordinate) { return std::clamp(coordinate, -1.0, 1.0); };
  const double a0 = inside(a - 0.5 * step), a1 = inside(a + 0.5 * step), b0 = inside(b - 0.5 * step), b1 = inside(b + 0.5 * step);
  Moments m;
  m.zeroth = cornerAngle(a1, b1) - cornerAngle(a0, b1) - cornerAngle(a1, b0) + cornerAngle(a0, b0);
  const glm::dvec3 w = glm::normalize(direction);
  m.first = m.zeroth * w;
  m.second = m.zeroth * glm::outerProduct(w, w);
  return m;
}

/// Adds up pixels in the order of the file.
class Projection {
 public:
  explicit Projection(const Image& image) : image_(image), channels_(radianceChannels(image)) {}

  void add(int x, int y, const Moments& moments) {
    const std::array<double, 9> harmonics = harmonicsOf(moments);
    glm::dvec3 radiance;
    for (int c = 0; c < 3; ++c) radiance[c] = static_cast<double>(at(image_, x, y, channels_[static_cast<std::size_t>(c)]));
    broken_ = broken_ || std::isnan(radiance.x + radiance.y + radiance.z);
    radiance = glm::clamp(radiance, 0.0, kBrightestSky);
    for (std::size_t i = 0; i < 9; ++i) sums_[i] += harmonics[i] * radiance;
  }

  Result<SkyHarmonics> sky() const {
    if (broken_) return Error{"", "", "has pixels that are not a number"};
    SkyHarmonics sky;
    std::transform(sums_.begin(), sums_.end(), sky.coefficients.begin(), [](const glm::dvec3& sum) { return glm::vec3(sum); });
    return sky;
  }

 private:
  const Image& image_;
  std::array<int, 3> channels_;
  std::array<glm::dvec3, 9> sums_{};
  bool broken_ = false;
};

}  // namespace

SkyHarmonics uniformSky(const glm::vec3& radiance) {
  SkyHarmonics sky;
  sky.coefficients[0] = glm::vec3(glm::dvec3(radiance) / kConstant);
  return sky;
}

std::array<int, 3> radianceChannels(const Image& image) {
  const std::array<int, 3> colours{channelIndex(image, "R"), channelIndex(image, "G"), channelIndex(image, "B")};
  if (*std::min_element(colours.begin(), colours.end()) >= 0) return colours;
  const int grey = channelIndex(image, "Y");
  return {grey, grey, grey};
}

Result<SkyHarmonics> skyHarmonics(const Image& image) {
  if (radianceChannels(image)[0] < 0) return Error{"", "", "has neither the channels R, G and B nor Y"};
  const int width = image.width, height = image.height;
  Projection projection(image);
  if (width == 2 * height) {
    std::vector<Band> columns;
    for (int x = 0; x < width; ++x) columns.push_back(longitudes(kPi * (1.0 - 2.0 * (x + 1.0) / width), kPi * (1.0 - 2.0 * x / width)));
    for (int y = 0; y < height; ++y) {
      const Band row = latitudes(kPi * (0.5 - (y + 1.0) / height), kPi * (0.5 - static_cast<double>(y) / height));
      for (int x = 0; x < width; ++x) projection.add(x, y, cellMoments(row, columns[static_cast<std::size_t>(x)]));
    }
    return projection.sky();
  }
  if (height == 6 * width && width >= 2) {
    const std::vector<glm::dvec3> directions = cubePixelDirections(width);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        projection.add(x, y,
                       texelMoments(directions[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)],
                                    2.0 / (width - 1)));
    return projection.sky();
  }
  return Error{"", "",
               fmt::format("{}x{} pixels are neither twice as wide as high (latitude and longitude) nor six times as high as wide (a cube)",
                           width, height)};
}

Result<SkyHarmonics> readSky(const std::filesystem::path& path) {
  const Result<Image> image = readExr(path);
  if (!image) return image.error();
  Result<SkyHarmonics> sky = skyHarmonics(image.value());
  if (!sky) return Error{path.string(), sky.error().place, sky.error().reason};
  return sky;
}

Result<std::filesystem::path> skyFile(const std::filesystem::path& folder, const std::string& skyImage) {
  Result<std::filesystem::path> file = resolveInside(folder, uriFromPath(skyImage));
  if (!file) return Error{(folder / skyImage).string(), "OVERCAST_lighting/sky/image", file.error().reason};
  return file;
}

glm::dvec3 meanRadiance(const SkyHarmonics& sky) {
  return kConstant * glm::dvec3(sky.coefficients[0]);
}

SkyHarmonics turned(const SkyHarmonics& sky, const glm::dmat3& localFromWorld) {
  SkyHarmonics result;
  for (int c = 0; c < 3; ++c) {
    // As a polynomial: the linear part g . w and the quadratic one w^T Q w, whose matrix has no trace.
    std::array<double, 9> l;
    for (std::size_t i = 0; i < 9; ++i) l[i] = static_cast<double>(sky.coefficients[i][c]);
    const glm::dvec3 gradient = localFromWorld * glm::dvec3(l[3], l[1], l[2]);
    const double xy = 0.5 * kMixed * l[4], yz = 0.5 * kMixed * l[5], xz = 0.5 * kMixed * l[7];
    const double zz = 2.0 * kPolar * l[6], difference = kDifference * l[8];
    const glm::dmat3 q(difference - 0.5 * zz, xy, xz, xy, -difference - 0.5 * zz, yz, xz, yz, zz);
    const glm::dmat3 r = localFromWorld * q * glm::transpose(localFromWorld);
    const std::array<double, 9> out{l[0],
                                    gradient.y,
                                    gradient.z,
                                    gradient.x,
                                    2.0 * r[0][1] / kMixed,
                                    2.0 * r[1][2] / kMixed,
                                    0.5 * r[2][2] / kPolar,
                                    2.0 * r[0][2] / kMixed,
                                    0.5 * (r[0][0] - r[1][1]) / kDifference};
    for (std::size_t i = 0; i < 9; ++i) result.coefficients[i][c] = static_cast<float>(out[i]);
  }
  return result;
}

SkyHarmonics tinted(const SkyHarmonics& sky, const glm::vec3& tint) {
  SkyHarmonics result = sky;
  for (glm::vec3& coefficient : result.coefficients) coefficient *= tint;
  return result;
}

}  // namespace overcast
