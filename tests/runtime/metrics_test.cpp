// Metrics: closed forms, and SSIM against sums over its windows as the paper writes them.
#include "runtime/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace overcast {
namespace {

using testing::HasSubstr;
const std::vector<std::string> kSky = {"sky"}, kColour = {"R", "G", "B"};

Image filled(int width, int height, const std::vector<std::string>& channels, float value) {
  return {width, height, channels,
          std::vector<float>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * channels.size(), value)};
}

Image noise(int width, int height, const std::vector<std::string>& channels, unsigned seed) {
  std::mt19937 random(seed);
  Image image = filled(width, height, channels, 0.0f);
  for (float& value : image.pixels) value = static_cast<float>(random() >> 8) / static_cast<float>(1 << 24);
  return image;
}

Mask everywhere(const Image& image) {
  return Mask(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 1);
}

Mask randomMask(const Image& image, unsigned seed) {
  std::mt19937 random(seed);
  Mask mask = everywhere(image);
  for (auto& counts : mask) counts = random() % 3 != 0;
  return mask;
}

ErrorMetrics metricsOf(const Image& picture, const Image& reference, const std::vector<std::string>& channels, const Mask& mask) {
  const auto metrics = errorMetrics({picture, reference, channels, mask});
  EXPECT_TRUE(metrics.ok()) << message(metrics.error());
  return metrics.value();
}

TEST(Metrics, OfAConstantErrorAreThatError) {
  const Image reference = filled(7, 5, kColour, 0.25f), picture = filled(7, 5, kColour, 0.125f);
  const ErrorMetrics metrics = metricsOf(picture, reference, kColour, everywhere(reference));
  EXPECT_EQ(metrics.pixels, 35u);
  EXPECT_DOUBLE_EQ(metrics.bias, -0.125);
  for (const double value : {metrics.rmse, metrics.mae, metrics.p95, metrics.p99, metrics.max}) EXPECT_DOUBLE_EQ(value, 0.125);
}

TEST(Metrics, OfARampHaveClosedForms) {
  constexpr int kCount = 200;  // errors -100 .. -1, 1 .. 100, in sixteenths
  const Image reference = filled(20, 10, kSky, 1.0f);
  Image picture = reference;
  for (int i = 0; i < kCount; ++i)
    picture.pixels[static_cast<std::size_t>(i * 37 % kCount)] += static_cast<float>(i < 100 ? i - 100 : i - 99) / 16.0f;
  const ErrorMetrics metrics = metricsOf(picture, reference, kSky, everywhere(reference));
  EXPECT_NEAR(metrics.bias, 0.0, 1e-12);
  EXPECT_NEAR(metrics.mae, 50.5 / 16.0, 1e-12);
  EXPECT_NEAR(metrics.rmse, std::sqrt(101.0 * 201.0 / 6.0) / 16.0, 1e-12) << "mean of squares up to n: (n + 1)(2 n + 1) / 6";
  EXPECT_DOUBLE_EQ(metrics.p95, 95.0 / 16.0);
  EXPECT_DOUBLE_EQ(metrics.p99, 99.0 / 16.0);
  EXPECT_DOUBLE_EQ(metrics.max, 100.0 / 16.0);
}

TEST(Metrics, SeeNothingOfWhatDoesNotCount) {
  Image reference = noise(16, 9, kSky, 1), picture = noise(16, 9, kSky, 2);
  const Mask mask = randomMask(reference, 3);
  const ErrorMetrics before = metricsOf(picture, reference, kSky, mask);
  const double similarity = structuralSimilarity({picture, reference, kSky, mask}).value();
  for (std::size_t p = 0; p < mask.size(); ++p)
    if (!mask[p]) picture.pixels[p] = p % 2 ? std::numeric_limits<float>::quiet_NaN() : 1e30f;
  const ErrorMetrics after = metricsOf(picture, reference, kSky, mask);
  EXPECT_EQ(after.pixels, static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 1)));
  EXPECT_EQ(after.rmse, before.rmse);
  EXPECT_EQ(after.max, before.max);
  EXPECT_EQ(structuralSimilarity({picture, reference, kSky, mask}).value(), similarity);
}

