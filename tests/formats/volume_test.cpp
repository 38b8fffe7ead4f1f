#include "formats/volume.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <tbb/global_control.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "tests/formats/support.h"
#include "tests/reference/shapes.h"

namespace overcast {
namespace {

template <class Field>
Volume filled(const glm::ivec3& size, const glm::dvec3& origin, double voxelSize, const Field& field) {
  Volume volume;
  volume.size = size;
  volume.origin = origin;
  volume.voxelSize = voxelSize;
  volume.signMethod = "signed-crossings";
  for (int k = 0; k < size.z; ++k)
    for (int j = 0; j < size.y; ++j)
      for (int i = 0; i < size.x; ++i) volume.distance.push_back(static_cast<float>(field(origin + voxelSize * glm::dvec3(i, j, k))));
  return volume;
}

Volume torusVolume() {
  return filled({21, 10, 23}, {-1.1, -0.5, -1.2}, 0.107, [](const glm::dvec3& p) { return reference::torusDistance(p, 0.7, 0.25); });
}

/// Samples without any pattern in [low, high]: the steepest and least smooth fields there are.
Volume noiseVolume(std::uint64_t seed, double low, double high) {
  const glm::ivec3 size{4, 3, 5};
  const auto values = reference::randomPoints({glm::dvec3(low), glm::dvec3(high)}, 60, seed);
  std::size_t next = 0;
  return filled(size, {-0.3, 0.2, 0.1}, 0.5, [&](const glm::dvec3&) { return values[next++].x; });
}

bool sameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

void expectSame(const Volume& a, const Volume& b) {
  EXPECT_EQ(a.size, b.size);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_EQ(a.voxelSize, b.voxelSize);
  EXPECT_EQ(a.signMethod, b.signMethod);
  EXPECT_EQ(a.step, b.step);
  EXPECT_TRUE(sameBits(a.distance, b.distance));
}

/// The bounds of DESIGN 5.1 from the value at the closest point of the box.
struct Bounds {
  double lower = 0.0;
  double upper = 0.0;
};

Bounds boundsAt(const Volume& volume, const glm::dvec3& p) {
  const Box box = bounds(volume);
  const glm::dvec3 q = glm::clamp(p, box.min, box.max);
  const double phi = sampleVolume(volume, q), gap = glm::length(p - q);
  return {phi < 0.0 ? gap + phi : std::sqrt(gap * gap + phi * phi), gap + phi};
}

TEST(Volume, boundsSpanTheSamples) {
  const Box box = bounds(filled({3, 4, 5}, {1, 2, 3}, 0.5, [](const glm::dvec3&) { return 1.0; }));
  EXPECT_EQ(box.min, glm::dvec3(1, 2, 3));
  EXPECT_EQ(box.max, glm::dvec3(2, 3.5, 5));
}

TEST(VolumeSampling, reproducesTrilinearFunctions) {
  const auto field = [](const glm::dvec3& p) {
    return 10.0 + p.x - 2.0 * p.y + 3.0 * p.z + 0.5 * p.x * p.y - p.y * p.z + 0.25 * p.x * p.y * p.z;
  };
  // Positions and values are multiples of 1/8: exact in float.
  const Volume volume = filled({5, 4, 6}, {-1, 0.5, 1}, 0.5, field);
  for (const glm::dvec3& p : reference::randomPoints(bounds(volume), 1000, 3)) EXPECT_NEAR(sampleVolume(volume, p), field(p), 1e-13);
  EXPECT_EQ(sampleVolume(volume, bounds(volume).max), field(bounds(volume).max));
}

TEST(VolumeSampling, continuesOutsideByTheBoundsOfTheDesign) {
  const Volume outside = filled({3, 3, 3}, {0, 0, 0}, 1.0, [](const glm::dvec3&) { return 4.0; });
  EXPECT_DOUBLE_EQ(sampleVolume(outside, {5, 1, 1}), 5.0);    // 3 beyond, 4 there
  EXPECT_DOUBLE_EQ(sampleVolume(outside, {-2, -2, 3}), 5.0);  // 3 beyond across a corner
  const Volume inside = filled({3, 3, 3}, {0, 0, 0}, 1.0, [](const glm::dvec3&) { return -4.0; });
  EXPECT_DOUBLE_EQ(sampleVolume(inside, {5, 1, 1}), -1.0);
}

/// A floor of 2 m x 2 m x 0.1 m as bake samples it by default: 32 samples along the longest side, of them 2 voxels of padding.
Volume floorVolume() {
  const double voxel = 2.0 / 27.0;
  return filled({32, 7, 32}, {-1.0 - 2.0 * voxel, -0.05 - 2.0 * voxel, -1.0 - 2.0 * voxel}, voxel, [](const glm::dvec3& p) {
    return reference::boxDistance(p, {1.0, 0.05, 1.0});
  });
}

TEST(VolumeSampling, isExactFarAboveTheMiddleOfAFloor) {
  const Volume floor = floorVolume();
  for (const glm::dvec3& p : reference::randomPoints({{-0.8, 0.3, -0.8}, {0.8, 8.0, 0.8}}, 1000, 5))
    EXPECT_NEAR(sampleVolume(floor, p), p.y - 0.05, 1e-6);
}

TEST(VolumeSampling, staysBetweenTheBoundsAndNearTheTruthAllAroundAFloor) {
  const Volume floor = floorVolume();
  for (const glm::dvec3& p : reference::randomPoints({glm::dvec3(-4.0), glm::dvec3(4.0)}, 20000, 6)) {
    const double exact = reference::boxDistance(p, {1.0, 0.05, 1.0}), value = sampleVolume(floor, p);
    const Bounds range = boundsAt(floor, p);
    EXPECT_GE(value, range.lower - 1e-12);
    EXPECT_LE(value, range.upper + 1e-12);
    // At the edges the samples round off the kink of the distance; the lower bound alone would be off by 30 %.
    if (exact > 0.2) {
      EXPECT_NEAR(value, exact, 0.05 * exact) << p.x << ' ' << p.y << ' ' << p.z;
    }
  }
}

TEST(VolumeSampling, isContinuousBeyondTheBox) {
  const Volume floor = floorVolume();
  const auto points = reference::randomPoints({glm::dvec3(-2.0), glm::dvec3(2.0)}, 5000, 7);
  const auto steps = reference::randomPoints({glm::dvec3(-1e-7), glm::dvec3(1e-7)}, 5000, 8);
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_NEAR(sampleVolume(floor, points[i]), sampleVolume(floor, points[i] + steps[i]), 1e-6);
}

TEST(VolumeSampling, isContinuousAcrossTheBorderAndThroughZero) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Volume volume = noiseVolume(seed, -1.0, 1.0);
    const Box box = bounds(volume);
    const double slope = lipschitzBound(volume);
    for (const glm::dvec3& p : reference::randomPoints({box.min - 1.0, box.max + 1.0}, 200, seed + 100)) {
      const glm::dvec3 q = glm::clamp(p, box.min, box.max);
      const glm::dvec3 near = q + (p - q) * 1e-9;
      EXPECT_NEAR(sampleVolume(volume, near), sampleVolume(volume, q), slope * glm::length(near - q) + 1e-14);
    }
  }
}

