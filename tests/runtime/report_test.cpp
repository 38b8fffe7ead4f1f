// Reports: statistics, fronts, choices, comparisons, tables and pages of made-up figures. No device.
#include <algorithm>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "runtime/passes/shade/shade.h"
#include "runtime/report/as_printed.h"
#include "runtime/report/chart.h"
#include "runtime/report/choice.h"
#include "runtime/report/compare.h"
#include "runtime/report/page.h"
#include "runtime/report/statistics.h"
#include "runtime/report/table.h"
#include "runtime/report/timing.h"

namespace overcast {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

ReportRow row(const std::string& setting, double rmse, double milliseconds, const std::string& technique = "overcast") {
  ReportRow made;
  made.setting = setting;
  made.technique = technique;
  made.storable = technique == "overcast";
  if (made.storable) made.estimator = "published";
  made.errors.rmse = made.errors.rmseCorrected = rmse;
  made.errors.flicker = 0.1 * rmse;
  made.frame = {milliseconds, 1.1 * milliseconds, 0.1 * milliseconds, 5};
  made.still = {0.5 * milliseconds, 0.5 * milliseconds, 0.05 * milliseconds, 5};
  made.gpuBytes = 1000;
  return made;
}

Report reportOf(const std::vector<ReportRow>& rows) {
  Report report{"device", "CPU", "driver", "1.3", 240, 135, 640, 360, 7, 0.0, "", {}};
  report.scenes.push_back({"room", "hash", 1, 100, 0.001, 1, {}, rows});
  return report;
}

std::vector<std::string> changesOf(const Report& before, const Report& after) {
  std::vector<std::string> found;
  for (const Change& change : compareReports(before, after).changes)
    found.push_back(fmt::format("{} {} {}", change.setting, change.figure, change.worse ? "worse" : "better"));
  return found;
}

TEST(ReportStatistics, AreOfSortedRounds) {
  EXPECT_EQ(median({3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median({4.0, 1.0, 2.0, 3.0}), 2.5);
  EXPECT_EQ(median({}), 0.0);
  std::vector<double> hundred;
  for (int i = 100; i > 0; --i) hundred.push_back(i);
  EXPECT_EQ(percentile(hundred, 0.95), 95.0);
  EXPECT_EQ(percentile({7.0}, 0.05), 7.0);
  const ReportTime time = timeOf(hundred);
  EXPECT_EQ(time.median, 50.5);
  EXPECT_EQ(time.p95, 95.0);
  EXPECT_DOUBLE_EQ(kConfidence * kMedianSpread * time.noise / 10.0, 25.5) << "to the farther quartile";
  EXPECT_DOUBLE_EQ(timeOf({10.0, 11.0, 9.0, 10.5, 900.0}).noise, 1.4826 * 0.5) << "one that was disturbed";
  const ReportTime disturbed = timeOf({10.0, 14.0, 14.1});
  EXPECT_DOUBLE_EQ(kConfidence * kMedianSpread * disturbed.noise / std::sqrt(3.0), 4.0) << "two of three";
}

TEST(ReportStatistics, LeaveCompositeAndPyramidOutWhileStill) {
  const auto round = [](double scale) {
    return std::vector<PassTime>{
        {"composite", 8.0 * scale, false}, {"pyramid", 2.0 * scale, false}, {"shade", 3.0 * scale, false}, {"idle", 5.0, true}};
  };
  const RoundTimes times = timesOf({round(1.0), round(2.0), round(3.0)});
  EXPECT_DOUBLE_EQ(times.frame.median, 26.0);
  EXPECT_DOUBLE_EQ(times.still.median, 6.0);
  ASSERT_EQ(times.passes.size(), 3u) << "a pass that never runs is none";
  EXPECT_EQ(times.passes[1].name, "pyramid");
  EXPECT_DOUBLE_EQ(times.passes[1].time.median, 4.0);
  EXPECT_EQ(times.frame.rounds, 3);
}

TEST(ReportStatistics, AddACompositeThatWasTimedForAll) {
  const std::vector<PassTime> frame{{"composite", 0.0, true}, {"pyramid", 2.0, false}, {"shade", 3.0, false}};
  const RoundTimes times = timesOf({frame, frame, frame, frame, frame}, {10.0, 20.0, 30.0});
  EXPECT_DOUBLE_EQ(times.frame.median, 25.0);
  EXPECT_DOUBLE_EQ(times.still.median, 3.0);
  EXPECT_EQ(times.frame.rounds, 3) << "the fewest of its parts";
  EXPECT_EQ(times.still.rounds, 5);
  ASSERT_EQ(times.passes.size(), 3u);
  EXPECT_EQ(times.passes[0].name, "composite");
  EXPECT_GE(times.frame.noise, times.passes[0].time.noise);
}

TEST(ReportStatistics, TellsTheMachineFromTheSettings) {
  const std::vector<double> slow{1.0, 1.0, 2.0, 0.9, 1.0, 5.0, 1.0};
  std::vector<std::vector<double>> rounds;
  for (const double own : {3.0, 70.0, 0.2, 900.0, 11.0}) {
    rounds.emplace_back();
    for (const double factor : slow) rounds.back().push_back(own * factor);
  }
  rounds[1][0] = rounds[1][2] = rounds[3][1] = rounds[3][5] = 0.0;  // did not draw
  rounds[2][4] *= 8.0;                                              // alone disturbed
  const std::vector<double> factors = roundFactors(rounds);
  for (std::size_t i = 0; i < slow.size(); ++i) EXPECT_NEAR(factors[i], slow[i], 1e-9) << i;
  EXPECT_TRUE(roundFactors({}).empty());
  EXPECT_EQ(roundFactors({{0.0, 0.0}}), (std::vector<double>{1.0, 1.0}));
}

TEST(ReportStatistics, TellsDriftFromWhatRepeatsOtherwise) {
  Report report = reportOf({row("a", 0.1, 10.0)});
  Report steady = report;
  stateNoise(steady, {}, {});
  EXPECT_EQ(steady.drift, 0.0);
  stateNoise(report, {1.0, 1.0}, {1.1 * 1.3, 1.3 / 1.1, 1.3, 1.3});
  EXPECT_NEAR(report.drift, std::log(1.3), 1e-12) << "all took longer";
  EXPECT_NEAR(report.scenes[0].rows[0].frame.noise, std::hypot(steady.scenes[0].rows[0].frame.noise, 10.0 * std::log(1.1)), 1e-9);
  stateNoise(steady, {1.0, 2.0, 0.5, 1.0}, {1.0});
  EXPECT_NEAR(steady.drift, std::log(2.0), 1e-12) << "rounds differed";
}

/// A run of a machine: every setting takes its time in rounds that scatter, some of them disturbed, under a load that goes up and down and
/// differs from run to run.
Report simulatedRun(std::mt19937& random, const std::vector<double>& settings, double slower, double load) {
  std::normal_distribution<double> normal(0.0, 1.0);
  std::bernoulli_distribution disturbed(0.05);
  const TimingSettings timing;
  const auto session = [&] {
    const double level = load * normal(random);
    std::vector<std::vector<double>> rounds(settings.size(), std::vector<double>(static_cast<std::size_t>(timing.rounds), 0.0));
    for (int round = 0; round < timing.rounds; ++round) {
      const double busy = std::exp(level + load * normal(random));
      for (std::size_t i = 0; i < settings.size(); ++i)
        if (drawsIn(round, roundsOf(settings[i], timing), timing.rounds))
          rounds[i][static_cast<std::size_t>(round)] =
              settings[i] * (i == 0 ? slower : 1.0) * busy * (1.0 + 0.02 * normal(random)) * (disturbed(random) ? 1.4 : 1.0);
    }
    return rounds;
  };
  const auto timed = [&](std::vector<std::vector<double>> rounds, std::vector<double>& factors) {
    factors = roundFactors(rounds);
    std::vector<ReportTime> times;
    for (std::vector<double>& own : rounds) {
      for (std::size_t i = 0; i < own.size(); ++i) own[i] /= factors[i];
      std::erase(own, 0.0);
      times.push_back(timeOf(own));
    }
    return times;
  };
  std::vector<double> factors, unused, ratios;
  const std::vector<ReportTime> first = timed(session(), factors), again = timed(session(), unused);
  std::vector<ReportRow> rows;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    rows.push_back(row(fmt::format("{}", i), 0.1, settings[i]));
    rows.back().frame = rows.back().still = first[i];
    ratios.push_back(again[i].median / first[i].median);
  }
  Report report = reportOf(rows);
  stateNoise(report, factors, ratios);
  return report;
}

TEST(ReportNoise, HoldsTwoRunsOfTheSameAndShowsAFifthMore) {
  std::mt19937 random(5);
  std::vector<double> settings;
  for (int i = 0; i < 200; ++i) settings.push_back(10.0 * std::exp(0.02 * i));
  for (const double load : {0.005, 0.2}) {
    int failed = 0, missed = 0;
    constexpr int kRuns = 50;
    for (int run = 0; run < kRuns; ++run) {
      const Report before = simulatedRun(random, settings, 1.0, load);
      if (regressed(compareReports(before, simulatedRun(random, settings, 1.0, load)))) ++failed;
      const auto changes = changesOf(before, simulatedRun(random, settings, 1.2, load));
      if (std::find(changes.begin(), changes.end(), "0 still ms worse") == changes.end()) ++missed;
    }
    EXPECT_LE(failed, 5) << "of " << kRuns << " pairs of runs, 200 settings each, in which nothing changed; load " << load;
    EXPECT_LE(missed, 5) << "in which one setting of 200 takes a fifth more; load " << load;
  }
}

TEST(ReportTiming, GivesSlowSettingsFewerRoundsEvenlySpread) {
  const TimingSettings settings{.rounds = 9, .leastRounds = 3, .seconds = 0.5};
  EXPECT_EQ(roundsOf(1.0, settings), 9);
  EXPECT_EQ(roundsOf(100.0, settings), 5);
  EXPECT_EQ(roundsOf(5000.0, settings), 3);
  EXPECT_EQ(roundsOf(0.0, settings), 9);
  EXPECT_EQ(roundsOf(5000.0, {.rounds = 2, .leastRounds = 3}), 2) << "never more than are asked for";
  for (int wanted = 1; wanted <= 9; ++wanted) {
    std::vector<int> drawn;
    for (int round = 0; round < 9; ++round)
      if (drawsIn(round, wanted, 9)) drawn.push_back(round);
    ASSERT_EQ(static_cast<int>(drawn.size()), wanted);
    for (std::size_t i = 1; i < drawn.size(); ++i) EXPECT_LE(std::abs(drawn[i] - drawn[i - 1] - 9.0 / wanted), 1.0) << wanted;
  }
}

RC_GTEST_PROP(ParetoFront, HoldsJustWhatNothingBeats, (const std::vector<std::pair<std::uint8_t, std::uint8_t>>& figures)) {
  std::vector<Tradeoff> points;
  for (const auto& [cost, error] : figures)
    points.push_back({points.size(), static_cast<double>(cost % 16), static_cast<double>(error % 16)});
  const std::vector<Tradeoff> front = paretoFront(points);
  const auto beats = [](const Tradeoff& a, const Tradeoff& b) {
    return a.cost <= b.cost && a.error <= b.error && (a.cost < b.cost || a.error < b.error);
  };
  for (const Tradeoff& point : points) {
    const bool beaten = std::any_of(points.begin(), points.end(), [&](const Tradeoff& other) { return beats(other, point); });
    const auto equal = std::count_if(front.begin(), front.end(),
                                     [&](const Tradeoff& other) { return other.cost == point.cost && other.error == point.error; });
    RC_ASSERT(equal == (beaten ? 0 : 1));
  }
  for (std::size_t i = 1; i < front.size(); ++i) RC_ASSERT(front[i - 1].cost < front[i].cost && front[i - 1].error > front[i].error);
}

TEST(ReportChoice, KeepsToABudgetOrAnError) {
  const ReportScene scene =
      reportOf({row("slow", 0.01, 9.0), row("middle", 0.03, 4.0), row("fast", 0.2, 1.0), row("rays16", 0.001, 0.5, "rays16")}).scenes[0];
  const auto chosen = [&](const Wish& wish) {
    const ReportRow* found = chooseRow(scene, wish);
    return found == nullptr ? "" : found->setting;
  };
  EXPECT_EQ(chosen({.budget = 10.0}), "slow");
  EXPECT_EQ(chosen({.budget = 8.9}), "middle");
  EXPECT_EQ(chosen({.budget = 1.0}), "fast");
  EXPECT_EQ(chosen({.budget = 0.9}), "") << "no scene can say rays16";
  EXPECT_EQ(chosen({.maxError = 0.5}), "fast");
  EXPECT_EQ(chosen({.maxError = 0.05}), "middle");
  EXPECT_EQ(chosen({.maxError = 0.009}), "");
}

TEST(ReportChoice, OfEqualsTakesTheSmaller) {
  Report report = reportOf({row("large", 0.1, 2.0), row("small", 0.1, 2.0)});
  report.scenes[0].rows[0].gpuBytes = 2000;
  EXPECT_EQ(chooseRow(report.scenes[0], {.budget = 3.0})->setting, "small");
}

TEST(ReportLosses, AreWhereNothingOfOursIsAsGoodAndAsFast) {
  const auto of = [](const std::vector<ReportRow>& rows) {
    std::vector<std::string> names;
    for (const Loss& loss : losses(reportOf(rows).scenes[0], Cost::frame)) names.push_back(loss.setting + "/" + loss.ours);
    return names;
  };
  const ReportRow good = row("good", 0.02, 5.0), fast = row("fast", 0.1, 1.0);
  EXPECT_THAT(of({good, fast, row("a", 0.02, 5.0, "a"), row("b", 0.11, 1.5, "b")}), ElementsAre());
  EXPECT_THAT(of({good, fast, row("c", 0.09, 4.9, "c"), row("d", 0.5, 0.9, "d"), row("e", 0.01, 50.0, "e")}),
              ElementsAre("c/fast", "d/", "e/good"));
  EXPECT_THAT(summaryMarkdown(reportOf({good, row("c", 0.01, 5.0, "c")})),
              HasSubstr("room, everything moves: c (0.0100 at 5.0 ms; ours 0.0200: good)"));
}

TEST(ReportStanding, CountsScenesByTimesOfBothKinds) {
  ReportRow hybrid = row("hybrid, 4 taps, 128^3, apertures", 0.05, 10.0);
  hybrid.estimator = "hybrid";
  hybrid.taps = 4;
  hybrid.resolution = 128;
  hybrid.apertureMode = "accurate";
  const ReportRow constant = row("constant", 0.4, 1.0, "constant"), better = row("b", 0.04, 9.0, "b"), slow = row("s", 0.01, 30.0, "s");
  Report report = reportOf({hybrid, constant, slow, row("best", 0.005, 29.0)});
  EXPECT_EQ(standingOf(report, Cost::frame).matched, 1) << "nothing is as fast as the constant, which does not count";
  EXPECT_EQ(standingOf(report, Cost::frame).leading, 1) << "what is slower does not count";
  report.scenes.push_back(reportOf({hybrid, constant, better}).scenes[0]);
  report.scenes.back().rows.back().still.median = 6.0;
  const Standing frame = standingOf(report, Cost::frame), still = standingOf(report, Cost::still);
  EXPECT_EQ(frame.scenes, 2);
  EXPECT_EQ(frame.matched, 1);
  EXPECT_EQ(frame.leading, 1);
  EXPECT_EQ(still.leading, 2) << "slower than the hybrid while nothing moves";
  EXPECT_EQ(still.matched, 1) << "and yet better than what is as fast";
  report.scenes[0].rows[0].bake = report.scenes[1].rows[2].bake = "8 bits";
  EXPECT_EQ(standingOf(report, Cost::frame).hybrids, 1) << "further bakes do not count";
  EXPECT_EQ(standingOf(report, Cost::frame).leading, 1);
  EXPECT_THAT(summaryMarkdown(report), HasSubstr("in 1 of 1."));
}

TEST(ReportOverall, TakesMeansOfWhatAllScenesHave) {
  Report report = reportOf({row("a", 0.3, 1.0), row("only here", 0.1, 1.0)});
  report.scenes.push_back({"garden", "other", 1, 100, 0.001, 1, {}, {row("b", 0.1, 1.0), row("a", 0.4, 100.0)}});
  const ReportScene all = overall(report);
  ASSERT_EQ(all.rows.size(), 1u);
  EXPECT_DOUBLE_EQ(all.rows[0].errors.rmse, std::sqrt((0.09 + 0.16) / 2.0));
  EXPECT_NEAR(all.rows[0].frame.median, 10.0, 1e-9);
  EXPECT_TRUE(overall(Report{}).rows.empty());
}

TEST(ReportCompare, IsQuietWithinTheNoiseOfBoth) {
  const Report before = reportOf({row("a", 0.1, 10.0), row("b", 0.2, 1.0)});
  EXPECT_FALSE(regressed(compareReports(before, before)));
  Report after = before;
  after.scenes[0].rows[0].frame.median = 11.9;
  after.scenes[0].rows[0].errors.rmse = 0.1 + 1e-5;
  EXPECT_THAT(changesOf(before, after), ElementsAre());
  after.scenes[0].rows[0].frame.median = 12.1;
  EXPECT_THAT(changesOf(before, after), ElementsAre("a frame ms worse"));
  EXPECT_TRUE(regressed(compareReports(before, after)));
  EXPECT_FALSE(regressed(compareReports(after, before))) << "it got better";
}

TEST(ReportCompare, TellsABusierDeviceFromASlowerSetting) {
  std::vector<ReportRow> rows;
  for (int i = 0; i < 10; ++i) rows.push_back(row(fmt::format("{}", i), 0.1, 10.0 + i));
  Report before = reportOf(rows);
  before.drift = 0.1;
  Report after = before;
  for (ReportRow& changed : after.scenes[0].rows) changed.still.median *= 1.15, changed.frame.median *= 1.15;
  EXPECT_THAT(changesOf(before, after), ElementsAre()) << "within the drift of both";
  after.scenes[0].rows[3].still.median *= 1.3;
  EXPECT_THAT(changesOf(before, after), ElementsAre("3 still ms worse"));
  EXPECT_THAT(comparisonText(compareReports(before, after)), HasSubstr("(+30.0 % beside a common factor of 1.15"));
  for (ReportRow& changed : after.scenes[0].rows) changed.still.median *= 1.3, changed.frame.median *= 1.3;
  EXPECT_THAT(changesOf(before, after), ElementsAre("all settings speed worse", "3 still ms worse"));
  EXPECT_TRUE(regressed(compareReports(before, after)));
}

TEST(ReportCompare, SeesErrorBytesAndWhatIsGone) {
  const Report before = reportOf({row("a", 0.1, 10.0), row("b", 0.2, 1.0)});
  Report after = reportOf({row("a", 0.101, 10.0), row("c", 0.2, 1.0)});
  EXPECT_THAT(changesOf(before, after), ElementsAre("a rmse worse", "a flicker worse"));
  const Comparisons all = compareReports(before, after);
  EXPECT_THAT(all.missing, ElementsAre("room: b"));
  EXPECT_THAT(all.added, ElementsAre("room: c"));
  EXPECT_THAT(comparisonText(all), HasSubstr("GONE   room: b"));
  after = before;
  after.scenes[0].rows[1].gpuBytes += 1;
  EXPECT_THAT(changesOf(before, after), ElementsAre("b bytes worse"));
  after = before;
  after.scenes.clear();
  EXPECT_TRUE(regressed(compareReports(before, after)));
}

TEST(ReportCompare, DoesNotCompareTimesOfDifferentDevices) {
  const Report before = reportOf({row("a", 0.1, 10.0)});
  Report after = reportOf({row("a", 0.1, 100.0)});
  EXPECT_TRUE(regressed(compareReports(before, after)));
  after.device = "another";
  EXPECT_FALSE(regressed(compareReports(before, after)));
  EXPECT_THAT(comparisonText(compareReports(before, after)), HasSubstr("were not compared"));
}

TEST(ReportTable, QuotesFieldsOfCsv) {
  const std::string csv = reportCsv(reportOf({row("published, 5 taps", 0.1, 10.0)}));
  EXPECT_THAT(csv, HasSubstr("room,\"published, 5 taps\",overcast,published,,,,"));
  const auto lineEnd = csv.find("\r\n");
  EXPECT_EQ(std::count(csv.begin(), csv.begin() + static_cast<std::ptrdiff_t>(lineEnd), ','),
            std::count(csv.begin() + static_cast<std::ptrdiff_t>(lineEnd), csv.end(), ',') - 1)
      << "as many fields as names, and one comma within quotes";
}

TEST(ReportPage, NeedsNothingElse) {
  const Report report = reportOf({row("a <b>", 0.1, 10.0), row("zero", 0.0, 0.0), row("rays16", 0.3, 1.0, "rays16")});
  const std::string page = reportPage(report, {{{"data:image/png;base64,AAAA"}}});
  EXPECT_THAT(page, Not(HasSubstr("http")));
  EXPECT_THAT(page, Not(HasSubstr("src=\"/")));
  EXPECT_THAT(page, Not(HasSubstr("url(")));
  EXPECT_THAT(page, Not(HasSubstr("import ")));
  EXPECT_THAT(page, Not(HasSubstr("nan")));
  EXPECT_THAT(page, Not(HasSubstr("inf\"")));
  EXPECT_THAT(page, HasSubstr("a &lt;b&gt;"));
  EXPECT_EQ(page, reportPage(report, {{{"data:image/png;base64,AAAA"}}}));
}

TEST(ReportPage, EncodesBase64) {
  const auto encoded = [](const std::string& text) {
    std::vector<std::byte> bytes;
    for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
    return base64(bytes);
  };
  // RFC 4648, 10.
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
}

TEST(ReportPage, ShowsDifferencesInTheirSign) {
  const Image reference{3, 1, {"depth", "sky"}, {1.0f, 0.5f, 1.0f, 0.5f, -1.0f, 0.0f}}, sky{3, 1, {"sky"}, {1.0f, 0.0f, 1.0f}};
  const Image difference = differencePicture(sky, reference, {1, 1, 0});
  EXPECT_GT(at(difference, 0, 0, 0), at(difference, 0, 0, 2)) << "too bright: red";
  EXPECT_LT(at(difference, 1, 0, 0), at(difference, 1, 0, 2)) << "too dark: blue";
  const Image none = differencePicture(reference, reference, {1, 1, 0});
  for (int channel = 0; channel < 3; ++channel) EXPECT_EQ(at(none, 0, 0, channel), 1.0f);
}

/// Pictures of `published` by the formulas of the pass, of pixels that miss these shares of their taps.
Image publishedOf(const std::vector<float>& missing, float k, float alpha) {
  Image sky{static_cast<int>(missing.size()), 1, {"sky"}, {}};
  for (const float share : missing) sky.pixels.push_back(shared::skyVisibility(k * (alpha + share)));
  return sky;
}

TEST(AsPrinted, FindsWhatThePassLeftOut) {
  const std::vector<float> shares{-0.7f, -0.1f, 0.0f, 0.05f, 0.3f, 1.0f, 1.9f};
  const Image missing = missingShare(publishedOf(shares, 1.5f, 0.5f), 1.5f, 0.5f);
  const Image printed = asPrinted(missing, 2.5);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    EXPECT_NEAR(missing.pixels[i], std::max(shares[i], 0.0f), 1e-4f) << shares[i];
    EXPECT_NEAR(printed.pixels[i], std::min(1.0, std::exp(-2.5 * shares[i])), 3e-4) << "k sum d = 2.5, no brighter than the sky";
  }
}

TEST(AsPrinted, TakesTheBestK) {
  const Image missing = missingShare(publishedOf({0.1f, 0.4f, 0.8f, 1.5f}, 1.5f, 0.5f), 1.5f, 0.5f);
  for (const double darkening : {0.3, 1.7, 9.0}) {
    Image truth = asPrinted(missing, darkening);
    truth.pixels[3] = 0.5f;  // does not count
    const Mask mask{1, 1, 1, 0};
    EXPECT_NEAR(bestDarkening({missing}, {&truth}, {&mask}), darkening, 0.01 * darkening);
  }
}

}  // namespace
}  // namespace overcast
