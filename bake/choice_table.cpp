#include "bake/choice_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <nlohmann/json.hpp>

#include "bake/bake_report.h"
#include "formats/console.h"

namespace overcast {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kRepresentations = {Representation::primitive, Representation::radius, Representation::heightfield,
                                         Representation::volume};

/// Winner over volume.
struct Ratios {
  double bytes = 0.0;
  double error = 0.0;
};

std::optional<Ratios> ratiosOf(const ChoiceRow& row) {
  if (!row.volume) return {};
  const auto error = [&](const Score& score) { return std::max(score.error.surfaceRms, kLeastError * row.diagonal); };
  return Ratios{static_cast<double>(row.winner.bytes) / static_cast<double>(row.volume->bytes), error(row.winner) / error(*row.volume)};
}

/// The last row.
struct Totals {
  std::uint64_t faces = 0, bytes = 0, volumeBytes = 0, signErrors = 0;
  std::size_t outsideLimits = 0;
  double seconds = 0.0;
  double squaredError = 0.0;  ///< sum of squared surfaceRms, shares of the diagonals
  double squaredSky = 0.0;
  double logBytes = 0.0, logError = 0.0;  ///< sums
  std::size_t compared = 0;
  std::array<std::size_t, kRepresentations.size()> won{};

  double meanBytes() const { return compared == 0 ? 1.0 : std::exp(logBytes / static_cast<double>(compared)); }
  double meanError() const { return compared == 0 ? 1.0 : std::exp(logError / static_cast<double>(compared)); }
};

Totals totalsOf(const std::vector<ChoiceRow>& rows) {
  Totals totals;
  for (const ChoiceRow& row : rows) {
    totals.faces += row.faces;
    totals.bytes += row.winner.bytes;
    totals.signErrors += row.winner.error.signErrors;
    totals.outsideLimits += !row.withinLimits;
    totals.seconds += row.seconds.value_or(0.0);
    totals.squaredError += std::pow(row.winner.error.surfaceRms / row.diagonal, 2.0);
    totals.squaredSky += std::pow(row.winner.error.skyRmse, 2.0);
    const auto place = std::find(kRepresentations.begin(), kRepresentations.end(), row.winner.candidate.representation);
    ++totals.won[static_cast<std::size_t>(place - kRepresentations.begin())];
    const std::optional<Ratios> ratios = ratiosOf(row);
    if (!ratios) continue;
    totals.volumeBytes += row.volume->bytes;
    totals.logBytes += std::log(ratios->bytes);
    totals.logError += std::log(ratios->error);
    ++totals.compared;
  }
  return totals;
}

std::string wins(const Totals& totals) {
  std::string text;
  for (std::size_t i = 0; i < kRepresentations.size(); ++i)
    text += fmt::format("{}{} {}", i == 0 ? "" : ", ", totals.won[i], name(kRepresentations[i]));
  return text;
}

std::string rowText(const ChoiceRow& row) {
  const MeasuredError& error = row.winner.error;
  const double percent = 100.0 / row.diagonal;
  const std::optional<Ratios> ratios = ratiosOf(row);
  return fmt::format("| {} | {} | {}{} | {:.4f} | {:.3f} | {:.3f} | {:.4f} | {} | {} | {} | {} | {} |\n", oneLine(row.source), row.faces,
                     name(row.winner.candidate), row.withinLimits ? "" : " (over the limits)", percent * error.surfaceRms,
                     percent * error.max, percent * error.p99, error.skyRmse, error.signErrors, row.winner.bytes,
                     row.seconds ? fmt::format("{:.2f}", *row.seconds) : "", ratios ? fmt::format("{:.3f}", ratios->bytes) : "",
                     ratios ? fmt::format("{:.2f}", ratios->error) : "");
}

}  // namespace

std::string choiceTable(const std::vector<ChoiceRow>& rows) {
  std::string text =
      "| mesh | faces | chosen | surface rms % | max % | p99 % | sky rmse | sign errors | bytes | seconds | bytes ratio | error ratio |\n"
      "|---|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const ChoiceRow& row : rows) text += rowText(row);
  const Totals totals = totalsOf(rows);
  const double count = static_cast<double>(std::max<std::size_t>(rows.size(), 1));
  text +=
      fmt::format("| all {} | {} | {} | {:.4f} | | | {:.4f} | {} | {} | {} | {:.3f} | {:.2f} |\n", rows.size(), totals.faces, wins(totals),
                  100.0 * std::sqrt(totals.squaredError / count), std::sqrt(totals.squaredSky / count), totals.signErrors, totals.bytes,
                  totals.seconds > 0.0 ? fmt::format("{:.2f}", totals.seconds) : "", totals.meanBytes(), totals.meanError());
  return text;
}

std::string choiceTableJson(const std::vector<ChoiceRow>& rows) {
  Json list = Json::array();
  for (const ChoiceRow& row : rows) {
    const MeasuredError& error = row.winner.error;
    Json json = {{"source", row.source},
                 {"faces", row.faces},
                 {"chosen", name(row.winner.candidate)},
                 {"representation", name(row.winner.candidate.representation)},
                 {"withinLimits", row.withinLimits},
                 {"diagonal", row.diagonal},
                 {"surfaceRms", error.surfaceRms},
                 {"max", error.max},
                 {"p99", error.p99},
                 {"skyRmse", error.skyRmse},
                 {"signErrors", error.signErrors},
                 {"samples", error.samples},
                 {"seed", error.seed},
                 {"method", error.method},
                 {"bytes", row.winner.bytes}};
    if (row.seconds) json["seconds"] = *row.seconds;
    if (const std::optional<Ratios> ratios = ratiosOf(row)) {
      json["volume"] = {{"bytes", row.volume->bytes}, {"surfaceRms", row.volume->error.surfaceRms}};
      json["bytesRatio"] = ratios->bytes;
      json["errorRatio"] = ratios->error;
    }
    list.push_back(std::move(json));
  }
  const Totals totals = totalsOf(rows);
  Json sums = {{"meshes", rows.size()},
               {"outsideLimits", totals.outsideLimits},
               {"bytes", totals.bytes},
               {"volumeBytes", totals.volumeBytes},
               {"signErrors", totals.signErrors},
               {"seconds", totals.seconds},
               {"meanBytesRatio", totals.meanBytes()},
               {"meanErrorRatio", totals.meanError()}};
  for (std::size_t i = 0; i < kRepresentations.size(); ++i) sums["won"][name(kRepresentations[i])] = totals.won[i];
  return Json{{"rows", std::move(list)}, {"totals", std::move(sums)}}.dump();
}

}  // namespace overcast
