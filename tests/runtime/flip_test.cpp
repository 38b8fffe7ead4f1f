// FLIP: closed forms from published CIELAB coordinates, direct two-dimensional sums in double, and what must not change it.
#include "runtime/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "tests/reference/flip.h"

namespace overcast {
namespace {

const std::vector<std::string> kColour = {"R", "G", "B"}, kSky = {"sky"};
using Colour = std::array<float, 3>;

Image flat(int width, int height, const Colour& colour) {
  Image image{width, height, kColour, {}};
  for (int i = 0; i < width * height; ++i) image.pixels.insert(image.pixels.end(), colour.begin(), colour.end());
  return image;
}

Mask everywhere(const Image& image) {
  return Mask(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height), 1);
}

FlipMap flipOf(const Image& picture, const Image& reference, double pixelsPerDegree = kFlipPixelsPerDegree) {
  const auto map = flip({picture, reference, kColour, everywhere(reference)}, pixelsPerDegree);
  EXPECT_TRUE(map.ok()) << message(map.error());
  return map.value();
}

// A picture with what detectors look for: smooth colour, an edge, points, a little noise.
Image scene(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  const auto share = [&] { return static_cast<float>(random() >> 8) / static_cast<float>(1 << 24); };
  Image image = flat(width, height, {share(), share(), share()});
  const float slope = 2.0f * share() - 1.0f, level = share();
  const Colour other = {share(), share(), share()};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float* pixel = &image.pixels[static_cast<std::size_t>(y * width + x) * 3];
      const bool beyond = static_cast<float>(y) > level * static_cast<float>(height) + slope * static_cast<float>(x - width / 2);
      const bool point = random() % 40 == 0;
      for (std::size_t c = 0; c < 3; ++c) {
        if (beyond) pixel[c] = other[c] * static_cast<float>(x) / static_cast<float>(width);
        pixel[c] = point ? 1.0f - pixel[c] : std::clamp(pixel[c] + 0.1f * (share() - 0.5f), 0.0f, 1.0f);
      }
    }
  }
  return image;
}

std::vector<reference::Rgb> pixelsOf(const Image& image) {
  std::vector<reference::Rgb> pixels;
  for (std::size_t i = 0; i < image.pixels.size(); i += 3) pixels.push_back({image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]});
  return pixels;
}

// CIELAB of the primaries of sRGB under D65, as tables print them, with the Hunt adjustment: a and b times L / 100.
constexpr double kGreen[3] = {87.735, -86.183 * 0.87735, 83.179 * 0.87735}, kBlue[3] = {32.297, 79.188 * 0.32297, -107.860 * 0.32297};

double expectedOfDistance(double hyab) {
  const double largest = std::pow(kGreen[0] - kBlue[0] + std::hypot(kGreen[1] - kBlue[1], kGreen[2] - kBlue[2]), 0.7);
  const double error = std::pow(hyab, 0.7);
  return error < 0.4 * largest ? 0.95 * error / (0.4 * largest) : 0.95 + 0.05 * (error / largest - 0.4) / 0.6;
}

TEST(Flip, OfEqualPicturesIsNothing) {
  const Image image = scene(40, 30, 1);
  EXPECT_EQ(flipOf(image, image).mean, 0.0);
}

TEST(Flip, OfFlatPicturesFollowsFromTheirCielab) {
  const Image black = flat(12, 9, {0, 0, 0}), white = flat(12, 9, {1, 1, 1}), green = flat(12, 9, {0, 1, 0}), blue = flat(12, 9, {0, 0, 1});
  EXPECT_NEAR(flipOf(black, white).mean, expectedOfDistance(100.0), 1e-5);
  EXPECT_NEAR(flipOf(black, white).mean, 0.9674, 1e-4);
  EXPECT_NEAR(flipOf(green, blue).mean, 1.0, 1e-6) << "the two that differ most";
  EXPECT_NEAR(flipOf(black, green).mean, expectedOfDistance(kGreen[0] + std::hypot(kGreen[1], kGreen[2])), 1e-5);
  // Greys of L* 50 and 40: Y = ((L + 16) / 116)^3, 0.184187 and 0.112509.
  const Image mid = flat(12, 9, {0.184187f, 0.184187f, 0.184187f}), dark = flat(12, 9, {0.112509f, 0.112509f, 0.112509f});
  EXPECT_NEAR(flipOf(mid, dark).mean, expectedOfDistance(10.0), 2e-4);
}

