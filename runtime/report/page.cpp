#include "runtime/report/page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "runtime/report/chart.h"
#include "runtime/report/choice.h"
#include "runtime/report/page_parts.h"
#include "runtime/report/table.h"
#include "runtime/technique.h"

namespace overcast {
namespace {

constexpr const char* kErrorAxis = "RMSE of sky visibility";

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{:.2f}", static_cast<double>(bytes) / 1e6);
}

std::string legend(const Report& report) {
  std::set<std::string> seen;
  std::string ours, others;
  for (const ReportScene& scene : report.scenes) {
    for (const ReportRow& row : scene.rows) {
      const std::string family = familyOf(row);
      if (!row.bake.empty() || !seen.insert(family).second) continue;
      (row.technique == nameOf(Technique::overcast) ? ours : others) +=
          fmt::format("<span><svg viewBox=\"0 0 16 16\">{}</svg>{}</span>", markOf(row, 8.0, 8.0), escapedHtml(family));
    }
  }
  return fmt::format(
      "<div class=\"legend\"><b>Overcast</b>{}</div><div class=\"legend\"><b>what else one could take</b>{}</div>\n<p "
      "class=\"quiet\">Lower and further left is better. Dashed: the front; what lies above and to the right of it is beaten. Thin lines "
      "join the resolutions of one "
      "setting. Hollow: another bake of the scene. Point at a mark for its settings and its picture, click to keep it.</p>\n",
      ours, others);
}

std::string charts(const ReportScene& scene, const std::string& error) {
  const auto panel = [](const char* title, const std::string& chart) {
    return fmt::format("<div class=\"panel\"><h3>{}</h3>{}</div>\n", title, chart);
  };
  return "<div class=\"pair\">\n" + panel("Error against time, everything moves", tradeoffChart(scene, Cost::frame, error)) +
         panel("Error against time, nothing moves", tradeoffChart(scene, Cost::still, error)) +
         panel("Error against memory", tradeoffChart(scene, Cost::bytes, error)) + "</div>\n";
}

/// A column of the table of settings: what it says of a row, empty where it has nothing to say.
struct Column {
  const char* title;
  std::string (*text)(const ReportRow& row);
};

constexpr std::array kColumns{
    Column{"RMSE", [](const ReportRow& row) { return fmt::format("{:.4f}", row.errors.rmse); }},
    Column{"first frame",
           [](const ReportRow& row) { return row.errors.views.empty() ? std::string() : fmt::format("{:.4f}", row.errors.views.front()); }},
    Column{"last frame",
           [](const ReportRow& row) { return row.errors.views.empty() ? std::string() : fmt::format("{:.4f}", row.errors.views.back()); }},
    Column{"bias", [](const ReportRow& row) { return fmt::format("{:+.4f}", row.errors.bias); }},
    Column{"MAE", [](const ReportRow& row) { return fmt::format("{:.4f}", row.errors.mae); }},
    Column{"p95", [](const ReportRow& row) { return fmt::format("{:.3f}", row.errors.p95); }},
    Column{"p99", [](const ReportRow& row) { return fmt::format("{:.3f}", row.errors.p99); }},
    Column{"SSIM", [](const ReportRow& row) { return fmt::format("{:.3f}", row.errors.ssim); }},
    Column{"FLIP", [](const ReportRow& row) { return fmt::format("{:.4f}", row.errors.flip); }},
    Column{"flicker",
           [](const ReportRow& row) { return row.errors.flicker < 0.0 ? std::string() : fmt::format("{:.4f}", row.errors.flicker); }},
    Column{"moving ms", [](const ReportRow& row) { return fmt::format("{:.1f}", row.frame.median); }},
    Column{"noise", [](const ReportRow& row) { return fmt::format("{:.1f}", row.frame.noise); }},
    Column{"still ms", [](const ReportRow& row) { return fmt::format("{:.1f}", row.still.median); }},
    Column{"noise", [](const ReportRow& row) { return fmt::format("{:.1f}", row.still.noise); }},
    Column{"rounds", [](const ReportRow& row) { return row.still.rounds > 0 ? fmt::format("{}", row.still.rounds) : std::string(); }},
    Column{"MB device", [](const ReportRow& row) { return megabytes(row.gpuBytes); }},
    Column{"MB assets", [](const ReportRow& row) { return megabytes(row.assetBytes); }},
};

std::string rowsTable(const ReportScene& scene) {
  std::set<std::size_t> front;
  for (const Tradeoff& point : paretoFront(tradeoffs(scene, Cost::frame))) front.insert(point.row);
  std::vector<Column> columns;  // means over scenes have neither frames nor rounds
  for (const Column& column : kColumns)
    if (std::ranges::any_of(scene.rows, [&](const ReportRow& row) { return !column.text(row).empty(); })) columns.push_back(column);
  std::string html = "<div class=\"panel\"><table class=\"sorted\"><thead><tr><th>setting</th>";
  for (const Column& column : columns) html += fmt::format("<th>{}</th>", column.title);
  html += "</tr></thead><tbody>\n";
  for (std::size_t i = 0; i < scene.rows.size(); ++i) {
    html += fmt::format("<tr data-row=\"{}\"{}><td>{}</td>", i, front.contains(i) ? " class=\"front-row\"" : "",
                        escapedHtml(scene.rows[i].setting));
    for (const Column& column : columns) html += fmt::format("<td>{}</td>", column.text(scene.rows[i]));
    html += "</tr>\n";
  }
  return html +
         "</tbody></table><p class=\"quiet\">Bold: on the front of error against time while everything moves. Click a column to sort by "
         "it.</p></div>\n";
}

std::string passesTable(const ReportScene& scene) {
  std::string html = "<details><summary>Milliseconds of every pass</summary><div class=\"panel\"><table><tbody>\n";
  for (const ReportRow& row : scene.rows) {
    html += fmt::format("<tr><td>{}</td>", escapedHtml(row.setting));
    for (const ReportPass& pass : row.passes)
      html += fmt::format("<td>{} {:.2f} (p95 {:.2f})</td>", escapedHtml(pass.name), pass.time.median, pass.time.p95);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div></details>\n";
}

std::string stepsPanel(const ReportScene& scene) {
  return fmt::format(
      "<div class=\"panel\"><h3>Where the error comes from</h3>{}<p class=\"quiet\">Signed shares of the mean square error of the last "
      "frame; they sum to 100 %. Representation: 64 rays through the volume at 256^3 against the reference (what rays are off by is in "
      "it). "
      "Composite: the same rays at the setting's resolution. Estimator: the setting, its taps reading the volume itself. Prefilter: its "
      "taps reading the pyramid; what reads none has none of it. Left of 0: the step makes good what others spoil.</p></div>\n",
      stepsChart(scene));
}

/// Our row of the least error, which a page shows first.
std::size_t shownFirst(const ReportScene& scene) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < scene.rows.size(); ++i)
    if (scene.rows[i].technique == nameOf(Technique::overcast) && scene.rows[i].bake.empty() &&
        scene.rows[i].errors.rmse < scene.rows[best].errors.rmse)
      best = i;
  return best;
}

