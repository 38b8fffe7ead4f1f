#include "bake/pareto_svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace overcast {
namespace {

TEST(Pareto, TheFrontIsWhatNothingBeats) {
  const std::vector<ParetoPoint> points = {{0, 10, 5}, {1, 1, 9}, {2, 10, 6}, {3, 20, 5}, {4, 30, 1}, {5, 5, 9}, {6, 10, 5}};
  std::vector<std::size_t> front;
  for (const ParetoPoint& point : paretoFront(points)) front.push_back(point.score);
  EXPECT_EQ(front, (std::vector<std::size_t>{1, 0, 4}));
  EXPECT_TRUE(paretoFront({}).empty());
}

TEST(Pareto, NamesAreEscapedAndUnmeasuredCandidatesLeftOut) {
  ExplainedMesh mesh{"a<b>&c", {}};
  mesh.record.diagonal = 2.0;
  mesh.record.scores.resize(2);
  mesh.record.scores[0].candidate.size = 8;
  mesh.record.scores[0].bytes = 1000;
  mesh.record.scores[0].error.samples = 10;
  mesh.record.scores[0].error.surfaceRms = 0.02;
  mesh.record.scores[1].candidate.size = 9;
  const std::string svg = paretoSvg({mesh});
  EXPECT_THAT(svg, testing::HasSubstr("a&lt;b&gt;&amp;c"));
  EXPECT_THAT(svg, testing::HasSubstr("volume 8"));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("volume 9")));
  EXPECT_THAT(paretoSvg({}), testing::EndsWith("</svg>\n"));
}

}  // namespace
}  // namespace overcast
