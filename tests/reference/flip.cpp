#include "tests/reference/flip.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>

namespace overcast::reference {
namespace {

using Grey = std::vector<double>;
const double pi = std::acos(-1.0);

// Linear sRGB to XYZ and the white of D65, to seven digits.
constexpr double kXyz[3][3] = {{0.4123866, 0.3575915, 0.1804505}, {0.2126368, 0.7151830, 0.0721802}, {0.0193306, 0.1191972, 0.9503726}};
constexpr double kWhite[3] = {0.9504286, 1.0, 1.0889004};

Rgb xyzOf(const Rgb& rgb) {
  Rgb xyz{};
  for (std::size_t i = 0; i < 3; ++i) xyz[i] = (kXyz[i][0] * rgb[0] + kXyz[i][1] * rgb[1] + kXyz[i][2] * rgb[2]) / kWhite[i];
  return xyz;
}

// Cramer's rule for the matrix above.
Rgb rgbOf(const Rgb& relative) {
  const double b[3] = {relative[0] * kWhite[0], relative[1] * kWhite[1], relative[2] * kWhite[2]};
  const auto determinant = [](const double m[3][3]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  };
  const double whole = determinant(kXyz);
  Rgb rgb{};
  for (std::size_t c = 0; c < 3; ++c) {
    double m[3][3];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) m[i][j] = j == c ? b[i] : kXyz[i][j];
    rgb[c] = determinant(m) / whole;
  }
  return rgb;
}

double root(double t) {
  return t > 216.0 / 24389.0 ? std::pow(t, 1.0 / 3.0) : (24389.0 / 27.0 * t + 16.0) / 116.0;
}

Rgb huntLab(const Rgb& rgb) {
  const Rgb xyz = xyzOf(rgb);
  const double l = 116.0 * root(xyz[1]) - 16.0;
  return {l, 0.01 * l * 500.0 * (root(xyz[0]) - root(xyz[1])), 0.01 * l * 200.0 * (root(xyz[1]) - root(xyz[2]))};
}

double hyab(const Rgb& a, const Rgb& b) {
  return std::abs(a[0] - b[0]) + std::sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/// A filter of (2 radius + 1)^2 weights: weight(dx, dy).
Grey filterOf(int radius, const std::function<double(double, double)>& weight) {
  Grey filter;
  for (int dy = -radius; dy <= radius; ++dy)
    for (int dx = -radius; dx <= radius; ++dx) filter.push_back(weight(dx, dy));
  return filter;
}

/// Positive weights sum to 1, negative ones to -1.
Grey normalised(Grey filter) {
  double positive = 0.0, negative = 0.0;
  for (const double w : filter) (w > 0.0 ? positive : negative) += w;
  for (double& w : filter) w = w > 0.0 ? w / positive : w < 0.0 ? -w / negative : 0.0;
  return filter;
}

Grey apply(const Grey& image, const Grey& filter, int radius, int width, int height) {
  Grey result;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double total = 0.0;
      std::size_t i = 0;
      for (int dy = -radius; dy <= radius; ++dy)
        for (int dx = -radius; dx <= radius; ++dx)
          total +=
              filter[i++] * image[static_cast<std::size_t>(std::clamp(y + dy, 0, height - 1) * width + std::clamp(x + dx, 0, width - 1))];
      result.push_back(total);
    }
  }
  return result;
}

struct Side {
  std::vector<Rgb> colours;
  Grey edges;
  Grey points;
};

Side see(const std::vector<Rgb>& picture, int width, int height, double ppd) {
  Grey planes[3];
  for (const Rgb& rgb : picture) {
    const Rgb xyz = xyzOf(rgb);
    planes[0].push_back(116.0 * xyz[1] - 16.0);
    planes[1].push_back(500.0 * (xyz[0] - xyz[1]));
    planes[2].push_back(200.0 * (xyz[1] - xyz[2]));
  }
  // Table 1 of the paper: a1, b1, a2, b2 of Y, Cx, Cz; g(x) = a1 sqrt(pi / b1) exp(-pi^2 x^2 / b1) + the same with a2, b2, x in degrees.
  const double table[3][4] = {{1.0, 0.0047, 0.0, 1e-5}, {1.0, 0.0053, 0.0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * pi * pi)) * ppd));
  Grey blurred[3];
  for (int c = 0; c < 3; ++c) {
    const double* t = table[c];
    const Grey filter = normalised(filterOf(radius, [&](double dx, double dy) {
      const double z = (dx * dx + dy * dy) / (ppd * ppd);
      return t[0] * std::sqrt(pi / t[1]) * std::exp(-pi * pi * z / t[1]) + t[2] * std::sqrt(pi / t[3]) * std::exp(-pi * pi * z / t[3]);
    }));
    blurred[c] = apply(planes[c], filter, radius, width, height);
  }
  Side side;
  for (std::size_t p = 0; p < picture.size(); ++p) {
    const double y = (blurred[0][p] + 16.0) / 116.0;
    Rgb rgb = rgbOf({y + blurred[1][p] / 500.0, y, y - blurred[2][p] / 200.0});
    for (double& channel : rgb) channel = std::min(std::max(channel, 0.0), 1.0);
    side.colours.push_back(huntLab(rgb));
  }
  Grey luminance;
  for (const double y : planes[0]) luminance.push_back((y + 16.0) / 116.0);
  const double sigma = 0.5 * 0.082 * ppd;
  const int reach = static_cast<int>(std::ceil(3.0 * sigma));
  const auto bell = [&](double dx, double dy) { return std::exp(-(dx * dx + dy * dy) / (2.0 * sigma * sigma)); };
  const auto strength = [&](const std::function<double(double, double)>& alongX) {
    const Grey h = apply(luminance, normalised(filterOf(reach, alongX)), reach, width, height);
    const Grey v =
        apply(luminance, normalised(filterOf(reach, [&](double dx, double dy) { return alongX(dy, dx); })), reach, width, height);
    Grey both;
    for (std::size_t p = 0; p < h.size(); ++p) both.push_back(std::sqrt(h[p] * h[p] + v[p] * v[p]));
    return both;
  };
  side.edges = strength([&](double dx, double dy) { return -dx * bell(dx, dy); });
  side.points = strength([&](double dx, double dy) { return (dx * dx / (sigma * sigma) - 1.0) * bell(dx, dy); });
  return side;
}

}  // namespace

std::vector<double> flip(const std::vector<Rgb>& reference, const std::vector<Rgb>& test, int width, int height, double pixelsPerDegree) {
  const Side a = see(reference, width, height, pixelsPerDegree), b = see(test, width, height, pixelsPerDegree);
  const double largest = std::pow(hyab(huntLab({0, 1, 0}), huntLab({0, 0, 1})), 0.7);
  std::vector<double> errors;
  for (std::size_t p = 0; p < reference.size(); ++p) {
    const double colour = std::pow(hyab(a.colours[p], b.colours[p]), 0.7);
    const double spread =
        colour < 0.4 * largest ? 0.95 * colour / (0.4 * largest) : 0.95 + 0.05 * (colour - 0.4 * largest) / (0.6 * largest);
    const double feature = std::max(std::abs(a.edges[p] - b.edges[p]), std::abs(a.points[p] - b.points[p]));
    errors.push_back(std::pow(spread, 1.0 - std::sqrt(feature / std::sqrt(2.0))));
  }
  return errors;
}

}  // namespace overcast::reference
