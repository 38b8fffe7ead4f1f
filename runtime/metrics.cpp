#include "runtime/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "runtime/compared_channels.h"

namespace overcast {
namespace {

constexpr int kRadius = 5;  // 11 x 11 pixels
constexpr double kSigma = 1.5;

/// Calls visit(picture, reference) for every value that counts, pixel by pixel and within these channel by channel.
template <class Visit>
void forValues(const ComparedChannels& compared, const Comparison& comparison, const Visit& visit) {
  for (std::size_t pixel = 0; pixel < comparison.mask.size(); ++pixel)
    if (comparison.mask[pixel])
      for (std::size_t c = 0; c < compared.inPicture.size(); ++c)
        visit(pictureValue(compared, comparison, pixel, c), referenceValue(compared, comparison, pixel, c));
}

/// The smallest of `values` that a share of them does not exceed.
double quantile(std::vector<double>& values, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

// Weighted sums over a window: 1, x, y, x^2, y^2, xy.
using Moments = std::array<double, 6>;

std::array<double, 2 * kRadius + 1> windowWeights() {
  std::array<double, 2 * kRadius + 1> weights{};
  for (int i = -kRadius; i <= kRadius; ++i) weights[static_cast<std::size_t>(i + kRadius)] = std::exp(-0.5 * i * i / (kSigma * kSigma));
  return weights;
}

/// Sums `values` along a row (step 1) or a column (step = width) of length `length`; what lies beyond its ends has no weight.
void blurLine(const Moments* values, Moments* sums, int length, std::ptrdiff_t step) {
  static const auto weights = windowWeights();
  for (int i = 0; i < length; ++i) {
    Moments sum{};
    for (int j = std::max(i - kRadius, 0); j <= std::min(i + kRadius, length - 1); ++j)
      for (std::size_t m = 0; m < sum.size(); ++m) sum[m] += weights[static_cast<std::size_t>(j - i + kRadius)] * values[j * step][m];
    sums[i * step] = sum;
  }
}

/// SSIM at a pixel, Wang et al. 2004, eq. 13.
double similarity(const Moments& sums, double range) {
  const double c1 = 0.01 * 0.01 * range * range, c2 = 0.03 * 0.03 * range * range;
  const double x = sums[1] / sums[0], y = sums[2] / sums[0];
  const double varianceX = sums[3] / sums[0] - x * x, varianceY = sums[4] / sums[0] - y * y, covariance = sums[5] / sums[0] - x * y;
  return (2.0 * x * y + c1) * (2.0 * covariance + c2) / ((x * x + y * y + c1) * (varianceX + varianceY + c2));
}

/// Sum of SSIM over the pixels that count, of one channel.
double similaritySum(const ComparedChannels& compared, const Comparison& comparison, std::size_t channel, double range) {
  const int width = comparison.reference.width, height = comparison.reference.height;
  std::vector<Moments> moments(comparison.mask.size()), sums(comparison.mask.size());
  for (std::size_t pixel = 0; pixel < moments.size(); ++pixel) {
    if (!comparison.mask[pixel]) continue;
    const double x = pictureValue(compared, comparison, pixel, channel), y = referenceValue(compared, comparison, pixel, channel);
    moments[pixel] = {1.0, x, y, x * x, y * y, x * y};
  }
  for (int y = 0; y < height; ++y) blurLine(moments.data() + std::ptrdiff_t{y} * width, sums.data() + std::ptrdiff_t{y} * width, width, 1);
  for (int x = 0; x < width; ++x) blurLine(sums.data() + x, moments.data() + x, height, width);
  double sum = 0.0;
  for (std::size_t pixel = 0; pixel < moments.size(); ++pixel)
    if (comparison.mask[pixel]) sum += similarity(moments[pixel], range);
  return sum;
}

/// picture - reference of every value that counts.
Result<std::vector<double>> differences(const Comparison& comparison) {
  const auto compared = comparedChannels(comparison);
  if (!compared) return compared.error();
  std::vector<double> errors;
  forValues(compared.value(), comparison, [&](double picture, double reference) { errors.push_back(picture - reference); });
  return errors;
}

double meanProduct(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum / static_cast<double>(a.size());
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

Mask surfaceMask(const Image& reference) {
  const auto pixels = static_cast<std::size_t>(reference.width) * static_cast<std::size_t>(reference.height);
  Mask mask(pixels, 1);
  const int depth = channelIndex(reference, "depth");
  if (depth < 0) return mask;
  const std::size_t stride = reference.channels.size();
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    mask[pixel] = reference.pixels[pixel * stride + static_cast<std::size_t>(depth)] >= 0;
  return mask;
}

Result<ErrorMetrics> errorMetrics(const Comparison& comparison) {
  Result<std::vector<double>> found = differences(comparison);
  if (!found) return found.error();
  std::vector<double>& errors = found.value();
  ErrorMetrics metrics;
  metrics.pixels = errors.size() / comparison.channels.size();
  metrics.rmse = std::sqrt(meanProduct(errors, errors));
  metrics.bias = mean(errors);
  for (double& error : errors) error = std::abs(error);
  metrics.mae = mean(errors);
  metrics.p95 = quantile(errors, 0.95);
  metrics.p99 = quantile(errors, 0.99);
  metrics.max = *std::max_element(errors.begin(), errors.end());
  return metrics;
}

Result<double> structuralSimilarity(const Comparison& comparison, double range) {
  OVERCAST_REQUIRE(range > 0.0, "a range of {}", range);
  const auto compared = comparedChannels(comparison);
  if (!compared) return compared.error();
  double sum = 0.0;
  for (std::size_t c = 0; c < comparison.channels.size(); ++c) sum += similaritySum(compared.value(), comparison, c, range);
  const auto pixels = std::count_if(comparison.mask.begin(), comparison.mask.end(), [](std::uint8_t counts) { return counts != 0; });
  return sum / (static_cast<double>(pixels) * static_cast<double>(comparison.channels.size()));
}

Result<Done> addFrame(Flicker& flicker, const Comparison& frame) {
  const auto compared = comparedChannels(frame);
  if (!compared) return compared.error();
  const std::size_t channels = frame.channels.size();
  std::vector<float> errors(frame.mask.size() * channels, 0.0f);
  const bool first = flicker.lastMask.empty();
  if (!first && (flicker.lastMask.size() != frame.mask.size() || flicker.lastErrors.size() != errors.size()))
    return Error{"", "", "a frame of another size or with other channels than the one before"};
  for (std::size_t pixel = 0; pixel < frame.mask.size(); ++pixel) {
    if (!frame.mask[pixel]) continue;
    for (std::size_t c = 0; c < channels; ++c) {
      const std::size_t i = pixel * channels + c;
      errors[i] = static_cast<float>(pictureValue(compared.value(), frame, pixel, c) - referenceValue(compared.value(), frame, pixel, c));
      if (first || !flicker.lastMask[pixel]) continue;
      const double change = double{errors[i]} - double{flicker.lastErrors[i]};
      flicker.squares += change * change;
      flicker.largest = std::max(flicker.largest, std::abs(change));
      ++flicker.count;
    }
  }
  flicker.lastErrors = std::move(errors);
  flicker.lastMask = frame.mask;
  return Done{};
}

double flickerRms(const Flicker& flicker) {
  return flicker.count == 0 ? 0.0 : std::sqrt(flicker.squares / static_cast<double>(flicker.count));
}

Result<std::vector<ErrorStep>> splitError(std::span<const Image* const> chain, std::span<const std::string> channels, const Mask& mask) {
  OVERCAST_REQUIRE(chain.size() >= 2, "a chain of {} images", chain.size());
  const auto whole = differences({*chain.back(), *chain.front(), channels, mask});
  if (!whole) return whole.error();
  const double squares = meanProduct(whole.value(), whole.value());
  std::vector<ErrorStep> steps;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    const auto step = differences({*chain[i], *chain[i - 1], channels, mask});
    if (!step) return step.error();
    steps.push_back({std::sqrt(meanProduct(step.value(), step.value())), mean(step.value()),
                     squares > 0.0 ? meanProduct(step.value(), whole.value()) / squares : 0.0});
  }
  return steps;
}

}  // namespace overcast
