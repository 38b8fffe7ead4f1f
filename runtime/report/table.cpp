#include "runtime/report/table.h"

#include <algorithm>
#include <cmath>

#include "runtime/report/as_printed.h"
#include "runtime/technique.h"

namespace overcast {
namespace {

std::string figure(double value, int digits) {
  return value < 0.0 ? std::string("-") : fmt::format("{:.{}f}", value, digits);
}

std::string overallTable(const ReportScene& all) {
  std::string lines =
      "| setting | RMSE | bias | p99 | SSIM | FLIP | flicker | frame ms | still ms | MB |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const ReportRow& row : all.rows)
    lines += fmt::format("| {} | {:.4f} | {:+.4f} | {:.3f} | {:.3f} | {:.3f} | {} | {:.2f} | {:.2f} | {:.1f} |\n", row.setting,
                         row.errors.rmse, row.errors.bias, row.errors.p99, row.errors.ssim, row.errors.flip, figure(row.errors.flicker, 4),
                         row.frame.median, row.still.median, static_cast<double>(row.gpuBytes) / 1e6);
  return lines;
}

/// The row of the least RMSE, of ours or of the others, further bakes left out; null when there is none.
const ReportRow* best(const ReportScene& scene, bool ours) {
  const ReportRow* found = nullptr;
  for (const ReportRow& row : scene.rows)
    if (row.bake.empty() && (row.technique == nameOf(Technique::overcast)) == ours &&
        (found == nullptr || row.errors.rmse < found->errors.rmse))
      found = &row;
  return found;
}

std::string cell(const ReportRow* row) {
  return row == nullptr ? "-" : fmt::format("{:.4f}, {:.1f} ms: {}", row->errors.rmse, row->frame.median, row->setting);
}

std::string sceneTable(const Report& report) {
  std::string lines = "| scene | as the scene says | best of ours | best of others | reference |\n|---|---|---|---|---|\n";
  for (const ReportScene& scene : report.scenes)
    lines += fmt::format("| {} | {} | {} | {} | {:.4f} |\n", scene.name, cell(scene.rows.empty() ? nullptr : &scene.rows.front()),
                         cell(best(scene, true)), cell(best(scene, false)), scene.referenceError);
  return lines;
}

std::string ratioCell(const ReportRow* row, const ReportRow* published) {
  if (row == nullptr || published == nullptr) return "-";
  return fmt::format("{:.4f} ({:.2f})", row->errors.rmse, row->errors.rmse / published->errors.rmse);
}

/// The published estimator beside what we make of as many taps.
std::string tapsTable(const Report& report) {
  std::string lines =
      "RMSE at four taps, 128^3, and its ratio to `published`. As printed: the paper's formula without what ours adds to it, with the k "
      "that "
      "is best for each scene, which is generous.\n\n"
      "| scene | as printed | published | calibrated | hybrid |\n|---|---|---|---|---|\n";
  for (const ReportScene& scene : report.scenes) {
    const ReportRow* published = plainRow(scene, "published", 4);
    const auto printed =
        std::find_if(scene.rows.begin(), scene.rows.end(), [](const ReportRow& row) { return row.technique == kAsPrinted; });
    lines += fmt::format("| {} | {} | {} | {} | {} |\n", scene.name,
                         ratioCell(printed == scene.rows.end() ? nullptr : &*printed, published), ratioCell(published, published),
                         ratioCell(plainRow(scene, "calibrated", 4), published), ratioCell(plainRow(scene, "hybrid", 4), published));
  }
  return lines;
}

}  // namespace

std::string lossText(const Loss& loss) {
  return fmt::format("{} ({:.4f} at {:.1f} ms; {})", loss.setting, loss.rmse, loss.milliseconds,
                     loss.ours.empty() ? "nothing of ours is as fast" : fmt::format("ours {:.4f}: {}", loss.ourRmse, loss.ours));
}

std::string standingText(const Report& report, Cost cost) {
  const Standing standing = standingOf(report, cost);
  return fmt::format(
      "{}: ours dominates in {} of {} scenes (a setting of ours is as good and as fast as every other technique but the constant); hybrid "
      "at "
      "four taps has less error than every other technique of equal or less time in {} of {}.",
      cost == Cost::still ? "While nothing moves" : "While everything moves", standing.matched, standing.scenes, standing.leading,
      standing.hybrids);
}

namespace {

std::string lossTexts(const Report& report) {
  std::string lines = "Where another technique has less error than everything of ours that is as fast:\n\n";
  for (const ReportScene& scene : report.scenes) {
    for (const Cost cost : {Cost::frame, Cost::still}) {
      std::string list;
      for (const Loss& loss : losses(scene, cost)) list += (list.empty() ? "" : "; ") + lossText(loss);
      if (list.empty()) list = "none";
      lines += fmt::format("* {}, {}: {}\n", scene.name, cost == Cost::still ? "nothing moves" : "everything moves", list);
    }
  }
  return lines + "\n" + standingText(report, Cost::frame) + "\n" + standingText(report, Cost::still) + "\n";
}

std::string quotedField(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// Empty where there is none.
std::string countText(int count) {
  return count > 0 ? std::to_string(count) : "";
}

std::string passText(const ReportRow& row) {
  std::string text;
  for (const ReportPass& pass : row.passes) text += fmt::format("{}{}={:.4f}", text.empty() ? "" : " ", pass.name, pass.time.median);
  return text;
}

std::string stepText(const ReportRow& row) {
  std::string text;
  for (const ReportStep& step : row.steps) text += fmt::format("{}{}={:.3f}", text.empty() ? "" : "; ", step.name, step.share);
  return text;
}

}  // namespace

std::string summaryMarkdown(const Report& report) {
  const ReportScene all = overall(report);
  std::string text = fmt::format(
      "{} ({}). RMSE of sky visibility at {}x{} pixels; milliseconds at {}x{}, medians of up to {} rounds, `frame` while everything moves, "
      "`still` while nothing does. Over {} scenes: errors as root mean squares, times as geometric means. All times "
      "together may differ by {:.0f} % from run to run, as the device was as busy.{}\n\n",
      report.device, report.driver, report.width, report.height, report.timedWidth, report.timedHeight, report.rounds, report.scenes.size(),
      100.0 * std::expm1(report.drift), report.leftOut.empty() ? "" : " Left out: " + report.leftOut + ".");
  return text + overallTable(all) + "\n" + sceneTable(report) + "\n" + tapsTable(report) + "\n" + lossTexts(report);
}

std::string reportCsv(const Report& report) {
  std::string lines =
      "scene,setting,technique,estimator,resolution,taps,cones,aperture_mode,occluders,bake,storable,rmse,rmse_corrected,bias,mae,p95,p99,"
      "max,ssim,"
      "flip,"
      "flicker,frame_ms,frame_p95_ms,frame_noise_ms,still_ms,still_p95_ms,still_noise_ms,gpu_bytes,asset_bytes,passes,error_shares\r\n";
  for (const ReportScene& scene : report.scenes) {
    for (const ReportRow& row : scene.rows) {
      const ReportErrors& e = row.errors;
      for (const std::string& text : {scene.name, row.setting, row.technique, row.estimator}) lines += quotedField(text) + ",";
      lines += fmt::format("{},{},{},{},{},{},{},", countText(row.resolution), countText(row.taps), countText(row.cones), row.apertureMode,
                           quotedField(row.occluders), quotedField(row.bake), row.storable ? 1 : 0);
      for (const double value : {e.rmse, e.rmseCorrected, e.bias, e.mae, e.p95, e.p99, e.max, e.ssim, e.flip})
        lines += fmt::format("{:.7g},", value);
      lines += e.flicker >= 0.0 ? fmt::format("{:.7g},", e.flicker) : ",";
      for (const ReportTime& time : {row.frame, row.still})
        lines += fmt::format("{:.5g},{:.5g},{:.5g},", time.median, time.p95, time.noise);
      lines += fmt::format("{},{},{},{}\r\n", row.gpuBytes, row.assetBytes, quotedField(passText(row)), quotedField(stepText(row)));
    }
  }
  return lines;
}

}  // namespace overcast