TEST(Metrics, FindChannelsByName) {
  Image picture = filled(4, 4, {"B", "sky", "R"}, 0.0f);
  for (std::size_t i = 1; i < picture.pixels.size(); i += 3) picture.pixels[i] = 0.5f;
  const Image reference = filled(4, 4, {"depth", "sky"}, 0.25f);
  EXPECT_DOUBLE_EQ(metricsOf(picture, reference, kSky, everywhere(reference)).bias, 0.25);
}

TEST(Metrics, SurfacesAreWhereTheReferenceHasDepth) {
  Image reference = filled(3, 1, {"depth", "sky"}, 1.0f);
  reference.pixels[2] = -1.0f;
  reference.pixels[4] = 0.0f;
  EXPECT_EQ(surfaceMask(reference), (Mask{1, 0, 1}));
  EXPECT_EQ(surfaceMask(filled(2, 2, kSky, -1.0f)), (Mask{1, 1, 1, 1}));
}

TEST(Metrics, SayWhyTwoImagesCannotBeCompared) {
  const Image reference = filled(4, 3, kSky, 0.0f);
  const Mask mask = everywhere(reference);
  const auto reason = [&](const Image& picture, const Mask& counts, const std::vector<std::string>& channels = kSky) {
    const auto metrics = errorMetrics({picture, reference, channels, counts});
    return metrics ? std::string("none") : message(metrics.error());
  };
  EXPECT_THAT(reason(filled(3, 4, kSky, 0.0f), mask), HasSubstr("the picture is 3x4, the reference 4x3"));
  EXPECT_THAT(reason(filled(4, 3, {"R"}, 0.0f), mask), HasSubstr("the picture has no channel sky"));
  EXPECT_THAT(reason(filled(4, 3, {"sky", "R"}, 0.0f), mask, {"R"}), HasSubstr("the reference has no channel R"));
  EXPECT_THAT(reason(reference, Mask(12, 0)), HasSubstr("no pixel shows a surface"));
  Image broken = reference;
  broken.pixels[6] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(reason(broken, mask), HasSubstr("the picture is not finite at pixel (2, 1), channel sky"));
}

TEST(Similarity, OfAPictureWithItselfIsOne) {
  const Image image = noise(30, 20, kColour, 4);
  EXPECT_DOUBLE_EQ(structuralSimilarity({image, image, kColour, randomMask(image, 5)}).value(), 1.0);
}

TEST(Similarity, OfFlatPicturesIsThatOfTheirMeans) {
  const Image a = filled(20, 14, kSky, 0.75f), b = filled(20, 14, kSky, 0.25f);
  const double c1 = 1e-4, expected = (2.0 * 0.75 * 0.25 + c1) / (0.75 * 0.75 + 0.25 * 0.25 + c1);
  EXPECT_NEAR(structuralSimilarity({a, b, kSky, randomMask(a, 6)}).value(), expected, 1e-9);
}

// SSIM at every pixel that counts, as the sums over its window are written.
double directSimilarity(const Image& a, const Image& b, const Mask& mask, double range) {
  double total = 0.0;
  int count = 0;
  const auto pixel = [&](int x, int y) { return static_cast<std::size_t>(y * a.width + x); };
  for (int py = 0; py < a.height; ++py) {
    for (int px = 0; px < a.width; ++px) {
      if (!mask[pixel(px, py)]) continue;
      double weight = 0.0, meanA = 0.0, meanB = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
      const auto forWindow = [&](const auto& visit) {
        for (int y = std::max(py - 5, 0); y <= std::min(py + 5, a.height - 1); ++y)
          for (int x = std::max(px - 5, 0); x <= std::min(px + 5, a.width - 1); ++x)
            if (mask[pixel(x, y)])
              visit(std::exp(-((x - px) * (x - px) + (y - py) * (y - py)) / 4.5), double{a.pixels[pixel(x, y)]},
                    double{b.pixels[pixel(x, y)]});
      };
      forWindow([&](double w, double va, double vb) { weight += w, meanA += w * va, meanB += w * vb; });
      meanA /= weight;
      meanB /= weight;
      forWindow([&](double w, double va, double vb) {
        aa += w / weight * (va - meanA) * (va - meanA);
        bb += w / weight * (vb - meanB) * (vb - meanB);
        ab += w / weight * (va - meanA) * (vb - meanB);
      });
      const double c1 = 1e-4 * range * range, c2 = 9e-4 * range * range;
      total += (2 * meanA * meanB + c1) / (meanA * meanA + meanB * meanB + c1) * (2 * ab + c2) / (aa + bb + c2);
      ++count;
    }
  }
  return total / count;
}

