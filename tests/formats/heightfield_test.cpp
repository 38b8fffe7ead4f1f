#include "formats/heightfield.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <span>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "formats/files.h"
#include "formats/image_mipmaps.h"
#include "tests/formats/temporary_folder.h"
#include "tests/reference/distance.h"
#include "tests/reference/heightfield.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using Height = std::function<double(double, double)>;

/// Texels with the mean and variance of `height` (local units over x, y about the middle) over 16 x 16 points each.
std::vector<HeightTexel> texelsOf(const HeightField& field, const Height& height) {
  constexpr int n = 16;
  std::vector<HeightTexel> texels;
  const glm::dvec2 cell = cellSize(field);
  for (int j = 0; j < field.size.y; ++j)
    for (int i = 0; i < field.size.x; ++i) {
      std::vector<double> values;
      double mean = 0.0, variance = 0.0;
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
          values.push_back(height((i + (x + 0.5) / n) * cell.x - field.halfExtent.x, (j + (y + 0.5) / n) * cell.y - field.halfExtent.y) /
                           field.halfExtent.z);
      for (const double v : values) mean += v / (n * n);
      for (const double v : values) variance += (v - mean) * (v - mean) / (n * n);
      texels.push_back({static_cast<float>(mean), static_cast<float>(variance)});
    }
  return texels;
}

HeightField fieldOf(const glm::ivec2& size, const glm::dvec3& halfExtent, const Height& front, const Height& back = {}) {
  HeightField field;
  field.size = size;
  field.halfExtent = halfExtent;
  field.front = {texelsOf(field, front)};
  if (back) field.back = {texelsOf(field, back)};
  buildLevels(field);
  EXPECT_TRUE(isWhole(field));
  return field;
}

/// Heights and variances at random, a turned frame.
HeightField randomField(unsigned seed, const glm::ivec2& size, bool pair) {
  std::mt19937 random(seed);
  const auto number = [&] { return static_cast<double>(random()) / 4294967296.0; };
  HeightField field;
  field.size = size;
  field.halfExtent = {2.0, 1.5 * size.y / size.x, 0.7};
  field.origin = {3.0, -2.0, 1.0};
  field.localFromField = glm::mat3_cast(glm::normalize(glm::dquat(1.0, number(), number() - 0.5, number())));
  const auto layer = [&](double middle) {
    std::vector<HeightTexel> texels;
    for (int n = 0; n < size.x * size.y; ++n)
      texels.push_back({static_cast<float>(middle + 0.5 * (number() - 0.5)), static_cast<float>(n % 3 ? 0.02 * number() : 0.0)});
    return texels;
  };
  field.front = {layer(0.4)};
  if (pair) field.back = {layer(-0.4)};
  buildLevels(field);
  EXPECT_TRUE(isWhole(field));
  return field;
}

std::vector<glm::dvec3> pointsAround(const HeightField& field, std::size_t count, std::uint64_t seed) {
  Box box = bounds(field);
  const glm::dvec3 margin = 0.4 * extent(box);
  return reference::randomPoints({box.min - margin, box.max + margin}, count, seed);
}

/// Distance to the part of the plane z = slope . (x, y) over a rectangle: to its two triangles.
double patchDistance(const glm::dvec2& slope, const glm::dvec3& half, const glm::dvec3& p) {
  const auto corner = [&](double x, double y) { return glm::dvec3(x, y, slope.x * x + slope.y * y); };
  Mesh mesh;
  mesh.positions = {corner(-half.x, -half.y), corner(half.x, -half.y), corner(half.x, half.y), corner(-half.x, half.y)};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return reference::distance(mesh, std::span(&p, 1))[0];
}

