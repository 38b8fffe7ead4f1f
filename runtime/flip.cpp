#include "runtime/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "runtime/compared_channels.h"

namespace overcast {
namespace {

constexpr double kPi = std::numbers::pi;

/// A picture of three numbers per pixel, row 0 at the top.
struct Plane {
  int width = 0;
  int height = 0;
  std::vector<glm::dvec3> values;
};

// Linear sRGB to XYZ under D65, by the chromaticities of IEC 61966-2-1 as exact fractions; columns are R, G, B.
const glm::dmat3 kXyzFromRgb = {{10135552.0 / 24577794.0, 2613072.0 / 12288897.0, 1425312.0 / 73733382.0},
                                {8788810.0 / 24577794.0, 8788810.0 / 12288897.0, 8788810.0 / 73733382.0},
                                {4435075.0 / 24577794.0, 887015.0 / 12288897.0, 70074185.0 / 73733382.0}};
const glm::dmat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);
const glm::dvec3 kWhite = kXyzFromRgb * glm::dvec3(1.0);

/// Y, Cx, Cz: CIELAB without its cube root (section 4.1.1).
glm::dvec3 opponentFromRgb(const glm::dvec3& rgb) {
  const glm::dvec3 xyz = kXyzFromRgb * rgb / kWhite;
  return {116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z)};
}

glm::dvec3 rgbFromOpponent(const glm::dvec3& opponent) {
  const double y = (opponent.x + 16.0) / 116.0;
  return kRgbFromXyz * (kWhite * glm::dvec3(y + opponent.y / 500.0, y, y - opponent.z / 200.0));
}

double labCurve(double t) {
  constexpr double kDelta = 6.0 / 29.0;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
}

/// CIELAB, its chromatic axes shrunk where it is dark (Hunt effect, section 4.1.3).
glm::dvec3 huntLabFromRgb(const glm::dvec3& rgb) {
  const glm::dvec3 xyz = kXyzFromRgb * rgb / kWhite;
  const double x = labCurve(xyz.x), y = labCurve(xyz.y), z = labCurve(xyz.z);
  const double lightness = 116.0 * y - 16.0;
  return {lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)};
}

/// HyAB: city block between lightness and colour, Euclidean within colour.
double hyab(const glm::dvec3& a, const glm::dvec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

/// Weights of pixels -r .. r.
using Kernel = std::vector<double>;

template <class Weight>
Kernel kernel(int radius, const Weight& weight) {
  Kernel weights;
  for (int i = -radius; i <= radius; ++i) weights.push_back(weight(i));
  return weights;
}

double sum(const Kernel& weights) {
  double total = 0.0;
  for (const double weight : weights) total += weight;
  return total;
}

/// At (x, y) the sum over a line of pixels of weights[i] * value, channel by channel; the border is repeated. Along x, or along y.
Plane filtered(const Plane& plane, const std::array<const Kernel*, 3>& weights, bool alongX) {
  Plane result{plane.width, plane.height, std::vector<glm::dvec3>(plane.values.size())};
  const int radius = static_cast<int>(weights[0]->size() / 2), length = alongX ? plane.width : plane.height;
  const std::ptrdiff_t step = alongX ? 1 : plane.width;
  for (int y = 0; y < plane.height; ++y) {
    for (int x = 0; x < plane.width; ++x) {
      const int at = alongX ? x : y;
      const glm::dvec3* line = plane.values.data() + (alongX ? std::ptrdiff_t{y} * plane.width : x);
      glm::dvec3 total(0.0);
      for (int i = -radius; i <= radius; ++i) {
        const auto w = static_cast<std::size_t>(i + radius);
        total += glm::dvec3((*weights[0])[w], (*weights[1])[w], (*weights[2])[w]) * line[std::clamp(at + i, 0, length - 1) * step];
      }
      result.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(plane.width) + static_cast<std::size_t>(x)] = total;
    }
  }
  return result;
}

/// Contrast sensitivity of the eye (section 4.1.2, table 1): a Gaussian for Y and Cx, the sum of two for Cz. Each is separable.
struct SensitivityFilter {
  Kernel luminance;
  Kernel redGreen;
  std::array<Kernel, 2> blueYellow;
  std::array<double, 2> blueYellowShare;  ///< of each in the sum
};

