#include "runtime/report/make_report.h"

#include "formats/files.h"
#include "formats/scene_lighting.h"
#include "runtime/report/page.h"
#include "runtime/report/picture.h"
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
  report.timedWidth = settings.timedWidth;
  report.timedHeight = settings.timedHeight;
  report.rounds = settings.rounds;
  return report;
}

Result<MeasuredScene> measureFile(const Device& device, const fs::path& file, const ReportJob& job) {
  auto truth = readTruth(job.reference, file);
  if (!truth) return truth.error();
  auto scene = loadScene(device, file);
  if (!scene) return scene.error();
  auto measured = measureScene(device, scene.value(), file.stem().string(), std::move(truth).value(), job.measure);
  destroyScene(device, scene.value());
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
  for (const fs::path& file : job.scenes) {
    auto measured = measureFile(device, file, job);
    if (!measured) return measured.error();
    auto shown = writePictures(job.output / "pictures", measured.value());
    if (!shown) return shown.error();
    const Image& truth = measured.value().truth.reference.image;
    if (report.scenes.empty()) {
      report.width = truth.width;
      report.height = truth.height;
    } else if (truth.width != report.width || truth.height != report.height) {
      return Error{
          file.string(), "",
          fmt::format("has references of {}x{} pixels, the first scene of {}x{}", truth.width, truth.height, report.width, report.height)};
    }
    pictures.push_back(std::move(shown).value());
    report.scenes.push_back(std::move(measured.value().scene));
  }
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
  Lighting lighting = lightingWith(own, {.estimator = row->estimator, .taps = row->taps, .resolution = row->resolution});
  if (row == &scene.rows.front()) return row;
  lighting.estimator.fitError = -1.0;
  const auto written = replaceLighting(file, lighting);
  if (!written) return written.error();
  return row;
}

}  // namespace overcast
