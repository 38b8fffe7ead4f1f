#include "runtime/atlas.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <glm/vector_relational.hpp>

namespace overcast {
namespace {

constexpr AtlasLimits kRoomy{4096, std::uint64_t{1} << 34, 2};

bool overlap(const glm::ivec3& a, const glm::ivec3& sizeA, const glm::ivec3& b, const glm::ivec3& sizeB) {
  return glm::all(glm::lessThan(a, b + sizeB)) && glm::all(glm::lessThan(b, a + sizeA));
}

void expectSound(const std::vector<glm::ivec3>& sizes, const AtlasLayout& layout) {
  for (int axis = 0; axis < 3; ++axis) RC_ASSERT((layout.extent[axis] & (layout.extent[axis] - 1)) == 0);
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    RC_ASSERT(glm::all(glm::greaterThanEqual(layout.offsets[i], glm::ivec3(0))));
    RC_ASSERT(glm::all(glm::lessThanEqual(layout.offsets[i] + sizes[i], layout.extent)));
    for (std::size_t j = 0; j < i; ++j) RC_ASSERT(!overlap(layout.offsets[i], sizes[i], layout.offsets[j], sizes[j]));
  }
}

RC_GTEST_PROP(Atlas, PackedVolumesAreInsideAndApart, ()) {
  const auto side = rc::gen::inRange(2, 70);
  std::vector<glm::ivec3> sizes(static_cast<std::size_t>(*rc::gen::inRange(1, 60)));
  for (glm::ivec3& size : sizes) size = {*side, *side, *side};
  const Result<AtlasLayout> layout = packAtlas(sizes, kRoomy);
  RC_ASSERT(layout.ok());
  expectSound(sizes, layout.value());
  RC_ASSERT(packAtlas(sizes, kRoomy).value().offsets == layout.value().offsets);
}

TEST(Atlas, OneVolumeOfPowersOfTwoWastesNothing) {
  EXPECT_EQ(packAtlas(std::vector<glm::ivec3>{{32, 16, 64}}, kRoomy).value().extent, glm::ivec3(32, 16, 64));
  EXPECT_EQ(packAtlas({}, kRoomy).value().extent, glm::ivec3(1));
}

TEST(Atlas, ManyEqualVolumesFillAtLeastHalf) {
  const std::vector<glm::ivec3> sizes(100, glm::ivec3(32, 21, 25));
  const glm::ivec3 extent = packAtlas(sizes, kRoomy).value().extent;
  EXPECT_LE(double(extent.x) * extent.y * extent.z, 2.0 * 100 * 32 * 21 * 25);
}

TEST(Atlas, WhatDoesNotFitIsAnErrorThatSaysHowMuch) {
  const Result<AtlasLayout> tooLong = packAtlas(std::vector<glm::ivec3>{{300, 4, 4}}, {256, std::uint64_t{1} << 30, 2});
  ASSERT_FALSE(tooLong.ok());
  EXPECT_NE(message(tooLong.error()).find("300 x 4 x 4"), std::string::npos) << message(tooLong.error());
  EXPECT_NE(message(tooLong.error()).find("256"), std::string::npos);

  const Result<AtlasLayout> tooMany = packAtlas(std::vector<glm::ivec3>(9, glm::ivec3(64)), {128, std::uint64_t{1} << 30, 2});
  ASSERT_FALSE(tooMany.ok());
  EXPECT_NE(message(tooMany.error()).find("9 local volumes"), std::string::npos) << message(tooMany.error());

  const Result<AtlasLayout> tooBig = packAtlas(std::vector<glm::ivec3>{glm::ivec3(128)}, {128, 1u << 20, 2});
  ASSERT_FALSE(tooBig.ok());
  EXPECT_NE(message(tooBig.error()).find("4 MiB"), std::string::npos) << message(tooBig.error());
}

}  // namespace
}  // namespace overcast