SensitivityFilter sensitivityFilter(double pixelsPerDegree) {
  constexpr double kLuminance = 0.0047, kRedGreen = 0.0053, kBlueYellow[2] = {0.04, 0.025}, kAmplitude[2] = {34.1, 13.5};
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(kBlueYellow[0] / (2.0 * kPi * kPi)) * pixelsPerDegree));
  const auto gaussian = [&](double b) {
    return kernel(radius, [&](int i) { return std::exp(-kPi * kPi * i * i / (b * pixelsPerDegree * pixelsPerDegree)); });
  };
  const auto normalised = [](Kernel weights) {
    const double total = sum(weights);
    for (double& weight : weights) weight /= total;
    return weights;
  };
  SensitivityFilter filter{normalised(gaussian(kLuminance)), normalised(gaussian(kRedGreen)), {}, {}};
  for (std::size_t i = 0; i < 2; ++i) {
    const Kernel weights = gaussian(kBlueYellow[i]);
    filter.blueYellowShare[i] = kAmplitude[i] * std::sqrt(kPi / kBlueYellow[i]) * sum(weights) * sum(weights);
    filter.blueYellow[i] = normalised(weights);
  }
  const double total = filter.blueYellowShare[0] + filter.blueYellowShare[1];
  for (double& share : filter.blueYellowShare) share /= total;
  return filter;
}

/// The picture as the eye resolves it, in Hunt-adjusted CIELAB.
std::vector<glm::dvec3> perceived(const Plane& opponent, const SensitivityFilter& filter) {
  std::array<Plane, 2> passes;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::array<const Kernel*, 3> weights = {&filter.luminance, &filter.redGreen, &filter.blueYellow[i]};
    passes[i] = filtered(filtered(opponent, weights, true), weights, false);
  }
  std::vector<glm::dvec3> colours(opponent.values.size());
  for (std::size_t p = 0; p < colours.size(); ++p) {
    const glm::dvec3 &first = passes[0].values[p], &second = passes[1].values[p];
    const double blueYellow = filter.blueYellowShare[0] * first.z + filter.blueYellowShare[1] * second.z;
    colours[p] = huntLabFromRgb(glm::clamp(rgbFromOpponent({first.x, first.y, blueYellow}), 0.0, 1.0));
  }
  return colours;
}

/// Colour difference in [0, 1] (section 4.1.4): differences beyond 0.4 of the largest are crowded into its last twentieth.
double colourError(const glm::dvec3& a, const glm::dvec3& b) {
  constexpr double kExponent = 0.7, kShare = 0.4, kTarget = 0.95;
  static const double largest = std::pow(hyab(huntLabFromRgb({0.0, 1.0, 0.0}), huntLabFromRgb({0.0, 0.0, 1.0})), kExponent);
  const double error = std::pow(hyab(a, b), kExponent), knee = kShare * largest;
  return error < knee ? kTarget / knee * error : kTarget + (error - knee) / (largest - knee) * (1.0 - kTarget);
}

/// Strength of edges (x) and of points (y) at each pixel of the luminance in [0, 1] (section 4.2): responses to the first and second
/// derivative of a Gaussian in both directions, each with positive weights of sum 1 and negative ones of sum -1.
std::vector<glm::dvec2> features(const Plane& opponent, double pixelsPerDegree) {
  constexpr double kWidth = 0.082;  // degrees from the peak to the trough of the detector
  const double sigma = 0.5 * kWidth * pixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
  const Kernel bell = kernel(radius, [&](int i) { return std::exp(-0.5 * i * i / (sigma * sigma)); });
  const auto at = [&](int i) { return bell[static_cast<std::size_t>(i + radius)]; };
  const double bellSum = sum(bell);
  const Kernel smooth = kernel(radius, [&](int i) { return at(i) / bellSum; });
  const auto balanced = [](Kernel weights) {
    double positive = 0.0, negative = 0.0;
    for (const double weight : weights) (weight > 0.0 ? positive : negative) += std::abs(weight);
    for (double& weight : weights) weight /= weight > 0.0 ? positive : negative;
    return weights;
  };
  const Kernel edge = balanced(kernel(radius, [&](int i) { return -i * at(i); }));
  const Kernel point = balanced(kernel(radius, [&](int i) { return (i * i / (sigma * sigma) - 1.0) * at(i); }));
  Plane luminance{opponent.width, opponent.height, {}};
  for (const glm::dvec3& value : opponent.values) luminance.values.push_back(glm::dvec3((value.x + 16.0) / 116.0));
  const Plane across = filtered(filtered(luminance, {&edge, &point, &smooth}, true), {&smooth, &smooth, &smooth}, false);
  const Plane down = filtered(filtered(luminance, {&smooth, &smooth, &smooth}, true), {&edge, &point, &smooth}, false);
  std::vector<glm::dvec2> found;
  for (std::size_t p = 0; p < across.values.size(); ++p)
    found.emplace_back(std::hypot(across.values[p].x, down.values[p].x), std::hypot(across.values[p].y, down.values[p].y));
  return found;
}

