#include "formats/report.h"

#include <algorithm>
#include <limits>

#include "formats/files.h"
#include "formats/json_fields.h"

namespace overcast {
namespace {

constexpr const char* kFormat = "overcast-report";
constexpr std::uint64_t kLargestFile = std::uint64_t{1} << 28;
constexpr int kLargestInteger = std::numeric_limits<int>::max();
constexpr std::uint64_t kLargestCount = std::numeric_limits<std::uint64_t>::max();

Json timeJson(const ReportTime& time) {
  Json json{{"median", time.median}, {"p95", time.p95}, {"noise", time.noise}};
  if (time.rounds > 0) json["rounds"] = time.rounds;
  return json;
}

void readTime(Fields fields, ReportTime& time) {
  fields.number("median", time.median, 0.0, kLargestNumber);
  fields.number("p95", time.p95, 0.0, kLargestNumber);
  fields.number("noise", time.noise, 0.0, kLargestNumber);
  if (fields.has("rounds")) fields.integer("rounds", time.rounds, 1, kLargestInteger);
}

/// Key, member and least value of every error: one list for writing and reading.
struct ErrorField {
  const char* key;
  double ReportErrors::*member;
  double low;
};
constexpr ErrorField kErrorFields[] = {{"rmse", &ReportErrors::rmse, 0.0},
                                       {"rmseCorrected", &ReportErrors::rmseCorrected, 0.0},
                                       {"bias", &ReportErrors::bias, -kLargestNumber},
                                       {"mae", &ReportErrors::mae, 0.0},
                                       {"p95", &ReportErrors::p95, 0.0},
                                       {"p99", &ReportErrors::p99, 0.0},
                                       {"max", &ReportErrors::max, 0.0},
                                       {"ssim", &ReportErrors::ssim, -1.0},
                                       {"flip", &ReportErrors::flip, 0.0}};

Json errorsJson(const ReportErrors& errors) {
  Json json;
  for (const ErrorField& field : kErrorFields) json[field.key] = errors.*field.member;
  if (errors.flicker >= 0.0) json["flicker"] = errors.flicker;
  if (!errors.views.empty()) json["views"] = errors.views;
  return json;
}

void readErrors(Fields fields, std::size_t views, ReportErrors& errors) {
  for (const ErrorField& field : kErrorFields) fields.number(field.key, errors.*field.member, field.low, kLargestNumber);
  if (fields.has("flicker")) fields.number("flicker", errors.flicker, 0.0, kLargestNumber);
  if (fields.has("views")) fields.numbers("views", errors.views, views, 0.0, kLargestNumber);
}

Json rowJson(const ReportRow& row) {
  Json json{{"setting", row.setting}, {"technique", row.technique}};
  if (!row.estimator.empty()) json["estimator"] = row.estimator;
  if (row.resolution > 0) json["resolution"] = row.resolution;
  if (row.taps > 0) json["taps"] = row.taps;
  if (row.cones > 0) json["cones"] = row.cones;
  if (!row.apertureMode.empty()) json["apertureMode"] = row.apertureMode;
  json["occluders"] = row.occluders;
  if (!row.bake.empty()) json["bake"] = row.bake;
  json["storable"] = row.storable ? 1 : 0;
  json["errors"] = errorsJson(row.errors);
  json["frame"] = timeJson(row.frame);
  json["still"] = timeJson(row.still);
  json["passes"] = Json::array();
  for (const ReportPass& pass : row.passes) {
    Json entry{{"name", pass.name}};
    entry.update(timeJson(pass.time));
    json["passes"].push_back(std::move(entry));
  }
  json["gpuBytes"] = row.gpuBytes;
  json["assetBytes"] = row.assetBytes;
  json["steps"] = Json::array();
  for (const ReportStep& step : row.steps)
    json["steps"].push_back({{"name", step.name}, {"rms", step.rms}, {"bias", step.bias}, {"share", step.share}});
  return json;
}

void readRow(Fields fields, std::size_t views, ReportRow& row) {
  fields.text("setting", row.setting, false);
  fields.text("technique", row.technique, false);
  if (fields.has("estimator")) fields.text("estimator", row.estimator, false);
  if (fields.has("resolution")) fields.integer("resolution", row.resolution, 1, kLargestInteger);
  if (fields.has("taps")) fields.integer("taps", row.taps, 1, kLargestInteger);
  if (fields.has("cones")) fields.integer("cones", row.cones, 1, kLargestInteger);
  if (fields.has("apertureMode")) fields.text("apertureMode", row.apertureMode, false);
  fields.text("occluders", row.occluders, true);
  if (fields.has("bake")) fields.text("bake", row.bake, false);
  int storable = 0;
  fields.integer("storable", storable, 0, 1);
  row.storable = storable == 1;
  readErrors(fields.child("errors"), views, row.errors);
  readTime(fields.child("frame"), row.frame);
  readTime(fields.child("still"), row.still);
  for (std::size_t i = 0, count = fields.arraySize("passes"); i < count; ++i) {
    Fields pass = fields.element("passes", i);
    row.passes.emplace_back();
    pass.text("name", row.passes.back().name, false);
    readTime(pass, row.passes.back().time);
  }
  fields.integer("gpuBytes", row.gpuBytes, std::uint64_t{0}, kLargestCount);
  fields.integer("assetBytes", row.assetBytes, std::uint64_t{0}, kLargestCount);
  for (std::size_t i = 0, count = fields.arraySize("steps"); i < count; ++i) {
    Fields step = fields.element("steps", i);
    row.steps.emplace_back();
    step.text("name", row.steps.back().name, false);
    step.number("rms", row.steps.back().rms, 0.0, kLargestNumber);
    step.number("bias", row.steps.back().bias, -kLargestNumber, kLargestNumber);
    step.number("share", row.steps.back().share, -kLargestNumber, kLargestNumber);
  }
}

Json sceneJson(const ReportScene& scene) {
  Json json{{"name", scene.name},
            {"hash", scene.hash},
            {"pictures", scene.pictures},
            {"pixels", scene.pixels},
            {"referenceError", scene.referenceError},
            {"seed", scene.seed},
            {"views", Json::array()},
            {"rows", Json::array()}};
  for (const ReportView& view : scene.views) json["views"].push_back({{"camera", view.camera}, {"frame", view.frame}, {"time", view.time}});
  for (const ReportRow& row : scene.rows) json["rows"].push_back(rowJson(row));
  return json;
}

void readView(Fields fields, ReportView& view) {
  fields.text("camera", view.camera, true);
  fields.integer("frame", view.frame, 0, kLargestInteger);
  fields.number("time", view.time, -kLargestNumber, kLargestNumber);
}

void readSceneOf(Fields fields, ReportScene& scene) {
  fields.text("name", scene.name, false);
  fields.text("hash", scene.hash, false);
  fields.integer("pictures", scene.pictures, 1, kLargestInteger);
  fields.integer("pixels", scene.pixels, std::uint64_t{0}, kLargestCount);
  fields.number("referenceError", scene.referenceError, 0.0, kLargestNumber);
  fields.integer("seed", scene.seed, std::uint64_t{0}, kLargestCount);
  for (std::size_t i = 0, count = fields.has("views") ? fields.arraySize("views") : 0; i < count; ++i)
    readView(fields.element("views", i), scene.views.emplace_back());
  for (std::size_t i = 0, count = fields.arraySize("rows"); i < count; ++i) {
    readRow(fields.element("rows", i), scene.views.size(), scene.rows.emplace_back());
    const std::string& name = scene.rows.back().setting;
    if (rowNamed(scene, name) != &scene.rows.back()) fields.fail("rows", fmt::format("name the setting '{}' twice", name));
  }
}

void readAll(Fields& fields, Report& report) {
  std::string format;
  fields.text("format", format, false);
  if (format != kFormat) fields.fail("format", fmt::format("is '{}', not '{}'", format, kFormat));
  fields.version(kReportVersion);
  fields.text("device", report.device, false);
  fields.text("kind", report.kind, true);
  fields.text("driver", report.driver, true);
  fields.text("vulkan", report.vulkan, true);
  fields.integer("width", report.width, 1, kLargestInteger);
  fields.integer("height", report.height, 1, kLargestInteger);
  fields.integer("timedWidth", report.timedWidth, 1, kLargestInteger);
  fields.integer("timedHeight", report.timedHeight, 1, kLargestInteger);
  fields.integer("rounds", report.rounds, 1, kLargestInteger);
  if (fields.has("drift")) fields.number("drift", report.drift, 0.0, kLargestNumber);
  if (fields.has("leftOut")) fields.text("leftOut", report.leftOut, false);
  for (std::size_t i = 0, count = fields.arraySize("scenes"); i < count; ++i)
    readSceneOf(fields.element("scenes", i), report.scenes.emplace_back());
}

}  // namespace

const ReportRow* rowNamed(const ReportScene& scene, std::string_view setting) {
  const auto found = std::find_if(scene.rows.begin(), scene.rows.end(), [&](const ReportRow& row) { return row.setting == setting; });
  return found == scene.rows.end() ? nullptr : &*found;
}

std::string reportJson(const Report& report) {
  Json json{{"format", kFormat},
            {"version", kReportVersion},
            {"device", report.device},
            {"kind", report.kind},
            {"driver", report.driver},
            {"vulkan", report.vulkan},
            {"width", report.width},
            {"height", report.height},
            {"timedWidth", report.timedWidth},
            {"timedHeight", report.timedHeight},
            {"rounds", report.rounds},
            {"drift", report.drift},
            {"scenes", Json::array()}};
  if (!report.leftOut.empty()) json["leftOut"] = report.leftOut;
  for (const ReportScene& scene : report.scenes) json["scenes"].push_back(sceneJson(scene));
  return dumpJson(json, 1) + "\n";
}

Result<Report> parseReport(std::string_view json, const std::string& place) {
  return parseObject<Report>(json, place, readAll);
}

Result<Report> readReport(const std::filesystem::path& path) {
  const auto bytes = readFile(path, kLargestFile);
  if (!bytes) return bytes.error();
  auto report = parseReport(std::string_view(reinterpret_cast<const char*>(bytes.value().data()), bytes.value().size()), "");
  if (!report) return Error{path.string(), report.error().place, report.error().reason};
  return report;
}

}  // namespace overcast