TEST(Flip, OfAnyPictureIsTheDirectSum) {
  struct Case {
    int width, height;
    double pixelsPerDegree;
  };
  unsigned seed = 10;
  for (const Case& c : {Case{40, 24, kFlipPixelsPerDegree}, Case{13, 31, 30.0}, Case{1, 9, 67.0}, Case{24, 5, 110.0}}) {
    const Image a = scene(c.width, c.height, ++seed), b = scene(c.width, c.height, ++seed);
    const FlipMap map = flipOf(b, a, c.pixelsPerDegree);
    const auto expected = reference::flip(pixelsOf(a), pixelsOf(b), c.width, c.height, c.pixelsPerDegree);
    double sum = 0.0;
    for (std::size_t p = 0; p < expected.size(); ++p) {
      ASSERT_NEAR(map.errors[p], expected[p], 2e-4) << "pixel " << p << " at " << c.pixelsPerDegree;
      sum += expected[p];
    }
    EXPECT_NEAR(map.mean, sum / static_cast<double>(expected.size()), 2e-5);
  }
}

// Waves of three colours, linear from sRGB values; with a row turned to its opposite and a column of a quarter of the light.
Image waves(int width, int height, int shift, bool lines) {
  Image image{width, height, kColour, {}};
  for (int y = 0; y < height; ++y) {
    for (int pixel = 0; pixel < width; ++pixel) {
      const double x = pixel + shift;
      for (const double phase : {0.31 * x + 0.17 * y, 0.11 * x - 0.23 * y + 1.0, 0.07 * x + 0.05 * y + 2.0}) {
        double encoded = 0.5 + 0.5 * std::sin(phase);
        if (lines && y == height / 3) encoded = 1.0 - encoded;
        if (lines && pixel == width / 2) encoded *= 0.25;
        image.pixels.push_back(static_cast<float>(encoded > 0.04045 ? std::pow((encoded + 0.055) / 1.055, 2.4) : encoded / 12.92));
      }
    }
  }
  return image;
}

TEST(Flip, AgreesWithThePublishedProgram) {
  // What compute_ldrflip of the authors' own program (github.com/NVlabs/flip, python/flip_api.py at 313517b4), its filter2D replaced by
  // SciPy's correlate, gave for these pictures.
  struct Case {
    int width, height;
    double pixelsPerDegree;
    int shift;
    bool lines;
    double mean, largest;
  };
  for (const Case& c :
       {Case{64, 48, kFlipPixelsPerDegree, 1, false, 0.319849, 0.490523}, Case{64, 48, kFlipPixelsPerDegree, 0, true, 0.129488, 0.965346},
        Case{64, 48, kFlipPixelsPerDegree, 3, true, 0.654266, 0.971472}, Case{48, 64, 30.0, 1, false, 0.332306, 0.520259},
        Case{48, 64, 30.0, 0, true, 0.088812, 0.987279}, Case{48, 64, 30.0, 3, true, 0.676442, 0.987188}}) {
    const FlipMap map = flipOf(waves(c.width, c.height, c.shift, c.lines), waves(c.width, c.height, 0, false), c.pixelsPerDegree);
    EXPECT_NEAR(map.mean, c.mean, 1e-5) << c.width << " " << c.shift << c.lines;
    EXPECT_NEAR(*std::max_element(map.errors.begin(), map.errors.end()), c.largest, 1e-4) << c.width << " " << c.shift << c.lines;
  }
}

TEST(Flip, StaysWithinBoundsAndIsSymmetric) {
  for (const unsigned seed : {30u, 31u, 32u}) {
    const Image a = scene(30, 30, seed), b = scene(30, 30, seed + 50);
    const FlipMap forth = flipOf(a, b), back = flipOf(b, a);
    for (std::size_t p = 0; p < forth.errors.size(); ++p) {
      EXPECT_GE(forth.errors[p], 0.0f);
      EXPECT_LE(forth.errors[p], 1.0f);
      EXPECT_FLOAT_EQ(forth.errors[p], back.errors[p]);
    }
  }
}

