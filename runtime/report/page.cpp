#include "runtime/report/page.h"

#include <algorithm>
#include <set>

#include "runtime/report/chart.h"
#include "runtime/report/choice.h"
#include "runtime/technique.h"

namespace overcast {
namespace {

constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Overcast: error against time</title>
<style>
:root { --ink: #1d2733; --quiet: #5c6b7a; --line: #dde3e9; --ground: #f6f8fa; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink); font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 28px 24px 60px; }
h1 { font-size: 26px; margin: 0 0 4px; } h2 { font-size: 20px; margin: 44px 0 10px; } h3 { font-size: 15px; margin: 18px 0 6px; }
p { margin: 6px 0; max-width: 92ch; } .quiet { color: var(--quiet); font-size: 13px; }
nav { margin: 12px 0 0; display: flex; flex-wrap: wrap; gap: 4px 14px; } a { color: #0b6e99; }
.panel { background: #fff; border: 1px solid var(--line); border-radius: 8px; padding: 14px 16px; margin: 12px 0; overflow-x: auto; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(370px, 1fr)); gap: 14px; } .pair .panel { margin: 0; }
.chart { width: 100%; height: auto; display: block; } .chart text { font-size: 11px; fill: var(--quiet); }
.chart .axis { font-size: 12px; fill: var(--ink); } .grid { stroke: var(--line); fill: none; }
.front { stroke: #99a5b1; stroke-width: 1.5; stroke-dasharray: 4 3; fill: none; }
.dot { cursor: default; } .dot > :first-child { fill-opacity: .82; stroke-width: 1; }
.dot:hover > :first-child { stroke: #000; stroke-width: 2.5; fill-opacity: 1; }
.legend { display: flex; flex-wrap: wrap; gap: 4px 18px; font-size: 13px; } .legend i { display: inline-block; width: 11px; height: 11px; margin-right: 6px; }
.legend i.round { border-radius: 50%; } .legend i.other { transform: rotate(45deg); }
table { border-collapse: collapse; width: 100%; font-size: 13px; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 9px; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap; }
th { color: var(--quiet); font-weight: 600; } th:first-child, td:first-child { text-align: left; } tr:hover td { background: #f0f5f9; }
.front-row td:first-child { font-weight: 600; }
details summary { cursor: pointer; color: var(--quiet); font-size: 13px; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(270px, 1fr)); gap: 14px; }
figure { margin: 0; } figure img { width: 100%; display: block; border: 1px solid var(--line); } figure img + img { margin-top: 3px; }
figcaption { font-size: 12px; color: var(--quiet); margin-top: 3px; }
ul { margin: 6px 0; padding-left: 20px; }
</style></head><body><main>
)";

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.2f}", static_cast<double>(bytes) / 1e6);
}

std::string legend(const Report& report) {
  std::set<std::string> seen;
  std::string html = "<div class=\"legend\">";
  for (const ReportScene& scene : report.scenes) {
    for (const ReportRow& row : scene.rows) {
      const std::string family = familyOf(row);
      if (!seen.insert(family).second) continue;
      const bool ours = row.technique == nameOf(Technique::overcast);
      html += fmt::format("<span><i class=\"{}\" style=\"background:{}\"></i>{}</span>", ours ? "round" : "other", colourOf(family),
                          escapedHtml(family));
    }
  }
  return html +
         "</div>\n<p class=\"quiet\">Round: Overcast. Square: what else one could take. Dashed: the front; everything above and to the "
         "right of it is beaten. Point at a dot for its settings.</p>\n";
}

std::string charts(const ReportScene& scene) {
  return fmt::format(
      "<div class=\"pair\"><div class=\"panel\"><h3>Error against time</h3>{}</div><div class=\"panel\"><h3>Error against "
      "time while nothing moves</h3>{}</div><div class=\"panel\"><h3>Error against memory</h3>{}</div>",
      tradeoffChart(scene, Cost::frame), tradeoffChart(scene, Cost::still), tradeoffChart(scene, Cost::bytes));
}

std::string rowsTable(const ReportScene& scene) {
  std::set<std::size_t> front;
  for (const Tradeoff& point : paretoFront(tradeoffs(scene, Cost::frame))) front.insert(point.row);
  std::string html =
      "<div class=\"panel\"><table><thead><tr><th>setting</th><th>RMSE</th><th>bias</th><th>MAE</th><th>p95</th><th>p99</th><th>SSIM</th>"
      "<th>FLIP</th><th>flicker</th><th>frame ms</th><th>p95</th><th>noise</th><th>still ms</th><th>MB device</th><th>MB assets</th></tr>"
      "</thead><tbody>\n";
  for (std::size_t i = 0; i < scene.rows.size(); ++i) {
    const ReportRow& row = scene.rows[i];
    const ReportErrors& e = row.errors;
    html +=
        fmt::format("<tr{}><td>{}</td><td>{:.4f}</td><td>{:+.4f}</td><td>{:.4f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td>",
                    front.contains(i) ? " class=\"front-row\"" : "", escapedHtml(row.setting), e.rmse, e.bias, e.mae, e.p95, e.p99, e.ssim);
    html +=
        fmt::format("<td>{:.4f}</td><td>{}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{}</td><td>{}</td></tr>\n",
                    e.flip, e.flicker < 0.0 ? "" : fmt::format("{:.4f}", e.flicker), row.frame.median, row.frame.p95, row.frame.noise,
                    row.still.median, megabytes(row.gpuBytes), megabytes(row.assetBytes));
  }
  return html + "</tbody></table><p class=\"quiet\">Bold: on the front of error against time.</p></div>\n";
}

std::string passesTable(const ReportScene& scene) {
  std::string html = "<details><summary>Milliseconds of every pass</summary><div class=\"panel\"><table><tbody>\n";
  for (const ReportRow& row : scene.rows) {
    html += fmt::format("<tr><td>{}</td>", escapedHtml(row.setting));
    for (const ReportPass& pass : row.passes)
      html += fmt::format("<td>{} {:.3f} (p95 {:.3f})</td>", escapedHtml(pass.name), pass.time.median, pass.time.p95);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div></details>\n";
}

std::string stepsTable(const ReportScene& scene) {
  std::string html =
      "<details><summary>Where the error comes from</summary><div class=\"panel\"><p class=\"quiet\">Share of the mean square error of the "
      "first picture, root mean square and bias of each step. Occluders: 64 rays through the volume at 256^3 against the reference (also "
      "holds the error of the rays). Composite: the same rays at the setting's resolution. Below 0: the step makes good what others "
      "spoil.</p><table><tbody>\n";
  for (const ReportRow& row : scene.rows) {
    if (row.steps.empty()) continue;
    html += fmt::format("<tr><td>{}</td>", escapedHtml(row.setting));
    for (const ReportStep& step : row.steps)
      html += fmt::format("<td>{} {:.0f} % ({:.4f}, {:+.4f})</td>", escapedHtml(step.name), 100.0 * step.share, step.rms, step.bias);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div></details>\n";
}

std::string pictureGrid(const std::vector<PagePicture>& pictures) {
  std::string html = fmt::format(
      "<h3>Pictures</h3><p class=\"quiet\">Sky visibility, and below it its difference from the reference: red too "
      "bright, blue too dark, full colour at {}.</p><div class=\"pictures\">\n",
      kDifferenceRange);
  for (const PagePicture& picture : pictures) {
    const std::string caption = escapedHtml(picture.caption);
    html += fmt::format("<figure><img src=\"{}\" alt=\"{}\">", picture.picture, caption);
    if (!picture.difference.empty()) html += fmt::format("<img src=\"{}\" alt=\"difference of {}\">", picture.difference, caption);
    html += fmt::format("<figcaption>{}</figcaption></figure>\n", caption);
  }
  return html + "</div>\n";
}

std::string lossList(const Report& report) {
  const std::vector<Loss> all = losses(report);
  if (all.empty()) return "<p>No other technique has less error than the best of ours at equal or less time.</p>\n";
  std::string html = "<p>Another technique has less error than everything of ours that is as fast:</p><ul>\n";
  for (const Loss& loss : all)
    html += fmt::format("<li>{}: {} ({:.4f} at {:.2f} ms) against {}{}</li>\n", escapedHtml(loss.scene), escapedHtml(loss.setting),
                        loss.rmse, loss.milliseconds,
                        loss.ours.empty() ? "nothing of ours" : fmt::format("{} ({:.4f})", escapedHtml(loss.ours), loss.ourRmse),
                        loss.whileStill ? "" : "; not while nothing moves");
  return html + "</ul>\n";
}

std::string environment(const Report& report) {
  return fmt::format(
      "<p class=\"quiet\">{} ({}), {}, Vulkan {}. Errors at {}x{} pixels; times at {}x{}, medians of {} rounds in which the settings take "
      "turns, after one that warms up; the volume is made anew in every frame. Noise: by how much another run may differ.</p>\n",
      escapedHtml(report.device), escapedHtml(report.kind), escapedHtml(report.driver), escapedHtml(report.vulkan), report.width,
      report.height, report.timedWidth, report.timedHeight, report.rounds);
}

std::string sceneSection(const ReportScene& scene, const std::vector<PagePicture>& pictures) {
  return fmt::format(
             "<h2 id=\"{0}\">{0}</h2><p class=\"quiet\">{1} pictures, {2} pixels of surfaces in the first; standard error of the "
             "reference {3:.4f}, seed {4}; scene {5}.</p>\n",
             escapedHtml(scene.name), scene.pictures, scene.pixels, scene.referenceError, scene.seed, escapedHtml(scene.hash)) +
         charts(scene) + "</div>\n" + pictureGrid(pictures) + rowsTable(scene) + passesTable(scene) + stepsTable(scene);
}

}  // namespace

std::string reportPage(const Report& report, const std::vector<std::vector<PagePicture>>& pictures) {
  OVERCAST_REQUIRE(report.scenes.size() == pictures.size(), "{} scenes, pictures of {}", report.scenes.size(), pictures.size());
  std::string html = kHead;
  html += "<h1>Overcast: error against time</h1>\n" + environment(report) + "<nav>";
  for (const ReportScene& scene : report.scenes) html += fmt::format("<a href=\"#{0}\">{0}</a>", escapedHtml(scene.name));
  html += "</nav>\n";
  const ReportScene all = overall(report);
  html += fmt::format(
      "<h2>All {} scenes</h2><p class=\"quiet\">Settings that every scene has. Errors are root mean squares over the scenes, "
      "times geometric means, memory means.</p><div class=\"panel\">{}</div>\n",
      report.scenes.size(), legend(report));
  html += charts(all) + "</div>\n" + rowsTable(all) + "<h2>Where Overcast loses</h2>\n" + lossList(report);
  for (std::size_t i = 0; i < report.scenes.size(); ++i) html += sceneSection(report.scenes[i], pictures[i]);
  return html + "</main></body></html>\n";
}

}  // namespace overcast
