#include "bake/choose.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/reference/shapes.h"

namespace overcast {
namespace {

using namespace reference;

ChoiceSettings small() {
  ChoiceSettings settings;
  settings.measure.samples = 1000;
  settings.largest = 64;
  return settings;
}

Choice chosen(const Mesh& mesh, const ChoiceSettings& settings) {
  auto result = choose(mesh, settings);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : message(result.error()));
  return result.ok() ? std::move(result).value() : Choice{};
}

const Score& winner(const Choice& choice) {
  return choice.record.scores.at(choice.record.chosen);
}

const Mesh& ring() {
  static const Mesh mesh = torusMesh(1.0, 0.4, 48, 24);
  return mesh;
}

TEST(Choose, TheCheapestWithinTheErrorWins) {
  for (const double allowed : {0.02, 0.01, 0.003}) {
    ChoiceSettings settings = small();
    settings.maxError = allowed;
    const Choice choice = chosen(ring(), settings);
    const ChoiceRecord& record = choice.record;
    ASSERT_TRUE(record.withinLimits);
    EXPECT_EQ(winner(choice).reason, "chosen");
    EXPECT_LE(winner(choice).error.surfaceRms, allowed * record.diagonal);
    EXPECT_EQ(winner(choice).error.samples, 1000u);
    for (const Score& score : record.scores) {
      EXPECT_FALSE(score.reason.empty());
      if (score.error.samples > 0 && score.error.surfaceRms <= allowed * record.diagonal) {
        EXPECT_GE(score.bytes, winner(choice).bytes);
      }
    }
  }
}

TEST(Choose, LessErrorNeverCostsFewerBytes) {
  ChoiceSettings settings = small();
  settings.only = Representation::volume;
  std::uint64_t last = 0;
  for (const double allowed : {0.05, 0.02, 0.01, 0.005, 0.003}) {
    settings.maxError = allowed;
    const std::uint64_t bytes = winner(chosen(ring(), settings)).bytes;
    EXPECT_GE(bytes, last) << allowed;
    last = bytes;
  }
}

TEST(Choose, MaxBytesAreRespectedAndUsed) {
  double last = 1e300;
  for (const std::uint64_t allowed : {12000u, 20000u, 100000u}) {
    ChoiceSettings settings = small();
    settings.only = Representation::volume;
    settings.maxBytes = allowed;
    const Choice choice = chosen(ring(), settings);
    EXPECT_LE(winner(choice).bytes, allowed);
    for (const Score& score : choice.record.scores) {
      if (score.bytes <= allowed && score.bytes > 0) {
        EXPECT_GE(score.error.surfaceRms, winner(choice).error.surfaceRms);
      }
    }
    EXPECT_LT(winner(choice).error.surfaceRms, last);
    last = winner(choice).error.surfaceRms;
  }
  ChoiceSettings settings = small();
  settings.maxBytes = 10;
  EXPECT_FALSE(choose(ring(), settings).ok());
}

TEST(Choose, BothLimitsGiveWayToTheBytes) {
  ChoiceSettings settings = small();
  settings.only = Representation::volume;
  settings.maxError = 1e-6;
  settings.maxBytes = 20000;
  const Choice choice = chosen(ring(), settings);
  EXPECT_FALSE(choice.record.withinLimits);
  EXPECT_LE(winner(choice).bytes, 20000u);
  EXPECT_EQ(winner(choice).error.samples, 1000u);
}

TEST(Choose, WhatIsMeasuredIsWhatIsKept) {
  const Choice choice = chosen(ring(), small());
  const MeasuredError again = measure(choice.asset, drawProbes(ring(), small().measure));
  EXPECT_EQ(again.surfaceRms, winner(choice).error.surfaceRms);
  EXPECT_EQ(again.max, winner(choice).error.max);
  EXPECT_EQ(representationOf(choice.asset), winner(choice).candidate.representation);
}

TEST(Choose, SameRecordForAnyThreadCount) {
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return chosen(ring(), small());
  };
  const Choice one = run(1), four = run(4);
  EXPECT_EQ(one.record.chosen, four.record.chosen);
  ASSERT_EQ(one.record.scores.size(), four.record.scores.size());
  for (std::size_t i = 0; i < one.record.scores.size(); ++i) {
    EXPECT_EQ(one.record.scores[i].bytes, four.record.scores[i].bytes);
    EXPECT_EQ(one.record.scores[i].error.surfaceRms, four.record.scores[i].error.surfaceRms);
    EXPECT_EQ(one.record.scores[i].reason, four.record.scores[i].reason);
  }
}

TEST(Choose, EverythingIsMeasuredAndTimedForReports) {
  ChoiceSettings settings = small();
  settings.everything = true;
  settings.largest = 16;
  const Choice choice = chosen(ring(), settings);
  std::size_t volumes = 0;
  for (const Score& score : choice.record.scores) {
    if (score.error.samples == 0) continue;
    volumes += score.candidate.representation == Representation::volume;
    EXPECT_EQ(score.error.samples, 1000u);
    ASSERT_TRUE(score.time.has_value());
    EXPECT_LE(score.time->least, score.time->median);
    EXPECT_LE(score.time->median, score.time->most);
  }
  EXPECT_EQ(volumes, 9u);  // 8, 12 and 16, of 8 bits, half and single
}

TEST(Choose, ShapesFindTheirRepresentation) {
  EXPECT_EQ(winner(chosen(boxMesh({1.0, 0.5, 0.25}), small())).candidate.shape, PrimitiveShape::cuboid);
  EXPECT_EQ(winner(chosen(icosphere(1.0, 3), small())).candidate.shape, PrimitiveShape::ellipsoid);
  // A ring is two heights back to back; with a ball over its rim neither side of anything shows all of it.
  EXPECT_EQ(winner(chosen(ring(), small())).candidate.representation, Representation::heightfield);
  const Mesh both = joined(ring(), moved(icosphere(0.5, 2), {1.0, 1.2, 0.3}));
  EXPECT_EQ(winner(chosen(both, small())).candidate.representation, Representation::volume);
}

TEST(Choose, AnInterruptStops) {
  const auto stopped = choose(ring(), small(), [](double) { return false; });
  ASSERT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.error().reason, "interrupted");
}

TEST(Choose, NothingToChooseForIsAnError) {
  EXPECT_FALSE(choose(Mesh{}, small()).ok());
  EXPECT_FALSE(choose(scaled(ring(), 0.0), small()).ok());
}

}  // namespace
}  // namespace overcast
