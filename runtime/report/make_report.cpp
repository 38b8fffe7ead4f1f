#include "runtime/report/make_report.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "formats/files.h"
#include "formats/scene_lighting.h"
#include "runtime/report/page.h"
#include "runtime/report/picture.h"
#include "runtime/report/statistics.h"
#include "runtime/report/sweep.h"
#include "runtime/report/table.h"

namespace overcast {
namespace {

namespace fs = std::filesystem;

Report reportOn(const DeviceInfo& device, const MeasureSettings& settings) {
  Report report;
  report.device = device.name;
  report.kind = device.kind;
  report.driver = device.driver;
  report.vulkan = device.apiVersion;
  report.timedWidth = settings.timing.width;
  report.timedHeight = settings.timing.height;
  report.rounds = settings.timing.rounds;
  report.leftOut = leftOutOf(settings.size);
  return report;
}

/// Calls `measure` with a scene that is then closed; its Result.
template <class Measure>
auto withScene(const Device& device, const fs::path& file, const Measure& measure) -> decltype(measure(std::declval<RuntimeScene&>())) {
  auto scene = loadScene(device, file);
  if (!scene) return scene.error();
  auto measured = measure(scene.value());
  destroyScene(device, scene.value());
  return measured;
}

/// Bakes of one scene, the first its own.
using Bakes = std::vector<fs::path>;

std::vector<Bakes> grouped(const std::vector<fs::path>& files) {
  std::vector<Bakes> groups;
  for (const fs::path& file : files) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const Bakes& bakes) { return bakes[0].stem() == file.stem(); });
    if (same == groups.end())
      groups.push_back({file});
    else
      same->push_back(file);
  }
  return groups;
}

/// What tells a further bake apart: how its occluders are, and its folder where that is not enough.
std::string bakeName(const RuntimeScene& scene, const fs::path& file, const ReportScene& measured) {
  const std::string occluders = occludersOf(scene);
  const bool taken =
      std::any_of(measured.rows.begin(), measured.rows.end(), [&](const ReportRow& row) { return row.occluders == occluders; });
  return taken ? fmt::format("{}, {}", occluders, fs::absolute(file).parent_path().filename().string()) : occluders;
}

Result<MeasuredScene> measureBakes(const Device& device, const Bakes& bakes, const ReportJob& job) {
  auto truth = readTruth(job.reference, bakes[0]);
  if (!truth) return truth.error();
  auto measured = withScene(device, bakes[0], [&](RuntimeScene& scene) {
    return measureScene(device, scene, bakes[0].stem().string(), std::move(truth).value(), job.measure);
  });
  for (std::size_t i = 1; measured && i < bakes.size(); ++i) {
    const auto read = readScene(bakes[i]);
    if (!read) return read.error();
    const double time = measured.value().truth.pictures[0].reference.info.time;
    if (tracedHash(read.value(), time) != measured.value().scene.hash)
      return Error{bakes[i].string(), "", fmt::format("is another scene than {}, of the same name", bakes[0].string())};
    const Result<Done> further = withScene(device, bakes[i], [&](RuntimeScene& scene) {
      return measureVariant(device, scene, bakeName(scene, bakes[i], measured.value().scene), job.measure, measured.value());
    });
    if (!further) return further.error();
  }
  return measured;
}

Result<Done> writeAll(const fs::path& folder, const Report& report, const std::vector<std::vector<PagePicture>>& pictures) {
  Result<Done> done = writeFileAtomically(folder / "report.html", reportPage(report, pictures));
  if (done) done = writeFileAtomically(folder / "report.csv", reportCsv(report));
  if (done) done = writeFileAtomically(folder / "report.json", reportJson(report));
  return done;
}

}  // namespace

Result<Report> makeReport(const Device& device, const ReportJob& job) {
  Report report = reportOn(device.info, job.measure);
  std::vector<std::vector<PagePicture>> pictures;
  std::optional<MeasuredScene> first;
  std::vector<double> factors;
  for (const Bakes& bakes : grouped(job.scenes)) {
    auto measured = measureBakes(device, bakes, job);
    if (!measured) return measured.error();
    auto shown = writePictures(job.output / "pictures", measured.value());
    if (!shown) return shown.error();
    const Image& truth = measured.value().truth.pictures.back().reference.image;
    if (report.scenes.empty()) {
      report.width = truth.width;
      report.height = truth.height;
    } else if (truth.width != report.width || truth.height != report.height) {
      return Error{
          bakes[0].string(), "",
          fmt::format("has references of {}x{} pixels, the first scene of {}x{}", truth.width, truth.height, report.width, report.height)};
    }
    pictures.push_back(std::move(shown).value());
    report.scenes.push_back(measured.value().scene);
    factors.insert(factors.end(), measured.value().factors.begin(), measured.value().factors.end());
    if (!first) first = std::move(measured).value();
  }
  const auto again = withScene(device, job.scenes[0], [&](RuntimeScene& scene) { return timeAgain(device, scene, *first, job.measure); });
  if (!again) return again.error();
  stateNoise(report, factors, again.value());
  const auto written = writeAll(job.output, report, pictures);
  if (!written) return written.error();
  return report;
}

Result<const ReportRow*> applyWish(const ReportScene& scene, const fs::path& file, const Wish& wish) {
  const ReportRow* row = chooseRow(scene, wish);
  if (row == nullptr) return row;
  const auto read = readScene(file);
  if (!read) return read.error();
  const Lighting own = read.value().lighting.value_or(Lighting{});
  Lighting lighting =
      lightingWith(own, {.estimator = row->estimator, .taps = row->taps, .cones = row->cones, .resolution = row->resolution});
  if (row == &scene.rows.front()) return row;
  lighting.estimator.fitError = lighting.estimator.heldOutError = -1.0;
  const auto written = replaceLighting(file, lighting);
  if (!written) return written.error();
  return row;
}

}  // namespace overcast