/// A side of the comparison in Y, Cx, Cz.
template <class Value>
Plane opponentPlane(const Comparison& comparison, const Value& value) {
  Plane plane{comparison.reference.width, comparison.reference.height, {}};
  const std::size_t last = comparison.channels.size() - 1;
  for (std::size_t pixel = 0; pixel < comparison.mask.size(); ++pixel) {
    const glm::dvec3 rgb(value(pixel, 0), value(pixel, last / 2), value(pixel, last));
    plane.values.push_back(opponentFromRgb(glm::clamp(rgb, 0.0, 1.0)));
  }
  return plane;
}

}  // namespace

Result<FlipMap> flip(const Comparison& comparison, double pixelsPerDegree) {
  OVERCAST_REQUIRE(comparison.channels.size() == 1 || comparison.channels.size() == 3, "{} channels", comparison.channels.size());
  OVERCAST_REQUIRE(pixelsPerDegree >= 1.0 && pixelsPerDegree <= 1000.0, "{} pixels per degree", pixelsPerDegree);
  const auto found = comparedChannels(comparison);
  if (!found) return found.error();
  const ComparedChannels& compared = found.value();
  const auto ofReference = [&](std::size_t pixel, std::size_t c) {
    const float value = referenceValue(compared, comparison, pixel, c);
    return std::isfinite(value) ? value : 0.0f;
  };
  const auto ofPicture = [&](std::size_t pixel, std::size_t c) {
    return comparison.mask[pixel] ? pictureValue(compared, comparison, pixel, c) : ofReference(pixel, c);
  };
  const Plane reference = opponentPlane(comparison, ofReference), picture = opponentPlane(comparison, ofPicture);
  const SensitivityFilter filter = sensitivityFilter(pixelsPerDegree);
  const auto referenceColours = perceived(reference, filter), pictureColours = perceived(picture, filter);
  const auto referenceFeatures = features(reference, pixelsPerDegree), pictureFeatures = features(picture, pixelsPerDegree);
  FlipMap map;
  double total = 0.0;
  std::size_t count = 0;
  for (std::size_t p = 0; p < comparison.mask.size(); ++p) {
    map.errors.push_back(0.0f);
    if (!comparison.mask[p]) continue;
    const glm::dvec2 change = glm::abs(referenceFeatures[p] - pictureFeatures[p]);
    const double featureError = std::sqrt(std::max(change.x, change.y) / std::numbers::sqrt2);
    // Section 4.3. Rounding may take the error of colour a little out of [0, 1], and that of features above 1.
    const double error =
        std::pow(std::clamp(colourError(referenceColours[p], pictureColours[p]), 0.0, 1.0), 1.0 - std::min(featureError, 1.0));
    map.errors.back() = static_cast<float>(error);
    total += error;
    ++count;
  }
  map.mean = total / static_cast<double>(count);
  return map;
}

Image flipPicture(const FlipMap& map, int width) {
  OVERCAST_REQUIRE(width > 0 && map.errors.size() % static_cast<std::size_t>(width) == 0, "{} pixels in rows of {}", map.errors.size(),
                   width);
  Image image{width, static_cast<int>(map.errors.size()) / width, {"R", "G", "B"}, {}};
  for (const float error : map.errors) image.pixels.insert(image.pixels.end(), 3, error);
  return image;
}

}  // namespace overcast