// Above and below them; beyond the rectangle too, where the closest point lies on a side along the slope.
TEST(HeightField, PlanesAreExact) {
  for (const glm::dvec2& slope : {glm::dvec2(0.0), glm::dvec2(0.4, 0.0), glm::dvec2(-0.3, 0.5)})
    for (const glm::ivec2& size : {glm::ivec2(8), glm::ivec2(32, 16)}) {
      const glm::dvec3 half(1.0, 0.8, 1.5);
      HeightField field = fieldOf(size, half, [&](double x, double y) { return slope.x * x + slope.y * y; });
      field.localFromField = glm::mat3_cast(glm::normalize(glm::dquat(0.8, 0.3, -0.4, 0.2)));
      field.origin = {10.0, 20.0, -5.0};
      const bool tilted = slope.x != 0.0 && slope.y != 0.0;
      for (int level = 0; level < 3; ++level)
        for (const glm::dvec3& p : reference::randomPoints({-2.0 * half, 2.0 * half}, 500, 4)) {
          const double expected = patchDistance(slope, half, p);
          // Onto a side that is not along an axis of the slope the step is not the shortest.
          const double allowed = tilted ? 0.1 * expected : 0.0;
          EXPECT_NEAR(sampleHeightField(field, field.origin + field.localFromField * p, level), expected, 2e-6 + allowed) << level;
        }
    }
}

TEST(HeightField, SampleIsTheBruteForceSum) {
  for (const bool pair : {false, true}) {
    const HeightField field = asStored(randomField(pair ? 5 : 6, {16, 8}, pair));
    for (const glm::dvec3& p : pointsAround(field, 3000, 9))
      EXPECT_NEAR(sampleHeightField(field, p), reference::heightFieldDistance(field, p), 1e-12);
  }
}

// The true distance to z = a sin(k x), never negative, by dense search.
double sinusoidDistance(double a, double k, double x, double z) {
  double best = 1e300;
  for (int n = -4000; n <= 4000; ++n) {
    const double t = x + n * 1e-4;
    best = std::min(best, std::hypot(t - x, a * std::sin(k * t) - z));
  }
  return best;
}

TEST(HeightField, ErrorFallsWithSizeOnASinusoid) {
  const double a = 0.05, k = 2.0 * std::numbers::pi;
  double before = 1e300;
  for (const int size : {16, 32, 64, 128, 256}) {
    const HeightField field = fieldOf({size, 8}, {1.0, 0.25, 0.3}, [&](double x, double) { return a * std::sin(k * x); });
    double squares = 0.0;
    int count = 0;
    for (double x = -0.4; x < 0.4; x += 0.0137)
      for (const double d : {-0.04, -0.01, 0.0, 0.01, 0.04}) {
        const double z = a * std::sin(k * x) + d;
        squares += std::pow(sampleHeightField(field, {x, 0.0, z}) - sinusoidDistance(a, k, x, z), 2.0);
        ++count;
      }
    const double rms = std::sqrt(squares / count);
    EXPECT_LT(rms, size <= 64 ? 0.5 * before : before) << size << " texels: second order until the search's own error is left";
    before = rms;
  }
  EXPECT_LT(before, 5e-4);
}

// From far above, hills are as near as their tops.
TEST(HeightField, FarDistancesAreSensible) {
  const double a = 0.05, k = 2.0 * std::numbers::pi;
  const HeightField field = fieldOf({64, 32}, {2.0, 1.0, 0.3}, [&](double x, double) { return a * std::sin(k * x); });
  for (double x = -0.5; x < 0.5; x += 0.013)
    for (const double z : {0.25, 0.5, 1.0, -0.5}) {
      const double exact = sinusoidDistance(a, k, x, z);
      EXPECT_NEAR(sampleHeightField(field, {x, 0.0, z}), exact, 0.1 * exact + 0.01) << x << " " << z;
    }
}

TEST(HeightField, RoughnessWidensTheFalloff) {
  const auto noise = [](double x, double y) { return 0.01 * std::sin(900.0 * x + 400.0 * y); };
  const HeightField rough = fieldOf({16, 16}, {1.0, 1.0, 0.5}, noise);
  const HeightField flat = fieldOf({16, 16}, {1.0, 1.0, 0.5}, [](double, double) { return 0.0; });
  const double cell = cellSize(rough).x, slope2 = 12.0 * 0.5e-4 / (cell * cell);
  const double expected = 0.1 / std::sqrt(1.0 + slope2), value = sampleHeightField(rough, {0.1, -0.2, 0.1});
  EXPECT_NEAR(sampleHeightField(flat, {0.1, -0.2, 0.1}), 0.1, 1e-6);
  EXPECT_NEAR(value, expected, 0.05 * expected);
  EXPECT_LT(value, 0.099);
}

