// Skies: harmonics of images against closed forms; turning; what is refused.
#include "formats/sky.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "formats/image_mipmaps.h"
#include "tests/formats/temporary_folder.h"

namespace overcast {
namespace {

using test::TemporaryFolder;
using testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

/// Sloan 2008, appendix A2, in the order of formats/aperture.h.
std::array<double, 9> basis(const glm::dvec3& w) {
  const double root = std::sqrt(kPi);
  return {1.0 / (2.0 * root),
          std::sqrt(3.0) * w.y / (2.0 * root),
          std::sqrt(3.0) * w.z / (2.0 * root),
          std::sqrt(3.0) * w.x / (2.0 * root),
          std::sqrt(15.0) * w.x * w.y / (2.0 * root),
          std::sqrt(15.0) * w.y * w.z / (2.0 * root),
          std::sqrt(5.0) * (3.0 * w.z * w.z - 1.0) / (4.0 * root),
          std::sqrt(15.0) * w.x * w.z / (2.0 * root),
          std::sqrt(15.0) * (w.x * w.x - w.y * w.y) / (4.0 * root)};
}

glm::dvec3 radiance(const SkyHarmonics& sky, const glm::dvec3& w) {
  const std::array<double, 9> y = basis(w);
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < 9; ++i) sum += y[i] * glm::dvec3(sky.coefficients[i]);
  return sum;
}

/// Where the middle of a pixel looks, as the header has it.
glm::dvec3 latLongDirection(int x, int y, int width, int height) {
  const double longitude = kPi * (1.0 - 2.0 * (x + 0.5) / width), latitude = kPi * (0.5 - (y + 0.5) / height);
  return {std::cos(latitude) * std::sin(longitude), std::sin(latitude), std::cos(latitude) * std::cos(longitude)};
}

/// An image of what `value` (three channels) says of each pixel's direction.
template <class Value>
Image latLong(int height, const Value& value) {
  Image image{2 * height, height, {"B", "G", "R"}, {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < 2 * height; ++x) {
      const glm::dvec3 colour = value(latLongDirection(x, y, 2 * height, height));
      for (const double c : {colour.z, colour.y, colour.x}) image.pixels.push_back(static_cast<float>(c));
    }
  return image;
}

template <class Value>
Image cube(int side, const Value& value) {
  Image image{side, 6 * side, {"B", "G", "R"}, {}};
  for (const glm::dvec3& direction : cubePixelDirections(side)) {
    const glm::dvec3 colour = value(glm::normalize(direction));
    for (const double c : {colour.z, colour.y, colour.x}) image.pixels.push_back(static_cast<float>(c));
  }
  return image;
}

SkyHarmonics smoothSky() {
  std::mt19937 random(4);
  SkyHarmonics sky = uniformSky({6.0f, 5.0f, 7.0f});
  for (std::size_t i = 1; i < 9; ++i)
    for (int c = 0; c < 3; ++c) sky.coefficients[i][c] = static_cast<float>(random()) / 4294967296.0f - 0.5f;
  return sky;
}

double difference(const SkyHarmonics& a, const SkyHarmonics& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, static_cast<double>(std::abs(a.coefficients[i][c] - b.coefficients[i][c])));
  return largest;
}

TEST(Sky, UniformImagesHaveTheFirstHarmonicAlone) {
  const auto grey = [](const glm::dvec3&) { return glm::dvec3(1.0, 2.0, 0.5); };
  for (const Image& image : {latLong(4, grey), latLong(33, grey), cube(2, grey), cube(9, grey)}) {
    const SkyHarmonics sky = skyHarmonics(image).value();
    EXPECT_NEAR(sky.coefficients[0].x, std::sqrt(4.0 * kPi), 1e-6);
    EXPECT_LT(difference(sky, uniformSky({1.0f, 2.0f, 0.5f})), 1e-6) << image.width << "x" << image.height;
  }
}

TEST(Sky, SmoothSkiesComeBack) {
  const SkyHarmonics made = smoothSky();
  const auto value = [&](const glm::dvec3& w) { return radiance(made, w); };
  EXPECT_LT(difference(skyHarmonics(latLong(64, value)).value(), made), 2e-3);
  EXPECT_LT(difference(skyHarmonics(cube(64, value)).value(), made), 6e-3);
  EXPECT_GT(difference(skyHarmonics(latLong(64, [&](const glm::dvec3& w) { return radiance(made, -w); })).value(), made), 0.3);
}

TEST(Sky, PicturesLieAsOpenExrHasThem) {
  // A lamp in the middle of the picture's left half is towards +x; on the first face of a cube too.
  Image image = latLong(32, [](const glm::dvec3&) { return glm::dvec3(0.0); });
  for (int c = 0; c < 3; ++c) at(image, 16, 16, c) = 100.0f;
  const SkyHarmonics side = skyHarmonics(image).value();
  EXPECT_GT(side.coefficients[3].x, 20.0f * std::abs(side.coefficients[2].x));
  EXPECT_GT(side.coefficients[3].x, 10.0f * std::abs(side.coefficients[1].x));
  Image faces = cube(9, [](const glm::dvec3&) { return glm::dvec3(0.0); });
  for (int c = 0; c < 3; ++c) at(faces, 4, 4, c) = 100.0f;
  const SkyHarmonics first = skyHarmonics(faces).value();
  EXPECT_GT(first.coefficients[3].x, 1e3f * std::abs(first.coefficients[2].x));
  Image top = latLong(32, [](const glm::dvec3&) { return glm::dvec3(0.0); });
  for (int x = 0; x < 64; ++x) at(top, x, 0, channelIndex(top, "G")) = 1.0f;
  EXPECT_GT(skyHarmonics(top).value().coefficients[1].y, 0.0f) << "the first row is up";
}

TEST(Sky, TurnsWithItsAxes) {
  const SkyHarmonics sky = smoothSky();
  std::mt19937 random(8);
  const auto real = [&] { return static_cast<double>(random()) / 2147483648.0 - 1.0; };
  for (int i = 0; i < 50; ++i) {
    glm::dmat3 m = glm::mat3_cast(glm::normalize(glm::dquat(real(), real(), real(), real())));
    if (i % 2 == 1) m = m * glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, 1);
    const SkyHarmonics local = turned(sky, m);
    const glm::dvec3 w = glm::normalize(glm::dvec3(real(), real(), real()));
    EXPECT_LT(glm::distance(radiance(local, m * w), radiance(sky, w)), 1e-5);
    EXPECT_LT(difference(turned(local, glm::transpose(m)), sky), 1e-5);
  }
}