TEST(VolumeLipschitz, isExactForLinearFields) {
  const glm::dvec3 gradient{1.5, -2.0, 0.0};
  const auto linear = [&](double offset) {
    return filled({4, 4, 4}, {0, 0, 0}, 0.25, [&](const glm::dvec3& p) { return offset + glm::dot(gradient, p); });
  };
  EXPECT_DOUBLE_EQ(lipschitzBound(linear(10.0)), 2.5);
  EXPECT_DOUBLE_EQ(lipschitzBound(linear(0.0)), std::sqrt(1.0 + 2.5 * 2.5));
  EXPECT_DOUBLE_EQ(lipschitzBound(filled({2, 2, 2}, {0, 0, 0}, 1.0, [](const glm::dvec3&) { return 3.0; })), 1.0);
}

TEST(VolumeLipschitz, staysWithinRootThreeForDistances) {
  EXPECT_LE(lipschitzBound(torusVolume()), std::sqrt(3.0) * (1.0 + 1e-5));
  EXPECT_GE(lipschitzBound(torusVolume()), 1.0);
}

/// |f(a) - f(b)| <= L |a - b| for f's bounds, for far and near pairs, inside, outside and across the border; f itself between them.
void expectLipschitz(const Volume& volume, std::uint64_t seed) {
  const double slope = lipschitzBound(volume);
  const Box box = bounds(volume);
  const Box around{box.min - 1.5, box.max + 1.5};
  const auto points = reference::randomPoints(around, 600, seed);
  const auto steps = reference::randomPoints({glm::dvec3(-1.0), glm::dvec3(1.0)}, 600, seed + 1);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (const double reach : {1e-4, 0.1, 2.0}) {
      const glm::dvec3 other = points[i] + steps[i] * reach;
      const double step = glm::length(points[i] - other), value = sampleVolume(volume, points[i]);
      const Bounds here = boundsAt(volume, points[i]), there = boundsAt(volume, other);
      ASSERT_GE(value, here.lower - 1e-13) << "seed " << seed << " point " << i;
      ASSERT_LE(value, here.upper + 1e-13) << "seed " << seed << " point " << i;
      ASSERT_LE(std::abs(here.lower - there.lower), slope * step + 1e-13) << "seed " << seed << " point " << i << " reach " << reach;
      ASSERT_LE(std::abs(here.upper - there.upper), std::hypot(1.0, slope) * step + 1e-13) << "seed " << seed << " point " << i;
    }
}