TEST(HeightField, LevelsKeepTheMeanAndTheMoments) {
  const HeightField field = randomField(3, {32, 8}, true);
  ASSERT_EQ(levelCount(field), 6);
  for (const HeightLevels* layer : {&field.front, &field.back})
    for (int level = 1; level < levelCount(field); ++level) {
      const glm::ivec2 size = levelSize(field, level);
      for (int j = 0; j < size.y; ++j)
        for (int i = 0; i < size.x; ++i) {
          const glm::dvec2 expected = reference::momentsBelow(field, *layer, level, i, j);
          const HeightTexel& texel = (*layer)[static_cast<std::size_t>(level)][static_cast<std::size_t>(i + size.x * j)];
          EXPECT_NEAR(texel.mean, expected.x, 1e-6);
          EXPECT_NEAR(texel.variance, expected.y, 1e-6);
        }
    }
}

TEST(HeightField, HalvesKeepSmallVariancesOnLargeHeights) {
  HeightField field = fieldOf({8, 8}, {1.0, 1.0, 1.0}, [](double x, double y) { return 0.9 + 0.01 * std::sin(70.0 * x + 30.0 * y); });
  const HeightField halves = asStored(field);
  for (std::size_t n = 0; n < 64; ++n)
    EXPECT_NEAR(halves.front[0][n].variance, field.front[0][n].variance, 0.002 * field.front[0][n].variance);
  EXPECT_LT(field.front[0][0].variance, 1e-4f) << "the second moment would keep it too";
}

TEST(HeightField, APairChangesNoFasterThanItsBound) {
  for (const unsigned seed : {1u, 2u}) {
    const HeightField field = randomField(seed, {8, 8}, true);
    for (const int level : {0, 1}) {
      const double bound = lipschitzBound(field, level);
      const std::vector<glm::dvec3> points = reference::randomPoints({-field.halfExtent, field.halfExtent}, 4000, seed);
      const auto value = [&](const glm::dvec3& p) { return sampleHeightField(field, field.origin + field.localFromField * p, level); };
      double steepest = 0.0;
      for (std::size_t n = 0; n + 1 < points.size(); ++n)
        for (const double reach : {1.0, 1e-3, 1e-6}) {
          const glm::dvec3 other = points[n] + reach * (points[n + 1] - points[n]);
          steepest = std::max(steepest, std::abs(value(points[n]) - value(other)) / glm::length(other - points[n]));
        }
      EXPECT_LE(steepest, bound * (1.0 + 1e-6)) << seed;
      EXPECT_GT(steepest, 0.9);
    }
  }
}

TEST(HeightField, ASheetLiesWithinItsRangeWhichChangesNoFasterThanItsBound) {
  for (const unsigned seed : {3u, 4u, 5u}) {
    const HeightField field = randomField(seed, {16, 8}, false);
    for (const int level : {0, 1}) {
      const double bound = lipschitzBound(field, level);
      glm::dvec2 steepest(0.0);
      const std::vector<glm::dvec3> points = pointsAround(field, 4000, seed);
      for (std::size_t n = 0; n + 1 < points.size(); ++n) {
        const glm::dvec2 range = sheetRange(field, points[n], level);
        const double value = sampleHeightField(field, points[n], level);
        ASSERT_GE(value, range.x - 1e-12);
        ASSERT_LE(value, range.y + 1e-12);
        for (const double reach : {1.0, 1e-3, 1e-6}) {
          const glm::dvec3 other = points[n] + reach * (points[n + 1] - points[n]);
          steepest = glm::max(steepest, glm::abs(range - sheetRange(field, other, level)) / glm::length(other - points[n]));
        }
      }
      EXPECT_LE(steepest.x, 1.0 + 1e-6) << seed;
      EXPECT_LE(steepest.y, bound * (1.0 + 1e-6)) << seed;
      EXPECT_GT(steepest.y, 1.0);
    }
  }
}

