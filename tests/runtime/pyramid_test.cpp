// The pyramid: the eight fetches against 64 weights in double, the measured width, and the levels on the device.
#include "runtime/passes/pyramid/pyramid_pass.h"

#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>
#include <glm/gtc/packing.hpp>

#include "tests/reference/pyramid.h"
#include "tests/runtime/scenes.h"
#include "tests/runtime/support.h"

namespace overcast {
namespace {

using reference::Field;
using reference::fieldOf;

/// One unit in the last place of a half float of this size: devices may truncate.
double halfStep(double value) {
  return std::max(std::abs(value), 6.2e-5) * 0x1p-10;
}

Field randomField(const glm::ivec3& size, double amplitude) {
  std::mt19937 random(9);
  return fieldOf(size, [&](const glm::dvec3&) {
    return static_cast<double>(
        glm::unpackHalf1x16(glm::packHalf1x16(static_cast<float>(amplitude * (static_cast<double>(random()) / 4294967296.0 - 0.5)))));
  });
}

TEST(PyramidFormulas, EightFetchesAreTheSixtyFourWeights) {
  const Field field = randomField({10, 7, 5}, 10.0);
  const Field expected = reference::nextLevel(field);
  const glm::vec3 texel = 1.0f / glm::vec3(field.size);
  std::size_t n = 0;
  for (int k = 0; k < expected.size.z; ++k)
    for (int j = 0; j < expected.size.y; ++j)
      for (int i = 0; i < expected.size.x; ++i, ++n) {
        double sum = 0.0;
        for (int corner = 0; corner < 8; ++corner)
          sum += reference::interpolate(field, glm::dvec3(shared::pyramidFetch({i, j, k}, corner, texel)) * glm::dvec3(field.size)) / 8.0;
        EXPECT_NEAR(sum, expected.values[n], 1e-5);
      }
}

TEST(PyramidFormulas, WidthIsProportionalToTwoToTheLevel) {
  EXPECT_EQ(shared::pyramidSigma(0), 0.0f);
  for (int level = 1; level < 8; ++level) EXPECT_NEAR(shared::pyramidSigma(level) / std::exp2(level - 1), 1.0, 0.14);
}

class Pyramid : public test::DeviceTest {
 protected:
  void TearDown() override {
    destroyPyramidPass(device, pass);
    destroyImage(device, volume);
    DeviceTest::TearDown();
  }

  /// Levels of `field` as the device makes them.
  std::vector<Field> levels(const Field& field, int count) {
    destroyPyramidPass(device, pass);
    destroyImage(device, volume);
    volume = test::uploadField(device, field);
    Result<PyramidPass> made = makePyramidPass(device, volume, count);
    EXPECT_TRUE(made.ok());
    pass = std::move(made).value();
    EXPECT_TRUE(runCommands(device, [&](VkCommandBuffer commands) { recordPyramid(commands, pass); }).ok());
    std::vector<Field> all{field};
    for (const GpuImage& level : pass.built) all.push_back(test::readField(device, level));
    return all;
  }

  GpuImage volume;
  PyramidPass pass;
};

TEST_F(Pyramid, AgreesWithBruteForceInDouble) {
  for (const glm::ivec3& size : {glm::ivec3(40, 24, 8), glm::ivec3(32)}) {
    const Field field = randomField(size, 20.0);
    const std::vector<Field> expected = reference::pyramid(field, 6), actual = levels(field, 6);
    ASSERT_EQ(actual.size(), 6u);
    for (std::size_t level = 1; level < 6; ++level) {
      ASSERT_EQ(actual[level].size, expected[level].size);
      // Each level rounds values below 10 to half floats and averages: errors do not grow beyond one step per level.
      for (std::size_t n = 0; n < expected[level].values.size(); ++n)
        ASSERT_NEAR(actual[level].values[n], expected[level].values[n], static_cast<double>(level) * halfStep(10.0)) << "level " << level;
    }
  }
}

TEST_F(Pyramid, ConstantsStayExact) {
  for (const double value : {3.25, -7.5, 65504.0})
    for (const Field& level : levels(fieldOf({24, 16, 8}, [&](const glm::dvec3&) { return value; }), 6))
      for (const double v : level.values) ASSERT_EQ(v, value);
}

TEST_F(Pyramid, LinearFieldsStayExactAwayFromTheBorder) {
  const auto plane = [](const glm::dvec3& p) { return 0.5 * p.x - 0.25 * p.y + p.z - 8.0; };
  const std::vector<Field> all = levels(fieldOf(glm::ivec3(64), plane), 4);
  for (std::size_t level = 0; level < all.size(); ++level) {
    const int side = all[level].size.x;
    std::size_t exact = 0;
    // A level's kernel reaches 3/2 of its voxels beyond its own voxel's centre.
    for (int k = 1; k + 1 < side; ++k)
      for (int j = 1; j + 1 < side; ++j)
        for (int i = 1; i + 1 < side; ++i, ++exact)
          ASSERT_EQ(reference::valueAt(all[level], {i, j, k}), plane(std::exp2(level) * (glm::dvec3(i, j, k) + 0.5)));
    EXPECT_GT(exact, 200u);
  }
}

TEST_F(Pyramid, VarianceOfAnImpulseIsAsStated) {
  // The filter has order three, so that the second moment over a decimated level is the same wherever the impulse falls.
  for (const int phase : {0, 3, 5}) {
    const glm::ivec3 where(28 + phase, 32, 32);
    const Field impulse = fieldOf(glm::ivec3(64), [&](const glm::dvec3& p) { return glm::ivec3(p) == where ? 60000.0 : 0.0; });
    const std::vector<Field> all = levels(impulse, 4);
    for (std::size_t level = 1; level < all.size(); ++level) {
      double mass = 0.0, mean = 0.0, square = 0.0;
      const int side = all[level].size.x;
      for (int k = 0; k < side; ++k)
        for (int j = 0; j < side; ++j)
          for (int i = 0; i < side; ++i) {
            const double value = reference::valueAt(all[level], {i, j, k});
            const double x = std::exp2(level) * (i + 0.5);
            mass += value;
            mean += value * x;
            square += value * x * x;
          }
      mean /= mass;
      const double variance = square / mass - mean * mean;
      const double stated = (std::pow(4.0, static_cast<double>(level)) - 1.0) / 4.0;
      EXPECT_NEAR(mean, where.x + 0.5, 0.02) << "level " << level;
      EXPECT_NEAR(variance / stated, 1.0, 0.01) << "level " << level;
      EXPECT_NEAR(variance, std::pow(shared::pyramidSigma(static_cast<int>(level)), 2.0), 0.01 * stated);
    }
  }
}

TEST_F(Pyramid, OneLevelBuildsNothing) {
  EXPECT_EQ(levels(fieldOf(glm::ivec3(8), [](const glm::dvec3&) { return 1.0; }), 1).size(), 1u);
}

}  // namespace
}  // namespace overcast
