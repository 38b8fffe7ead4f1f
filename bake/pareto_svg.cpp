#include "bake/pareto_svg.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace overcast {
namespace {

constexpr double kPanelWidth = 420.0;
constexpr double kPanelHeight = 300.0;
constexpr double kLeft = 64.0;
constexpr double kTop = 46.0;
constexpr double kColumn = 520.0;
constexpr double kRow = 400.0;
constexpr double kSmallest = 1e-9;  // percent and nanoseconds; an error of zero has no logarithm

const char* colourOf(Representation representation) {
  switch (representation) {
    case Representation::volume:
      return "#2166ac";
    case Representation::primitive:
      return "#b2182b";
    case Representation::radius:
      return "#1b7837";
    case Representation::heightfield:
      return "#b8860b";
  }
  return "#000000";
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else
      safe += c;
  }
  return safe;
}

/// A logarithmic axis from one power of ten to another.
struct Axis {
  int low = 0;
  int high = 1;

  double share(double value) const { return (std::log10(std::max(value, kSmallest)) - low) / (high - low); }
};

Axis axisAround(const std::vector<ParetoPoint>& points, double ParetoPoint::*figure) {
  double least = 1e300, most = kSmallest;
  for (const ParetoPoint& point : points) {
    least = std::min(least, std::max(point.*figure, kSmallest));
    most = std::max(most, point.*figure);
  }
  if (points.empty()) return {};
  const int low = static_cast<int>(std::floor(std::log10(least)));
  return {low, std::max(static_cast<int>(std::ceil(std::log10(most))), low + 1)};
}

std::string text(double x, double y, const char* anchor, const std::string& words) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, escaped(words));
}

/// One panel with its corner at (left, top).
struct Panel {
  double left = 0.0;
  double top = 0.0;
  Axis across;
  Axis up;

  double x(double cost) const { return left + across.share(cost) * kPanelWidth; }
  double y(double error) const { return top + (1.0 - up.share(error)) * kPanelHeight; }
};

std::string frame(const Panel& panel, const std::string& title, const char* costName) {
  const double right = panel.left + kPanelWidth, bottom = panel.top + kPanelHeight;
  std::string svg = fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" stroke=\"#888888\"/>\n",
                                panel.left, panel.top, kPanelWidth, kPanelHeight);
  for (int power = panel.across.low; power <= panel.across.high; ++power) {
    const double x = panel.x(std::pow(10.0, power));
    svg += fmt::format("<path d=\"M{0:.1f} {1:.1f}V{2:.1f}\" stroke=\"#dddddd\"/>\n", x, panel.top, bottom);
    svg += text(x, bottom + 14.0, "middle", fmt::format("{:g}", std::pow(10.0, power)));
  }
  for (int power = panel.up.low; power <= panel.up.high; ++power) {
    const double y = panel.y(std::pow(10.0, power));
    svg += fmt::format("<path d=\"M{0:.1f} {1:.1f}H{2:.1f}\" stroke=\"#dddddd\"/>\n", panel.left, y, right);
    svg += text(panel.left - 4.0, y + 4.0, "end", fmt::format("{:g}", std::pow(10.0, power)));
  }
  svg += text(panel.left, panel.top - 10.0, "start", title + ": error near the surface, % of the diagonal");
  return svg + text(panel.left + 0.5 * kPanelWidth, bottom + 30.0, "middle", costName);
}

std::string panelOf(const ExplainedMesh& mesh, const std::vector<ParetoPoint>& points, const char* costName, double left, double top) {
  const Panel panel{left, top, axisAround(points, &ParetoPoint::cost), axisAround(points, &ParetoPoint::error)};
  std::string svg = frame(panel, mesh.source, costName);
  std::string line;
  for (const ParetoPoint& point : paretoFront(points))
    line += fmt::format("{}{:.1f},{:.1f}", line.empty() ? "" : " ", panel.x(point.cost), panel.y(point.error));
  svg += fmt::format("<polyline class=\"front\" points=\"{}\" fill=\"none\" stroke=\"#555555\"/>\n", line);
  for (const ParetoPoint& point : points) {
    const Score& score = mesh.record.scores[point.score];
    const double x = panel.x(point.cost), y = panel.y(point.error);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"{}\"><title>{}</title></circle>\n", x, y,
                       colourOf(score.candidate.representation), escaped(name(score.candidate)));
    if (point.score != mesh.record.chosen) continue;
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"8\" fill=\"none\" stroke=\"#000000\"/>\n", x, y);
    svg += text(x + 11.0, y - 7.0, "start", name(score.candidate));
  }
  return svg;
}

}  // namespace

std::vector<ParetoPoint> paretoFront(std::vector<ParetoPoint> points) {
  std::stable_sort(points.begin(), points.end(),
                   [](const ParetoPoint& a, const ParetoPoint& b) { return a.cost != b.cost ? a.cost < b.cost : a.error < b.error; });
  std::vector<ParetoPoint> front;
  for (const ParetoPoint& point : points)
    if (front.empty() || point.error < front.back().error) front.push_back(point);
  return front;
}

std::string paretoSvg(const std::vector<ExplainedMesh>& meshes) {
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
      2.0 * kColumn, kRow * static_cast<double>(std::max<std::size_t>(meshes.size(), 1)));
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const ChoiceRecord& record = meshes[m].record;
    std::vector<ParetoPoint> bytes, times;
    for (std::size_t i = 0; i < record.scores.size(); ++i) {
      const Score& score = record.scores[i];
      if (score.error.samples == 0) continue;
      const double error = 100.0 * score.error.surfaceRms / record.diagonal;
      bytes.push_back({i, static_cast<double>(score.bytes), error});
      times.push_back({i, score.composite, error});
    }
    const double top = kTop + kRow * static_cast<double>(m);
    svg += panelOf(meshes[m], bytes, "bytes on disk", kLeft, top);
    svg += panelOf(meshes[m], times, "nanoseconds in the composite", kLeft + kColumn, top);
  }
  return svg + "</svg>\n";
}

}  // namespace overcast