TEST(VolumeLipschitz, holdsForRandomPairsOnRandomFields) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    expectLipschitz(noiseVolume(seed, 0.0, 0.4), seed);    // gentle, border positive: L is 1 or little more
    expectLipschitz(noiseVolume(seed, -1.0, 1.0), seed);   // border partly inside
    expectLipschitz(noiseVolume(seed, -2.0, -1.0), seed);  // inside everywhere
  }
  expectLipschitz(torusVolume(), 99);
  expectLipschitz(asStored(torusVolume(), VolumeBits::snorm8), 98);
}

TEST(VolumeLipschitz, isReachedWhereTheBorderIsInside) {
  // Inside reaches the border at x = 0 with slope 1 along y: moving away from the box and along y adds up to sqrt(2).
  const Volume volume = filled({3, 3, 3}, {0, 0, 0}, 1.0, [](const glm::dvec3& p) { return p.y - 3.0; });
  const glm::dvec3 a{-1.0, 0.5, 1.0};
  const glm::dvec3 b = a + glm::dvec3(-0.1, 0.1, 0.0);
  EXPECT_NEAR((sampleVolume(volume, b) - sampleVolume(volume, a)) / glm::length(b - a), lipschitzBound(volume), 1e-12);
}

TEST(VolumeBits, followRangeAndVoxelSize) {
  Volume volume = torusVolume();
  EXPECT_EQ(chooseBits(volume), VolumeBits::half);
  EXPECT_EQ(chooseBits(volume, VolumeBits::single), VolumeBits::single);
  volume.distance[5] = 65504.0f;
  EXPECT_EQ(chooseBits(volume), VolumeBits::half);
  volume.distance[5] = -65505.0f;
  EXPECT_EQ(chooseBits(volume), VolumeBits::single);
  volume.distance[5] = 0.0f;
  volume.voxelSize = 6.1e-5;
  EXPECT_EQ(chooseBits(volume), VolumeBits::half);
  volume.voxelSize = 5.9e-5;
  EXPECT_EQ(chooseBits(volume), VolumeBits::single);
}

TEST(VolumeBits, halfKeepsElevenBitsDownToItsSmallestStep) {
  const Volume volume = torusVolume();
  const Volume stored = asStored(volume);
  for (std::size_t i = 0; i < volume.distance.size(); ++i)
    EXPECT_LE(std::abs(stored.distance[i] - volume.distance[i]), std::max(std::abs(volume.distance[i]) * 0x1p-11f, 0x1p-25f));
  EXPECT_FALSE(sameBits(stored.distance, volume.distance));
  expectSame(asStored(volume, VolumeBits::single), volume);
}