// Far above a bend the first-order distance loses its slope fastest; there the bound must hold and not be far off.
TEST(HeightField, BoundHoldsOverABendAndIsNearIt) {
  HeightField field;
  field.size = {8, 8};
  field.halfExtent = {4.0, 4.0, 20.0};
  field.front.resize(1);
  field.back.resize(1);
  for (int n = 0; n < 64; ++n) {
    field.front[0].push_back({static_cast<float>(std::max(n % 8 - 3, 0) / 20.0), 0.0f});
    field.back[0].push_back({-1.0f, 0.0f});
  }
  buildLevels(field);
  const double bound = lipschitzBound(field);
  double steepest = 0.0;
  for (double x = -1.0; x < 1.0; x += 1e-3)
    for (const double z : {-19.0, 19.0}) {
      const double change = sampleHeightField(field, {x + 1e-6, 0.1, z}) - sampleHeightField(field, {x - 1e-6, 0.1, z});
      steepest = std::max(steepest, std::abs(change) / 2e-6);
    }
  EXPECT_LE(steepest, bound);
  EXPECT_GT(steepest, bound / 4.0);
}

TEST(HeightField, BeyondItsBoxTheDistanceIsBetweenTheBounds) {
  const HeightField field = randomField(7, {16, 8}, true);
  std::size_t beyond = 0;
  for (const glm::dvec3& point : pointsAround(field, 4000, 6)) {
    const glm::dvec3 p = (point - field.origin) * field.localFromField, q = glm::clamp(p, -field.halfExtent, field.halfExtent);
    const double gap = glm::length(p - q), value = sampleHeightField(field, point);
    if (gap == 0.0) continue;
    ++beyond;
    const double phi = sampleHeightField(field, field.origin + field.localFromField * (q * (1.0 - 1e-12)));
    EXPECT_GE(phi, -1e-9);
    EXPECT_GE(value, std::hypot(gap, phi) - 1e-9);
    EXPECT_LE(value, gap + phi + 1e-9);
    const glm::dvec3 near = q + 1e-9 / gap * (p - q);
    EXPECT_NEAR(sampleHeightField(field, field.origin + field.localFromField * near), phi, 1e-6) << "continuous";
  }
  EXPECT_GT(beyond, 1000u);
}

TEST(HeightField, PlanesHaveTheSlopeOfADistance) {
  const HeightField field = fieldOf({16, 8}, {1.0, 0.8, 1.5}, [](double x, double y) { return 0.3 * x - 0.2 * y; });
  EXPECT_GE(lipschitzBound(field), std::sqrt(1.13));
  EXPECT_LT(lipschitzBound(field), 1.1);
  HeightField pair = field;
  pair.back = {std::vector<HeightTexel>(pair.front[0].size(), HeightTexel{-0.9f, 0.0f})};
  buildLevels(pair);
  EXPECT_NEAR(lipschitzBound(pair), 1.0, 1e-4);
}

TEST(HeightField, BoundHoldsItsBox) {
  const HeightField field = randomField(8, {8, 16}, false);
  const Box box = bounds(field);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 sign((corner & 1) * 2 - 1, (corner & 2) - 1, (corner & 4) / 2 - 1);
    const glm::dvec3 p = field.origin + field.localFromField * (sign * field.halfExtent);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_GE(p[axis], box.min[axis] - 1e-12);
      EXPECT_LE(p[axis], box.max[axis] + 1e-12);
    }
  }
}

TEST(HeightField, ReadsBackWhatWasWritten) {
  const test::TemporaryFolder folder;
  for (const bool pair : {false, true}) {
    const HeightField field = asStored(randomField(2, {64, 16}, pair));
    const auto path = folder.path / "field.exr";
    const auto bytes = writeHeightField(path, field);
    ASSERT_TRUE(bytes.ok()) << message(bytes.error());
    EXPECT_EQ(bytes.value(), std::filesystem::file_size(path));
    const auto first = readFile(path).value();
    const auto read = readHeightField(path);
    ASSERT_TRUE(read.ok()) << message(read.error());
    EXPECT_EQ(read.value().localFromField, field.localFromField);
    EXPECT_EQ(read.value().origin, field.origin);
    EXPECT_EQ(read.value().halfExtent, field.halfExtent);
    EXPECT_EQ(read.value().size, field.size);
    EXPECT_EQ(read.value().back.empty(), !pair);
    for (std::size_t l = 0; l < field.front.size(); ++l)
      for (std::size_t n = 0; n < field.front[l].size(); ++n) {
        EXPECT_EQ(read.value().front[l][n].mean, field.front[l][n].mean);
        EXPECT_EQ(read.value().front[l][n].variance, field.front[l][n].variance);
        if (pair) {
          EXPECT_EQ(read.value().back[l][n].mean, field.back[l][n].mean);
        }
      }
    ASSERT_TRUE(writeHeightField(path, read.value()).ok());
    EXPECT_EQ(readFile(path).value(), first);
  }
}