std::string viewer(const ReportScene& scene, const std::string& reference) {
  std::string options;
  for (std::size_t i = 0; i < scene.rows.size(); ++i)
    options +=
        fmt::format("<option value=\"{}\"{}>{}</option>", i, i == shownFirst(scene) ? " selected" : "", escapedHtml(scene.rows[i].setting));
  return fmt::format(
      "<div class=\"panel\"><h3>Sky visibility of the last frame <select>{}</select></h3><p class=\"chosen-text\"></p>"
      "<div class=\"viewer\">"
      "<figure><img alt=\"the setting\"><figcaption>the setting</figcaption></figure>"
      "<figure><img src=\"{}\" alt=\"the reference\"><figcaption>the reference: rays</figcaption></figure>"
      "<figure><canvas></canvas><div class=\"scale\"></div><figcaption>setting minus reference: blue {} too dark or more, red as much too "
      "bright</figcaption></figure></div></div>\n",
      options, reference, kDifferenceRange);
}

std::string lossList(const Report& report) {
  std::string html =
      "<p>Another technique has less error than everything of ours that is as fast (everything moves / nothing moves):</p>\n<ul>\n";
  for (const ReportScene& scene : report.scenes) {
    html += fmt::format("<li><b>{}</b>: ", escapedHtml(scene.name));
    for (const Cost cost : {Cost::frame, Cost::still}) {
      const std::vector<Loss> all = losses(scene, cost);
      if (cost == Cost::still) html += " / ";
      for (const Loss& loss : all) html += (&loss == all.data() ? "" : "; ") + escapedHtml(lossText(loss));
      if (all.empty()) html += "none";
    }
    html += "</li>\n";
  }
  return html + fmt::format("</ul>\n<p>{}</p>\n<p>{}</p>\n", escapedHtml(standingText(report, Cost::frame)),
                            escapedHtml(standingText(report, Cost::still)));
}

