#include "runtime/report/as_printed.h"

#include <algorithm>
#include <cmath>

namespace overcast {
namespace {

/// The inverse of shared::skyVisibility over shared::easedExponent: C = exp(-e^2 / (e + 1/16)).
double exponentOf(double visibility) {
  const double m = -std::log(std::clamp(visibility, 1e-30, 1.0));
  return 0.5 * (m + std::sqrt(m * m + 0.25 * m));
}

struct Pair {
  double missing;
  double truth;
};

std::vector<Pair> pairsOf(const std::vector<Image>& missing, const std::vector<const Image*>& references,
                          const std::vector<const Mask*>& masks) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < missing.size(); ++i) {
    const auto sky = static_cast<std::size_t>(channelIndex(*references[i], "sky"));
    const std::size_t channels = references[i]->channels.size();
    for (std::size_t pixel = 0; pixel < masks[i]->size(); ++pixel)
      if ((*masks[i])[pixel] != 0) pairs.push_back({missing[i].pixels[pixel], references[i]->pixels[pixel * channels + sky]});
  }
  return pairs;
}

double squareError(const std::vector<Pair>& pairs, double darkening) {
  double sum = 0.0;
  for (const Pair& pair : pairs) {
    const double error = std::exp(-darkening * pair.missing) - pair.truth;
    sum += error * error;
  }
  return sum;
}

}  // namespace

Image missingShare(const Image& sky, float k, float alpha) {
  OVERCAST_REQUIRE(k > 0.0f && sky.channels.size() == 1, "k {} and {} channels", k, sky.channels.size());
  Image missing = sky;
  for (float& value : missing.pixels) value = static_cast<float>(std::max(exponentOf(value) / k - alpha, 0.0));
  return missing;
}

Image asPrinted(const Image& missing, double darkening) {
  Image sky = missing;
  for (float& value : sky.pixels) value = static_cast<float>(std::exp(-darkening * value));
  return sky;
}

double bestDarkening(const std::vector<Image>& missing, const std::vector<const Image*>& references,
                     const std::vector<const Mask*>& masks) {
  OVERCAST_REQUIRE(missing.size() == references.size() && missing.size() == masks.size(), "{} pictures, {} references, {} masks",
                   missing.size(), references.size(), masks.size());
  const std::vector<Pair> pairs = pairsOf(missing, references, masks);
  double best = 1.0, step = 2.0;
  for (double tried = 1.0 / 64.0; tried <= 64.0; tried *= step)
    if (squareError(pairs, tried) < squareError(pairs, best)) best = tried;
  while (step > 1.001) {
    step = std::sqrt(step);
    for (const double tried : {best / step, best * step})
      if (squareError(pairs, tried) < squareError(pairs, best)) best = tried;
  }
  return best;
}

}  // namespace overcast