TEST(Similarity, EqualsDirectSums) {
  for (const unsigned seed : {7u, 8u, 9u}) {
    const Image a = noise(23, 17, kSky, seed);
    Image b = noise(23, 17, kSky, seed + 100);
    for (std::size_t i = 0; i < b.pixels.size(); ++i) b.pixels[i] = 0.7f * a.pixels[i] + 0.3f * b.pixels[i];
    for (const Mask& mask : {everywhere(a), randomMask(a, seed)})
      for (const double range : {1.0, 4.0})
        EXPECT_NEAR(structuralSimilarity({a, b, kSky, mask}, range).value(), directSimilarity(a, b, mask, range), 1e-10) << seed;
  }
}

TEST(Similarity, OfThreeChannelsIsTheirMean) {
  const Image a = noise(15, 15, kColour, 10), b = noise(15, 15, kColour, 11);
  const Mask mask = randomMask(a, 12);
  double sum = 0.0;
  for (const std::string& channel : kColour) {
    const std::vector<std::string> one = {channel};
    sum += structuralSimilarity({a, b, one, mask}).value();
  }
  EXPECT_NEAR(structuralSimilarity({a, b, kColour, mask}).value(), sum / 3.0, 1e-12);
}

TEST(FlickerOfAClip, IsNothingForASteadyErrorHoweverLarge) {
  Flicker flicker;
  const Image error = noise(8, 8, kColour, 13);
  for (unsigned frame = 0; frame < 4; ++frame) {
    Image reference = filled(8, 8, kColour, static_cast<float>(frame)), picture = reference;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] += error.pixels[i];
    ASSERT_TRUE(addFrame(flicker, {picture, reference, kColour, everywhere(reference)}));
  }
  EXPECT_EQ(flicker.count, 3u * 64u * 3u);
  EXPECT_LT(flickerRms(flicker), 1e-6) << "only the rounding of the pictures";
}

TEST(FlickerOfAClip, OfAnErrorThatAlternatesIsTwiceThatError) {
  Flicker flicker;
  const Image reference = filled(5, 4, kSky, 0.5f);
  for (int frame = 0; frame < 5; ++frame) {
    const Image picture = filled(5, 4, kSky, frame % 2 ? 0.75f : 0.25f);
    ASSERT_TRUE(addFrame(flicker, {picture, reference, kSky, everywhere(reference)}));
    EXPECT_EQ(flickerRms(flicker), frame == 0 ? 0.0 : 0.5);
  }
  EXPECT_DOUBLE_EQ(flicker.largest, 0.5);
}

TEST(FlickerOfAClip, CountsWhatIsSeenInBothFramesOnly) {
  Flicker flicker;
  const Image reference = filled(4, 1, kSky, 0.0f);
  Image first = reference, second = reference;
  first.pixels = {0.0f, 0.5f, 9.0f, 9.0f};
  second.pixels = {0.25f, 0.0f, -9.0f, -9.0f};
  ASSERT_TRUE(addFrame(flicker, {first, reference, kSky, {1, 1, 1, 0}}));
  ASSERT_TRUE(addFrame(flicker, {second, reference, kSky, {1, 1, 0, 1}}));
  EXPECT_EQ(flicker.count, 2u);
  EXPECT_DOUBLE_EQ(flickerRms(flicker), std::sqrt((0.0625 + 0.25) / 2.0));
}