std::string environment(const Report& report) {
  return fmt::format(
             "<p>RMSE of sky visibility (0 to 1) against rays, at {}x{} pixels, beside milliseconds on the device at {}x{}.</p>\n<p "
             "class=\"quiet\">{} ({}), {}, Vulkan {}. Times are medians of up to {} rounds in which the settings take turns, after a frame "
             "that "
             "warms up; a composite is timed once for all settings of its resolution. Everything moves: the whole volume is made anew. "
             "Nothing "
             "moves: composite and pyramid rest. Noise: by how much another run may differ beside the other settings; all settings "
             "together "
             "may differ by {:.0f} %, for the device was not always as fast.</p>\n",
             report.width, report.height, report.timedWidth, report.timedHeight, escapedHtml(report.device), escapedHtml(report.kind),
             escapedHtml(report.driver), escapedHtml(report.vulkan), report.rounds, 100.0 * std::expm1(report.drift)) +
         (report.leftOut.empty() ? std::string() : fmt::format("<p class=\"quiet\">Left out here: {}.</p>\n", escapedHtml(report.leftOut)));
}

std::string framesOf(const ReportScene& scene) {
  std::string text;
  for (const ReportView& view : scene.views) text += fmt::format("{}{}", text.empty() ? "" : ", ", view.frame);
  return text;
}

std::string sceneSection(const ReportScene& scene, std::size_t number, const std::vector<PagePicture>& pictures) {
  const std::string reference = pictures.empty() ? "" : pictures[0].picture;
  return fmt::format(
             "<section data-scene=\"{5}\"><h2 id=\"{0}\">{0}</h2><p class=\"quiet\">{1} pictures (frames {6}), {2} pixels of surfaces in "
             "the "
             "last; standard error of the reference {3:.4f}, seed {4}.</p>\n",
             escapedHtml(scene.name), scene.pictures, scene.pixels, scene.referenceError, scene.seed, number, framesOf(scene)) +
         viewer(scene, reference) + charts(scene, kErrorAxis) + stepsPanel(scene) + rowsTable(scene) + passesTable(scene) + "</section>\n";
}

std::string pictureData(const std::vector<std::vector<PagePicture>>& pictures) {
  std::string script = fmt::format("<script>\nconst overcastRange = {};\nconst overcastPictures = [\n", kDifferenceRange);
  for (const auto& scene : pictures) {
    script += "[";
    for (const PagePicture& picture : scene) script += fmt::format("\"{}\",\n", picture.picture);
    script += "],\n";
  }
  return script + "];\n</script>\n";
}

}  // namespace

std::string reportPage(const Report& report, const std::vector<std::vector<PagePicture>>& pictures) {
  OVERCAST_REQUIRE(report.scenes.size() == pictures.size(), "{} scenes, pictures of {}", report.scenes.size(), pictures.size());
  std::string html = kPageHead;
  html += "<h1>Overcast: error against time</h1>\n" + environment(report) + "<nav>";
  for (const ReportScene& scene : report.scenes) html += fmt::format("<a href=\"#{0}\">{0}</a>", escapedHtml(scene.name));
  html += "</nav>\n";
  html += fmt::format(
      "<h2>All {} scenes</h2><p class=\"quiet\">Settings that every scene has. In the charts each scene's RMSE counts as a share of what "
      "one grey "
      "all over, the best one, would be off by, so that no scene outweighs another; geometric means of these, of times and of bytes. In "
      "the "
      "table: root mean squares of errors, geometric means of times, means of bytes.</p><div class=\"panel\">{}</div>\n",
      report.scenes.size(), legend(report));
  html += charts(normalised(report), "error, of the best single grey's") + rowsTable(overall(report)) + "<h2>Where Overcast loses</h2>\n" +
          lossList(report);
  for (std::size_t i = 0; i < report.scenes.size(); ++i) html += sceneSection(report.scenes[i], i, pictures[i]);
  return html + "</main>\n" + pictureData(pictures) + kPageScript + "</body></html>\n";
}

}  // namespace overcast