TEST(Sky, RefusesWhatIsNoSkyAndNamesTheFile) {
  const auto grey = [](const glm::dvec3&) { return glm::dvec3(1.0); };
  const auto why = [](const Image& image) { return message(skyHarmonics(image).error()); };
  EXPECT_THAT(why({3, 2, {"R", "G", "B"}, std::vector<float>(18)}), HasSubstr("3x2 pixels are neither"));
  EXPECT_THAT(why({1, 6, {"Y"}, std::vector<float>(6)}), HasSubstr("1x6"));
  EXPECT_THAT(why({4, 2, {"R", "G", "Z"}, std::vector<float>(24)}), HasSubstr("neither the channels R, G and B nor Y"));
  Image broken = latLong(4, grey);
  broken.pixels[7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(why(broken), HasSubstr("not a number"));
  Image wild = latLong(4, grey);
  wild.pixels[7] = std::numeric_limits<float>::infinity();
  wild.pixels[8] = -3.0f;
  const SkyHarmonics tamed = skyHarmonics(wild).value();
  EXPECT_TRUE(std::isfinite(tamed.coefficients[0].x + tamed.coefficients[0].y + tamed.coefficients[0].z));
  const TemporaryFolder folder;
  ASSERT_TRUE(writeExr(folder.path / "odd.exr", {3, 2, {"R", "G", "B"}, std::vector<float>(18)}));
  EXPECT_THAT(message(readSky(folder.path / "odd.exr").error()), HasSubstr("odd.exr: 3x2 pixels"));
  EXPECT_FALSE(readSky(folder.path / "missing.exr"));
  EXPECT_THAT(message(skyFile(folder.path, "../odd.exr").error()), HasSubstr("sky/image"));
  const Image grey1{4, 2, {"Y"}, std::vector<float>(8, 2.0f)};
  EXPECT_LT(difference(skyHarmonics(grey1).value(), uniformSky(glm::vec3(2.0f))), 1e-6);
}

}  // namespace
}  // namespace overcast