/// Every distance a whole multiple of the step, at most half a step off, none out of reach, and the step no larger than 4 bits need.
void expectQuantised(const Volume& stored, const Volume& volume) {
  double largest = 0.0;
  for (const float d : volume.distance) largest = std::max(largest, std::abs(double{d}));
  const double step = stored.step;
  ASSERT_GE(127.0 * step, largest);
  ASSERT_LE(127.0 * step, largest * 1.125 + 127.0 * 0x1p-126);
  for (std::size_t i = 0; i < volume.distance.size(); ++i) {
    const double count = stored.distance[i] / step;
    ASSERT_EQ(count, std::round(count));
    ASSERT_LE(std::abs(count), 127.0);
    ASSERT_LE(std::abs(double{stored.distance[i]} - volume.distance[i]), 0.5 * step);
  }
}

TEST(VolumeBits, eightAreWholeStepsOfTheLargestDistance) {
  expectQuantised(asStored(torusVolume(), VolumeBits::snorm8), torusVolume());
  const Volume ramp = filled({128, 2, 2}, {0, 0, 0}, 1.0, [](const glm::dvec3& p) { return p.x; });
  expectSame(asStored(asStored(ramp, VolumeBits::snorm8), VolumeBits::single), ramp);  // 0 .. 127 in steps of 1
  EXPECT_EQ(asStored(ramp, VolumeBits::snorm8).step, 1.0f);
  const Volume nothing = filled({2, 2, 2}, {0, 0, 0}, 1.0, [](const glm::dvec3&) { return -0.0; });
  EXPECT_TRUE(isWhole(asStored(nothing, VolumeBits::snorm8)));
  for (const double scale : {1e-30, 1e-6, 1.0, 1e6, 1e30}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const Volume noise = noiseVolume(seed, -0.7 * scale, (0.1 + 0.1 * static_cast<double>(seed)) * scale);
      expectQuantised(asStored(noise, VolumeBits::snorm8), noise);
    }
  }
}

TEST(VolumeBits, eightStayAsTheyAreUnlessAskedOtherwise) {
  const Volume stored = asStored(torusVolume(), VolumeBits::snorm8);
  EXPECT_EQ(chooseBits(stored), VolumeBits::snorm8);
  expectSame(asStored(stored), stored);
  expectSame(asStored(stored, VolumeBits::snorm8), stored);
  EXPECT_EQ(asStored(stored, VolumeBits::half).step, 0.0f);
  EXPECT_TRUE(sameBits(asStored(stored, VolumeBits::half).distance, stored.distance)) << "half floats hold them exactly";
}

