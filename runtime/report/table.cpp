#include "runtime/report/table.h"

#include <algorithm>

#include "runtime/report/choice.h"
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

/// The row of the least RMSE, of ours or of the others; null when there is none.
const ReportRow* best(const ReportScene& scene, bool ours) {
  const ReportRow* found = nullptr;
  for (const ReportRow& row : scene.rows)
    if ((row.technique == nameOf(Technique::overcast)) == ours && (found == nullptr || row.errors.rmse < found->errors.rmse)) found = &row;
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

std::string lossText(const Report& report) {
  std::string lines;
  for (const Loss& loss : losses(report))
    lines += fmt::format("* {}: {} ({:.4f} at {:.1f} ms) against {}{}\n", loss.scene, loss.setting, loss.rmse, loss.milliseconds,
                         loss.ours.empty() ? "nothing of ours that is as fast" : fmt::format("{} ({:.4f})", loss.ours, loss.ourRmse),
                         loss.whileStill ? "" : "; not while nothing moves");
  if (lines.empty()) return "No other technique has less error than the best of ours at equal or less time.\n";
  return "Where another technique has less error than everything of ours that is as fast:\n\n" + lines;
}

std::string quotedField(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
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
      "{} ({}). RMSE of sky visibility at {}x{} pixels; milliseconds at {}x{}, medians of {} rounds, `frame` while everything moves, "
      "`still` "
      "while nothing does. Over {} scenes: errors as root mean squares, times as geometric means.\n\n",
      report.device, report.driver, report.width, report.height, report.timedWidth, report.timedHeight, report.rounds,
      report.scenes.size());
  return text + overallTable(all) + "\n" + sceneTable(report) + "\n" + lossText(report);
}

std::string reportCsv(const Report& report) {
  std::string lines =
      "scene,setting,technique,estimator,resolution,taps,aperture_mode,occluders,storable,rmse,rmse_corrected,bias,mae,p95,p99,max,ssim,"
      "flip,"
      "flicker,frame_ms,frame_p95_ms,frame_noise_ms,still_ms,still_p95_ms,still_noise_ms,gpu_bytes,asset_bytes,passes,error_shares\r\n";
  for (const ReportScene& scene : report.scenes) {
    for (const ReportRow& row : scene.rows) {
      const ReportErrors& e = row.errors;
      for (const std::string& text : {scene.name, row.setting, row.technique, row.estimator}) lines += quotedField(text) + ",";
      lines +=
          fmt::format("{},{},{},{},{},", row.resolution > 0 ? std::to_string(row.resolution) : "",
                      row.taps > 0 ? std::to_string(row.taps) : "", row.apertureMode, quotedField(row.occluders), row.storable ? 1 : 0);
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
