#include "bake/choose.h"

#include <algorithm>
#include <cmath>

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
    EXPECT_LE(winner(choice).error.skyRmse, settings.maxSkyError);
    for (const Score& score : record.scores) {
      EXPECT_FALSE(score.reason.empty());
      if (score.error.samples == 0 || score.error.surfaceRms > allowed * record.diagonal) continue;
      EXPECT_TRUE((1.0 + kSameBytes) * static_cast<double>(score.bytes) >= static_cast<double>(winner(choice).bytes) ||
                  score.error.skyRmse > settings.maxSkyError || score.error.signErrors > 0)
          << name(score.candidate);
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

TEST(Choose, EverythingIsMeasuredForReports) {
  ChoiceSettings settings = small();
  settings.everything = true;
  settings.largest = 16;
  const Choice choice = chosen(ring(), settings);
  std::size_t volumes = 0;
  for (const Score& score : choice.record.scores) {
    if (score.error.samples == 0) continue;
    volumes += score.candidate.representation == Representation::volume;
    EXPECT_EQ(score.error.samples, 1000u);
    EXPECT_GT(score.composite, 0.0);
  }
  EXPECT_EQ(volumes, 9u);  // 8, 12 and 16, of 8 bits, half and single
}

TEST(Choose, ShapesFindTheirRepresentation) {
  EXPECT_EQ(winner(chosen(boxMesh({1.0, 0.5, 0.25}), small())).candidate.shape, PrimitiveShape::cuboid);
  EXPECT_EQ(winner(chosen(icosphere(1.0, 3), small())).candidate.shape, PrimitiveShape::ellipsoid);
  // A ring is two heights back to back; with a ball over its rim neither side of anything shows all of it.
  ChoiceSettings settings = small();
  settings.maxSkyError = 0.06;
  EXPECT_EQ(winner(chosen(ring(), settings)).candidate.representation, Representation::heightfield);
  const Mesh both = joined(ring(), moved(icosphere(0.5, 2), {1.0, 1.2, 0.3}));
  EXPECT_EQ(winner(chosen(both, small())).candidate.representation, Representation::volume);
}

/// Hills over a square, facing up.
Mesh hills(int cells) {
  Mesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = 4.0 * i / cells - 2.0, z = 4.0 * j / cells - 2.0;
      mesh.positions.emplace_back(x, 0.3 * std::sin(2.0 * x) * std::cos(1.5 * z), z);
    }
  const auto at = [&](int i, int j) { return static_cast<unsigned>(i + (cells + 1) * j); };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      mesh.triangles.emplace_back(at(i, j), at(i, j + 1), at(i + 1, j));
      mesh.triangles.emplace_back(at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
    }
  return mesh;
}

/// Its ball, pressed and dented like an asteroid: a star shape that is no primitive.
Mesh asteroid() {
  Mesh mesh = icosphere(1.0, 4);
  for (glm::dvec3& p : mesh.positions)
    p *= glm::dvec3(1.3, 0.9, 1.0) * (1.0 + 0.12 * std::sin(3.0 * p.x + 1.0) * std::sin(2.5 * p.y) + 0.08 * std::sin(4.0 * p.z));
  return mesh;
}

TEST(Choose, TerrainAndAsteroidsAreFoundWhicheverWayTheyLie) {
  for (const bool turned : {false, true}) {
    Mesh terrain = hills(48), rock = asteroid();
    if (turned)
      for (Mesh* mesh : {&terrain, &rock})
        for (glm::dvec3& p : mesh->positions) p = glm::dvec3(0.6 * p.x - 0.8 * p.y, 0.8 * p.x + 0.6 * p.y, p.z);
    const Choice ground = chosen(terrain, small());
    EXPECT_EQ(winner(ground).candidate.representation, Representation::heightfield) << name(winner(ground).candidate);
    EXPECT_FALSE(winner(ground).candidate.otherSide);
    const Choice star = chosen(rock, small());
    EXPECT_EQ(winner(star).candidate.representation, Representation::radius) << name(winner(star).candidate);
  }
}

// The sky alone may rule a candidate out, and the reason says so.
TEST(Choose, TheSkyErrorAllowedIsKept) {
  ChoiceSettings settings = small();
  double last = 0.0;
  for (const double allowed : {0.1, 0.02, 0.01}) {
    settings.maxSkyError = allowed;
    const Choice choice = chosen(ring(), settings);
    EXPECT_LE(winner(choice).error.skyRmse, allowed);
    const auto bytes = static_cast<double>(winner(choice).bytes);
    EXPECT_GE((1.0 + kSameBytes) * bytes, last);
    last = bytes;
  }
  settings.maxSkyError = 1e-6;
  const Choice none = chosen(ring(), settings);
  EXPECT_FALSE(none.record.withinLimits);
  EXPECT_NE(none.record.scores[0].reason, "chosen");
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