TEST(Flip, MirroredAndTurnedPicturesGiveMirroredAndTurnedMaps) {
  const Image a = scene(21, 21, 40), b = scene(21, 21, 41);
  const auto moved = [](const Image& image, bool transpose) {
    Image result = image;
    for (int y = 0; y < 21; ++y)
      for (int x = 0; x < 21; ++x)
        for (int c = 0; c < 3; ++c) at(result, x, y, c) = transpose ? at(image, y, x, c) : at(image, 20 - x, y, c);
    return result;
  };
  const FlipMap map = flipOf(a, b), mirrored = flipOf(moved(a, false), moved(b, false)), turned = flipOf(moved(a, true), moved(b, true));
  for (std::size_t y = 0; y < 21; ++y) {
    for (std::size_t x = 0; x < 21; ++x) {
      EXPECT_NEAR(map.errors[y * 21 + x], mirrored.errors[y * 21 + 20 - x], 1e-6);
      EXPECT_NEAR(map.errors[y * 21 + x], turned.errors[x * 21 + y], 1e-6);
    }
  }
}

TEST(Flip, SeesAnEdgeMoreThanAFaintVeil) {
  // The same squared error in both: spread evenly, and as one line.
  const Image reference = flat(40, 40, {0.3f, 0.3f, 0.3f});
  Image line = reference;
  for (int y = 0; y < 40; ++y)
    for (int c = 0; c < 3; ++c) at(line, 20, y, c) += 0.3f;
  const float veil = 0.3f / std::sqrt(40.0f);
  const FlipMap ofLine = flipOf(line, reference), ofVeil = flipOf(flat(40, 40, {0.3f + veil, 0.3f + veil, 0.3f + veil}), reference);
  EXPECT_GT(*std::max_element(ofLine.errors.begin(), ofLine.errors.end()), 2.0f * ofVeil.errors[0]);
}

TEST(Flip, ABackgroundThatDiffersDoesNotReachTheSurfaces) {
  const Image reference = scene(32, 20, 60);
  Image picture = reference;
  Mask mask = everywhere(reference);
  for (std::size_t p = 0; p < mask.size(); ++p) {
    if (p % 32 < 16) continue;
    mask[p] = 0;
    for (std::size_t c = 0; c < 3; ++c)
      picture.pixels[p * 3 + c] = c == 1 ? std::numeric_limits<float>::quiet_NaN() : 1.0f - picture.pixels[p * 3 + c];
  }
  EXPECT_EQ(flip({picture, reference, kColour, mask}).value().mean, 0.0);
  picture.pixels[0] = 1.0f - picture.pixels[0];
  const FlipMap map = flip({picture, reference, kColour, mask}).value();
  EXPECT_GT(map.mean, 0.0);
  EXPECT_EQ(map.errors[31], 0.0f);
}

TEST(Flip, TakesOneChannelAsGreyAndClampsWhatADisplayCannotShow) {
  const Image a = flat(10, 10, {0.4f, 0.4f, 0.4f}), b = flat(10, 10, {1.0f, 1.0f, 1.0f});
  const Image greyA{10, 10, kSky, std::vector<float>(100, 0.4f)}, greyB{10, 10, kSky, std::vector<float>(100, 7.0f)};
  EXPECT_FLOAT_EQ(static_cast<float>(flip({greyA, greyB, kSky, everywhere(greyA)}).value().mean), static_cast<float>(flipOf(a, b).mean));
}

TEST(Flip, PictureIsTheMapAsGrey) {
  const Image picture = flipPicture({{0.0f, 0.25f, 0.5f, 1.0f, 0.0f, 0.75f}, 0.0}, 3);
  EXPECT_EQ(picture.width, 3);
  EXPECT_EQ(picture.height, 2);
  EXPECT_EQ(at(picture, 2, 1, 0), 0.75f);
  EXPECT_EQ(at(picture, 1, 0, 2), 0.25f);
}

}  // namespace
}  // namespace overcast