TEST(VolumeBits, aStepThatDistancesDoNotKeepIsNotWhole) {
  Volume volume = asStored(torusVolume(), VolumeBits::snorm8);
  EXPECT_TRUE(isWhole(volume));
  Volume other = volume;
  other.step *= 0.5f;
  EXPECT_FALSE(isWhole(other)) << "beyond 127 steps";
  other = volume;
  other.distance[7] += 0.25f * volume.step;
  EXPECT_FALSE(isWhole(other));
  for (const float step : {-volume.step, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    other = volume;
    other.step = step;
    EXPECT_FALSE(isWhole(other)) << step;
  }
}

TEST(VolumeBits, haveNamesAndCounts) {
  EXPECT_EQ(std::string(name(VolumeBits::snorm8)), "snorm8");
  EXPECT_EQ(std::string(name(VolumeBits::single)), "single");
  EXPECT_EQ(bitCount(VolumeBits::snorm8), 8);
  EXPECT_EQ(bitCount(VolumeBits::half), 16);
  EXPECT_EQ(bitCount(VolumeBits::single), 32);
}

TEST(VolumeFile, comesBackBitForBit) {
  const TemporaryFolder folder;
  const Volume volume = torusVolume();
  for (const VolumeBits bits : {VolumeBits::automatic, VolumeBits::snorm8, VolumeBits::half, VolumeBits::single}) {
    const auto bytes = writeVolume(folder / "torus.vdb", volume, bits);
    ASSERT_TRUE(bytes) << message(bytes.error());
    EXPECT_EQ(bytes.value(), std::filesystem::file_size(folder / "torus.vdb"));
    const auto back = readVolume(folder / "torus.vdb");
    ASSERT_TRUE(back) << message(back.error());
    expectSame(back.value(), asStored(volume, bits));
  }
}

RC_GTEST_PROP(VolumeFile, comesBackBitForBitWhateverItHolds, ()) {
  const TemporaryFolder folder;
  Volume volume;
  for (int axis = 0; axis < 3; ++axis) volume.size[axis] = *rc::gen::inRange(2, 20);
  const auto number = [](double scale) { return scale * static_cast<double>(*rc::gen::arbitrary<std::int32_t>()) / 2147483648.0; };
  volume.origin = {number(1e5), number(1e-3), number(1.0)};
  volume.voxelSize = std::exp2(*rc::gen::inRange(-40, 40) + 0.3);
  volume.signMethod = *rc::gen::arbitrary<std::string>();
  volume.inside = *rc::gen::element(Inside::unstated, Inside::solid, Inside::open, Inside::partly, Inside::none);
  volume.sheetThickness = volume.inside == Inside::none ? volume.voxelSize / 3.0 : 0.0;
  for (std::size_t n = sampleIndex(volume, 0, 0, volume.size.z); n > 0; --n)
    volume.distance.push_back(static_cast<float>(number(volume.voxelSize * 20)));
  const VolumeBits bits = *rc::gen::element(VolumeBits::snorm8, VolumeBits::single);
  volume = asStored(std::move(volume), bits);
  const auto written = writeVolume(folder / "any.vdb", volume, bits);
  RC_ASSERT(written.ok());
  const auto back = readVolume(folder / "any.vdb");
  RC_ASSERT(back.ok());
  RC_ASSERT(back.value().size == volume.size);
  RC_ASSERT(back.value().origin == volume.origin);
  RC_ASSERT(back.value().voxelSize == volume.voxelSize);
  RC_ASSERT(back.value().signMethod == volume.signMethod);
  RC_ASSERT(back.value().inside == volume.inside && back.value().sheetThickness == volume.sheetThickness);
  RC_ASSERT(back.value().step == volume.step);
  RC_ASSERT(sameBits(back.value().distance, volume.distance));
}

TEST(VolumeFile, keepsExtremeScalesAndPlaces) {
  const TemporaryFolder folder;
  for (const double scale : {1e-9, 1e-6, 1.4e-5, 1.0, 1e6, 1e12}) {
    const auto field = [&](const glm::dvec3& p) { return reference::sphereDistance(p / scale - 1e5, 2.0) * scale; };
    const Volume volume = filled({9, 9, 9}, glm::dvec3(1e5 - 4.0) * scale, scale, field);
    for (const VolumeBits bits : {VolumeBits::automatic, VolumeBits::snorm8}) {
      ASSERT_TRUE(writeVolume(folder / "extreme.vdb", volume, bits));
      const auto back = readVolume(folder / "extreme.vdb");
      ASSERT_TRUE(back) << scale << ": " << message(back.error());
      expectSame(back.value(), asStored(volume, bits));
    }
  }
}

TEST(VolumeFile, hasTheSameBytesForAnyThreadCount) {
  const TemporaryFolder folder;
  std::vector<std::byte> first;
  for (const std::size_t threads : {1u, 2u, 4u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    ASSERT_TRUE(writeVolume(folder / "same.vdb", torusVolume()));
    const auto bytes = fileBytes(folder / "same.vdb");
    if (first.empty()) first = bytes;
    EXPECT_EQ(bytes, first);
  }
  Volume other = torusVolume();
  other.distance[100] += 0.5f;
  ASSERT_TRUE(writeVolume(folder / "other.vdb", other));
  const auto uuid = [](const std::vector<std::byte>& bytes) { return std::vector<std::byte>(bytes.begin() + 21, bytes.begin() + 57); };
  EXPECT_NE(uuid(fileBytes(folder / "other.vdb")), uuid(first));
}

TEST(VolumeFile, isNoLargerThanNeedBe) {
  const TemporaryFolder folder;
  const Volume volume =
      filled({64, 48, 40}, {-1.6, -1.2, -1.0}, 0.05, [](const glm::dvec3& p) { return reference::torusDistance(p, 1.0, 0.4); });
  const auto bytes = writeVolume(folder / "torus.vdb", volume);
  ASSERT_TRUE(bytes);
  EXPECT_LT(bytes.value(), volume.distance.size() * 2 * 11 / 10);  // raw half floats and a tenth
  const auto eight = writeVolume(folder / "torus.vdb", volume, VolumeBits::snorm8);
  ASSERT_TRUE(eight);
  EXPECT_LT(eight.value(), volume.distance.size() * 12 / 10);  // a byte and a fifth, of which the tree's own masks are 0.07
}

TEST(VolumeFile, refusesDistancesThatHalfCannotHold) {
  const TemporaryFolder folder;
  Volume volume = torusVolume();
  ASSERT_TRUE(writeVolume(folder / "old.vdb", volume));
  const auto before = fileBytes(folder / "old.vdb");
  volume.distance[0] = 1e6f;
  const auto refused = writeVolume(folder / "old.vdb", volume, VolumeBits::half);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().reason.find("half float"), std::string::npos);
  EXPECT_EQ(fileBytes(folder / "old.vdb"), before);
  EXPECT_TRUE(writeVolume(folder / "old.vdb", volume));
}

TEST(VolumeFile, missingOrForeignBytesAreErrors) {
  const TemporaryFolder folder;
  const auto missing = readVolume(folder / "missing.vdb");
  ASSERT_FALSE(missing);
  EXPECT_NE(message(missing.error()).find("missing.vdb"), std::string::npos);
  putBytes(folder / "empty.vdb", {});
  EXPECT_FALSE(readVolume(folder / "empty.vdb"));
  putBytes(folder / "text.vdb", std::vector<std::byte>(5000, std::byte{'a'}));
  const auto text = readVolume(folder / "text.vdb");
  ASSERT_FALSE(text);
  EXPECT_NE(text.error().reason.find("OpenVDB"), std::string::npos);
}

TEST(VolumeFile, cutShortIsAnError) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writeVolume(folder / "whole.vdb", torusVolume()));
  const auto whole = fileBytes(folder / "whole.vdb");
  for (std::size_t part = 0; part < 60; ++part) {
    auto bytes = whole;
    bytes.resize(whole.size() * part / 60);
    putBytes(folder / "cut.vdb", bytes);
    EXPECT_FALSE(readVolume(folder / "cut.vdb")) << bytes.size() << " of " << whole.size();
  }
}

TEST(VolumeFile, accidentsEndInAVolumeOrAnError) {
  const TemporaryFolder folder;
  ASSERT_TRUE(writeVolume(folder / "half.vdb", torusVolume()));
  ASSERT_TRUE(writeVolume(folder / "eight.vdb", torusVolume(), VolumeBits::snorm8));
  const auto half = fileBytes(folder / "half.vdb"), eight = fileBytes(folder / "eight.vdb");
  SandboxLimits limits;
  limits.wallTime = std::chrono::milliseconds(500);
  int errors = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    putBytes(folder / "accident.vdb", mutated(seed % 3 == 0 ? eight : half, seed));
    const auto volume = readVolume(folder / "accident.vdb", limits);
    if (volume) {
      EXPECT_TRUE(isWhole(volume.value())) << seed;
    } else {
      ++errors;
      EXPECT_NE(message(volume.error()).find("accident.vdb: "), std::string::npos) << seed;
      EXPECT_EQ(message(volume.error()).find('\n'), std::string::npos) << seed;
    }
  }
  EXPECT_GT(errors, 100);
}

}  // namespace
}  // namespace overcast