TEST(HeightField, DamagedFilesAreErrors) {
  const test::TemporaryFolder folder;
  const auto path = folder.path / "field.exr";
  ASSERT_TRUE(writeHeightField(path, asStored(randomField(2, {8, 8}, true))).ok());
  const std::vector<std::byte> whole = readFile(path).value();
  std::mt19937 random(1);
  for (std::size_t cut = 0; cut < whole.size(); cut += whole.size() / 13) {
    ASSERT_TRUE(writeFileAtomically(path, std::span(whole).first(cut)).ok());
    EXPECT_FALSE(readHeightField(path).ok()) << cut << " of " << whole.size() << " bytes";
  }
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<std::byte> flipped = whole;
    for (int n = 0; n < 3; ++n) flipped[random() % flipped.size()] ^= static_cast<std::byte>(1u << (random() % 8));
    ASSERT_TRUE(writeFileAtomically(path, flipped).ok());
    const auto read = readHeightField(path);
    EXPECT_TRUE(!read.ok() || isWhole(read.value()));
  }
}

TEST(HeightField, ForeignFilesAreErrorsThatNameTheField) {
  const test::TemporaryFolder folder;
  const auto path = folder.path / "field.exr";
  const auto reason = [&](const std::function<void(MipmappedImage&)>& change) {
    EXPECT_TRUE(writeHeightField(path, asStored(randomField(2, {8, 8}, false))).ok());
    MipmappedImage image = readMipmaps(path).value();
    change(image);
    EXPECT_TRUE(writeMipmaps(path, image).ok());
    const auto read = readHeightField(path);
    return read.ok() ? std::string("read") : message(read.error());
  };
  EXPECT_EQ(reason([](MipmappedImage&) {}), "read");
  EXPECT_NE(reason([](MipmappedImage& image) { image.numbers["overcast_version"] = 2.0; }).find("overcast_version"), std::string::npos);
  EXPECT_NE(reason([](MipmappedImage& image) { image.numbers.erase("overcast_version"); }).find("overcast_version"), std::string::npos);
  EXPECT_NE(reason([](MipmappedImage& image) { image.numbers.erase("overcast_axisY.z"); }).find("overcast_axisY"), std::string::npos);
  EXPECT_NE(reason([](MipmappedImage& image) {
              for (Image& level : image.levels) level.channels[0] = "front.height";
            }).find("front.mean"),
            std::string::npos);
  for (const auto& change : std::vector<std::function<void(MipmappedImage&)>>{
           [](MipmappedImage& image) { image.numbers["overcast_axisX.y"] += 0.1; },
           [](MipmappedImage& image) { image.numbers["overcast_halfExtent.y"] = -1.0; },
           [](MipmappedImage& image) { image.numbers["overcast_origin.x"] = std::nan(""); },
           [](MipmappedImage& image) { image.levels[0].pixels[1] = -1.0f; },
           [](MipmappedImage& image) { image.levels[1].pixels[0] = std::nanf(""); },
           [](MipmappedImage& image) {
             for (const char* key : {"overcast_axisZ.x", "overcast_axisZ.y", "overcast_axisZ.z"}) image.numbers[key] *= -1.0;
           }})
    EXPECT_NE(reason(change).find("out of range"), std::string::npos);
  ASSERT_TRUE(writeExr(path, Image{8, 8, {"Y"}, std::vector<float>(64)}).ok());
  EXPECT_NE(message(readHeightField(path).error()).find("mipmap levels"), std::string::npos);
}

}  // namespace
}  // namespace overcast
