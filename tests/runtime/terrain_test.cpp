// Which clusters of a terrain a frame draws: no more than a pixel off, and nothing twice.
#include "runtime/terrain_levels.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

namespace overcast {
namespace {

constexpr int kWidth = 320, kHeight = 180;
constexpr double kAspect = static_cast<double>(kWidth) / kHeight;

View viewFrom(const glm::dvec3& eye, const glm::dvec3& target) {
  return lookAt(eye, target, {0.0, 1.0, 0.0}, 0.9);
}

/// Two roots that share a group, four clusters below in two groups, eight finest: triangles are numbered by their cluster.
MeshLevels threeDepths() {
  MeshLevels levels;
  levels.groups = {{{-4.0f, 0.0f, 0.0f}, 3.0f, 0.5f}, {{4.0f, 0.0f, 0.0f}, 3.0f, 0.25f}, {{0.0f, 0.0f, 0.0f}, 8.0f, 2.0f}};
  std::uint32_t next = 0;
  const auto add = [&](std::uint32_t count, std::uint32_t own, std::uint32_t coarser) {
    levels.clusters.push_back({next, count, own, coarser});
    next += count;
  };
  for (int i = 0; i < 8; ++i) add(10, kNoLevelGroup, i < 4 ? 0 : 1);
  for (int i = 0; i < 4; ++i) add(10, i < 2 ? 0 : 1, 2);
  for (int i = 0; i < 2; ++i) add(10, 2, kNoLevelGroup);
  return levels;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> runsOf(const MeshLevels& levels, const View& view, double error) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> runs;
  for (const TriangleRun& run : chooseLevels(levels, glm::dmat4(1.0), levelView(view, kAspect, kHeight, error)))
    runs.emplace_back(run.first, run.count);
  return runs;
}

using Runs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

TEST(TerrainLevels, areAsFineAsTheViewAsks) {
  const MeshLevels levels = threeDepths();
  const View far = viewFrom({0.0, 0.0, 4000.0}, {0.0, 0.0, 0.0}), near = viewFrom({0.0, 40.0, 40.0}, {0.0, 0.0, 0.0});
  EXPECT_EQ(runsOf(levels, far, 1.0), (Runs{{120, 20}}));
  EXPECT_EQ(runsOf(levels, near, 0.0), (Runs{{0, 80}})) << "all finest triangles in one run";
  // About 215 pixels for 1 m at 1 m, 48 m away: 0.5 m are some 2.3 pixels or more, 0.25 m half of that.
  EXPECT_EQ(runsOf(levels, near, 2.0), (Runs{{0, 40}, {100, 20}}));
  EXPECT_EQ(runsOf(levels, near, 6.0), (Runs{{80, 40}}));
  EXPECT_EQ(runsOf(levels, viewFrom({0.0, 1.0, 0.0}, {5.0, 0.0, 0.0}), 1e6), (Runs{{100, 20}}))
      << "within the ball of the roots; one group is behind";
}

TEST(TerrainLevels, leaveOutWhatIsBehindTheEye) {
  const MeshLevels levels = threeDepths();
  EXPECT_EQ(runsOf(levels, viewFrom({0.0, 0.0, 30.0}, {0.0, 0.0, 60.0}), 0.0), Runs{});
  // From the middle towards +x: the group at -x is behind.
  EXPECT_EQ(runsOf(levels, viewFrom({2.0, 0.0, 0.0}, {5.0, 0.0, 0.0}), 0.0), (Runs{{40, 40}}));
}

TEST(TerrainLevels, neverMoveAPointByMorePixelsThanTheySay) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  double tightest = 0.0;
  for (int trial = 0; trial < 20000; ++trial) {
    const glm::dvec3 eye(3.0 * unit(random), 2.0 * unit(random), 30.0);
    const View view = viewFrom(eye, {5.0 * unit(random), 5.0 * unit(random), 0.0});
    glm::dmat4 world = glm::rotate(glm::dmat4(1.0), 3.0 * unit(random), glm::dvec3(unit(random), 1.0, unit(random)));
    if (trial % 2 == 0) world = glm::scale(world, glm::dvec3(1.0 + unit(random) * 0.5, 1.2, 0.7));
    LevelGroup group{{static_cast<float>(9.0 * unit(random)), static_cast<float>(5.0 * unit(random)), static_cast<float>(unit(random))},
                     static_cast<float>(0.1 + std::abs(unit(random))),
                     0.01f};
    const LevelView levels = levelView(view, kAspect, kHeight, 1.0);
    const double stated = levelPixels(group, world, levels);
    // A point of the ball, and the same point moved by the error any way.
    const glm::dvec3 inBall = glm::dvec3(group.centre) + 0.57 * double{group.radius} * glm::dvec3(unit(random), unit(random), unit(random));
    const glm::dvec3 moved = inBall + 0.01 * glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
    const auto pixel = [&](const glm::dvec3& p) {
      const glm::dvec4 clip = levels.clipFromRelative * glm::dvec4(glm::dvec3(world * glm::dvec4(p, 1.0)) - levels.eye, 1.0);
      return glm::dvec2(clip.x / clip.w * 0.5 * kWidth, clip.y / clip.w * 0.5 * kHeight);
    };
    const glm::dvec2 before = pixel(inBall);
    if (std::abs(before.x) > 0.5 * kWidth || std::abs(before.y) > 0.5 * kHeight) continue;
    const double shift = glm::length(pixel(moved) - before);
    ASSERT_LE(shift, stated * 1.001) << trial;
    tightest = std::max(tightest, shift / stated);
  }
  EXPECT_GT(tightest, 0.5);
}

TEST(TerrainLevels, withinTheBallAreInfinitelyCoarse) {
  const LevelGroup group{{0.0f, 0.0f, 0.0f}, 2.0f, 0.1f};
  const LevelView view = levelView(viewFrom({0.0, 1.0, 0.0}, {0.0, 0.0, -5.0}), kAspect, kHeight, 1.0);
  EXPECT_EQ(levelPixels(group, glm::dmat4(1.0), view), std::numeric_limits<double>::infinity());
  EXPECT_EQ(levelPixels({{0.0f, 0.0f, 0.0f}, 2.0f, 0.0f}, glm::dmat4(1.0), view), 0.0);
}

}  // namespace
}  // namespace overcast