TEST(FlickerOfAClip, RefusesFramesThatDoNotFit) {
  Flicker flicker;
  const Image small = filled(4, 4, kSky, 0.0f), large = filled(5, 4, kSky, 0.0f);
  ASSERT_TRUE(addFrame(flicker, {small, small, kSky, everywhere(small)}));
  const auto added = addFrame(flicker, {large, large, kSky, everywhere(large)});
  ASSERT_FALSE(added);
  EXPECT_THAT(message(added.error()), HasSubstr("another size"));
  EXPECT_EQ(flicker.lastMask.size(), 16u);
}

TEST(SplitError, StepsSumToTheWhole) {
  const Image truth = noise(12, 12, kColour, 20);
  std::vector<Image> made(3, truth);
  const std::vector<Image> changes = {noise(12, 12, kColour, 21), noise(12, 12, kColour, 22), noise(12, 12, kColour, 23)};
  for (std::size_t i = 0; i < made.size(); ++i)
    for (std::size_t j = i; j < made.size(); ++j)
      for (std::size_t v = 0; v < truth.pixels.size(); ++v) made[j].pixels[v] += static_cast<float>(i + 1) * (changes[i].pixels[v] - 0.6f);
  const Mask mask = randomMask(truth, 24);
  const auto steps = splitError(std::vector<const Image*>{&truth, &made[0], &made[1], &made[2]}, kColour, mask).value();
  ASSERT_EQ(steps.size(), 3u);
  const ErrorMetrics whole = metricsOf(made[2], truth, kColour, mask);
  EXPECT_NEAR(steps[0].bias + steps[1].bias + steps[2].bias, whole.bias, 1e-9);
  EXPECT_NEAR(steps[0].share + steps[1].share + steps[2].share, 1.0, 1e-9);
  EXPECT_NEAR(steps[0].rms, metricsOf(made[0], truth, kColour, mask).rmse, 1e-12);
  EXPECT_NEAR(steps[2].rms, metricsOf(made[2], made[1], kColour, mask).rmse, 1e-12);
}

TEST(SplitError, OfIndependentStepsIsByTheirSquares) {
  // Signs of a Hadamard matrix: the steps are orthogonal, so a share is a step's squares over those of all.
  const Image truth = filled(4, 1, kSky, 0.0f);
  Image first = truth, second = truth;
  first.pixels = {0.25f, 0.25f, -0.25f, -0.25f};
  second.pixels = {0.75f, -0.25f, 0.25f, -0.75f};  // adds 0.5 of + - + -
  const auto steps = splitError(std::vector<const Image*>{&truth, &first, &second}, kSky, everywhere(truth)).value();
  EXPECT_DOUBLE_EQ(steps[0].rms, 0.25);
  EXPECT_DOUBLE_EQ(steps[1].rms, 0.5);
  EXPECT_DOUBLE_EQ(steps[0].share, 0.2);
  EXPECT_DOUBLE_EQ(steps[1].share, 0.8);
}

TEST(SplitError, AStepThatMakesGoodHasANegativeShare) {
  const Image truth = filled(3, 3, kSky, 0.0f), far = filled(3, 3, kSky, 1.0f), near = filled(3, 3, kSky, 0.5f);
  const auto steps = splitError(std::vector<const Image*>{&truth, &far, &near}, kSky, everywhere(truth)).value();
  EXPECT_DOUBLE_EQ(steps[0].share, 2.0);
  EXPECT_DOUBLE_EQ(steps[1].share, -1.0);
  const auto none = splitError(std::vector<const Image*>{&truth, &far, &truth}, kSky, everywhere(truth)).value();
  EXPECT_EQ(none[0].share, 0.0);
  EXPECT_EQ(none[1].rms, 1.0);
}

}  // namespace
}  // namespace overcast
