#include "runtime/report/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "runtime/technique.h"

namespace overcast {
namespace {

constexpr double kWidth = 600.0, kHeight = 390.0;
constexpr double kLeft = 66.0, kRight = 16.0, kTop = 16.0, kBottom = 46.0;
constexpr double kCharacter = 6.0;  // width of one in a label

/// A logarithmic axis with room at its ends; ticks at 1, 2 and 5 times powers of ten.
struct Axis {
  double low = 0.0;  ///< logarithms of 10
  double high = 1.0;
  double from = 0.0;  ///< pixels
  double to = 1.0;

  double at(double value) const { return from + (std::log10(value) - low) / (high - low) * (to - from); }
};

Axis axisOver(const std::vector<double>& values, double from, double to) {
  double least = 1e300, most = 0.0;
  for (const double value : values) {
    if (value <= 0.0) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  if (most <= 0.0) return {-1.0, 0.0, from, to};
  const double low = std::log10(least), high = std::log10(most);
  const double room = std::max(0.06 * (high - low), 0.08);
  return {low - room, high + room, from, to};
}

std::vector<double> ticksOf(const Axis& axis) {
  std::vector<double> ticks;
  const bool wide = axis.high - axis.low > 2.5;
  for (int power = static_cast<int>(std::floor(axis.low)); power <= static_cast<int>(std::ceil(axis.high)); ++power) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, power);
      if (wide && digit > 1.0) continue;
      if (std::log10(value) >= axis.low && std::log10(value) <= axis.high) ticks.push_back(value);
    }
  }
  return ticks;
}

std::string bytesText(double bytes) {
  if (bytes >= 1e6) return fmt::format("{:.4g} MB", bytes / 1e6);
  return bytes >= 1e3 ? fmt::format("{:.4g} kB", bytes / 1e3) : fmt::format("{:.4g} B", bytes);
}

std::string costText(Cost cost, double value) {
  return cost == Cost::bytes ? bytesText(value) : fmt::format("{:g}", value);
}

const char* costName(Cost cost) {
  switch (cost) {
    case Cost::frame:
      return "milliseconds of a frame, everything moves";
    case Cost::still:
      return "milliseconds of a frame, nothing moves";
    case Cost::bytes:
      break;
  }
  return "bytes on the device and of assets";
}

std::string grid(const Axis& across, const Axis& up, Cost cost, const std::string& error) {
  std::string svg;
  for (const double tick : ticksOf(across))
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text x=\"{0:.1f}\" y=\"{3:.1f}\" text-anchor=\"middle\">{4}</text>\n",
        across.at(tick), kTop, kHeight - kBottom, kHeight - kBottom + 16.0, costText(cost, tick));
  for (const double tick : ticksOf(up))
    svg += fmt::format(
        "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n", kLeft,
        up.at(tick), kWidth - kRight, kLeft - 6.0, up.at(tick) + 4.0, tick);
  svg += fmt::format("<text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n", 0.5 * (kLeft + kWidth - kRight),
                     kHeight - 8.0, costName(cost));
  return svg + fmt::format("<text class=\"axis\" transform=\"translate(14 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                           0.5 * (kTop + kHeight - kBottom), escapedHtml(error));
}

/// Colour of ours, or shape of the others.
struct Look {
  const char* family;
  const char* style;
};
constexpr std::array kOurs{Look{"published", "#0072B2"}, Look{"calibrated", "#E69F00"}, Look{"cones", "#56B4E9"},
                           Look{"traced", "#009E73"},    Look{"hybrid", "#D55E00"},     Look{"apertures", "#CC79A7"}};
constexpr const char* kFurtherColour = "#8A6D00";
constexpr std::array kOthers{Look{"constant", "M-5 -5h10v10h-10z"},
                             Look{"gtao", "M0 -7l6.5 12h-13z"},
                             Look{"cone-tracing", "M0 7l6.5 -12h-13z"},
                             Look{"rays16", "M0 -7l7 7l-7 7l-7 -7z"},
                             Look{"rays64", "M0 -7l7 7l-7 7l-7 -7zM0 -3l-3 3l3 3l3 -3z"},
                             Look{"surfels", "M-2 -6h4v4h4v4h-4v4h-4v-4h-4v-4h4z"},
                             Look{"as printed", "M-6 -3h12v6h-12z"}};
constexpr const char* kFurtherShape = "M-6 -6l12 12m0 -12l-12 12";

template <class Looks>
const char* styleOf(const Looks& looks, const std::string& family, const char* further) {
  const auto found = std::find_if(looks.begin(), looks.end(), [&](const Look& look) { return look.family == family; });
  return found == looks.end() ? further : found->style;
}

bool isOurs(const ReportRow& row) {
  return row.technique == nameOf(Technique::overcast);
}

/// A setting without its resolution and bake: those of one name are joined.
std::string seriesOf(const ReportRow& row) {
  std::string name = row.setting;
  const std::string resolution = fmt::format(", {}^3", row.resolution);
  if (const auto place = name.find(resolution); place != std::string::npos) name.erase(place, resolution.size());
  return name;
}

struct Point {
  std::size_t row;
  double x;
  double y;
};

std::string joined(const ReportScene& scene, const std::vector<Point>& points) {
  std::map<std::string, std::vector<Point>> series;
  for (const Point& point : points)
    if (scene.rows[point.row].resolution > 0 && scene.rows[point.row].bake.empty())
      series[seriesOf(scene.rows[point.row])].push_back(point);
  std::string svg;
  for (auto& [name, members] : series) {
    std::sort(members.begin(), members.end(),
              [&](const Point& a, const Point& b) { return scene.rows[a.row].resolution < scene.rows[b.row].resolution; });
    std::string path;
    for (const Point& point : members) path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", point.x, point.y);
    if (members.size() > 1)
      svg += fmt::format("<path class=\"series\" stroke=\"{}\" d=\"{}\"/>\n", colourOf(scene.rows[members[0].row]), path);
  }
  return svg;
}

/// Names of points where there is room for them, beside marks and other names.
std::string labels(const ReportScene& scene, const std::vector<Point>& front, const std::vector<Point>& points) {
  struct Area {
    double left, top, right, bottom;
  };
  std::vector<Area> taken;
  for (const Point& point : points) taken.push_back({point.x - 6.0, point.y - 6.0, point.x + 6.0, point.y + 6.0});
  std::string svg;
  for (const Point& point : front) {
    std::string name = scene.rows[point.row].setting;
    if (const auto place = name.find(", apertures"); place != std::string::npos) name.erase(place, 11);
    const double width = kCharacter * static_cast<double>(name.size());
    const std::array<Area, 4> places{Area{point.x + 9.0, point.y - 16.0, point.x + 9.0 + width, point.y - 4.0},
                                     Area{point.x - 9.0 - width, point.y + 3.0, point.x - 9.0, point.y + 15.0},
                                     Area{point.x + 9.0, point.y + 3.0, point.x + 9.0 + width, point.y + 15.0},
                                     Area{point.x - 9.0 - width, point.y - 16.0, point.x - 9.0, point.y - 4.0}};
    for (const Area& place : places) {
      if (place.left < kLeft || place.right > kWidth - kRight || place.top < kTop || place.bottom > kHeight - kBottom) continue;
      const bool free = std::none_of(taken.begin(), taken.end(), [&](const Area& other) {
        return place.left < other.right && other.left < place.right && place.top < other.bottom && other.top < place.bottom;
      });
      if (!free) continue;
      taken.push_back(place);
      svg += fmt::format("<text class=\"name\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", place.left, place.bottom - 2.0, escapedHtml(name));
      break;
    }
  }
  return svg;
}

}  // namespace

std::string escapedHtml(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string familyOf(const ReportRow& row) {
  if (!isOurs(row)) return row.technique;
  return row.apertureMode.empty() || row.estimator == "hybrid" ? row.estimator : "apertures";
}

std::string colourOf(const ReportRow& row) {
  return isOurs(row) ? styleOf(kOurs, familyOf(row), kFurtherColour) : "#4d565f";
}

std::string markOf(const ReportRow& row, double x, double y) {
  const std::string colour = colourOf(row);
  const std::string fill = row.bake.empty() ? colour : "#fff";
  if (isOurs(row)) return fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5.5\" fill=\"{}\" stroke=\"{}\"/>", x, y, fill, colour);
  return fmt::format("<path transform=\"translate({:.1f} {:.1f})\" d=\"{}\" fill=\"{}\" stroke=\"{}\" fill-rule=\"evenodd\"/>", x, y,
                     styleOf(kOthers, familyOf(row), kFurtherShape), fill, colour);
}

std::string describedRow(const ReportRow& row) {
  std::string text = fmt::format("{}\nRMSE {:.4f}, bias {:+.4f}, p99 {:.3f}, FLIP {:.3f}", row.setting, row.errors.rmse, row.errors.bias,
                                 row.errors.p99, row.errors.flip);
  if (row.errors.flicker >= 0.0) text += fmt::format(", flicker {:.4f}", row.errors.flicker);
  text += fmt::format("\neverything moves {:.1f} ms (noise {:.1f}), nothing moves {:.1f} ms (noise {:.1f})\n{} on the device, {} of assets",
                      row.frame.median, row.frame.noise, row.still.median, row.still.noise, bytesText(static_cast<double>(row.gpuBytes)),
                      bytesText(static_cast<double>(row.assetBytes)));
  if (!row.occluders.empty()) text += "\noccluders: " + row.occluders;
  return text;
}

std::string tradeoffChart(const ReportScene& scene, Cost cost, const std::string& error) {
  const std::vector<Tradeoff> tradeoff = tradeoffs(scene, cost);
  std::vector<double> costs, errors;
  for (const Tradeoff& point : tradeoff) {
    costs.push_back(std::max(point.cost, cost == Cost::bytes ? 1e3 : 1e-3));
    errors.push_back(point.error);
  }
  const Axis across = axisOver(costs, kLeft, kWidth - kRight), up = axisOver(errors, kHeight - kBottom, kTop);
  const double floor = std::pow(10.0, up.low);
  const auto at = [&](const Tradeoff& point) { return Point{point.row, across.at(costs[point.row]), up.at(std::max(point.error, floor))}; };
  std::vector<Point> points, front;
  for (const Tradeoff& point : tradeoff) points.push_back(at(point));
  for (const Tradeoff& point : paretoFront(tradeoff)) front.push_back(at(point));
  std::string svg = fmt::format("<svg class=\"chart\" viewBox=\"0 0 {} {}\" role=\"img\">\n", kWidth, kHeight);
  svg += grid(across, up, cost, error) + joined(scene, points);
  std::string line;
  for (const Point& point : front)
    line += line.empty() ? fmt::format("M{:.1f} {:.1f}", point.x, point.y) : fmt::format("H{:.1f}V{:.1f}", point.x, point.y);
  if (!line.empty()) svg += fmt::format("<path class=\"front\" d=\"{}\"/>\n", line);
  for (const Point& point : points)
    svg += fmt::format("<g class=\"mark\" data-row=\"{}\" tabindex=\"0\">{}<title>{}</title></g>\n", point.row,
                       markOf(scene.rows[point.row], point.x, point.y), escapedHtml(describedRow(scene.rows[point.row])));
  return svg + labels(scene, front, points) + "</svg>\n";
}

namespace {

/// RMSE of the picture that was split.
double lastError(const ReportRow& row) {
  return row.errors.views.empty() ? row.errors.rmse : row.errors.views.back();
}

}  // namespace

std::string stepsChart(const ReportScene& scene) {
  constexpr double kBar = 17.0, kHead = 22.0, kEnd = 1180.0, kFigure = 60.0;
  constexpr std::array kColours{"#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00"};
  std::vector<const ReportRow*> rows;
  double least = 0.0, most = 1.0, names = 80.0;
  for (const ReportRow& row : scene.rows) {
    if (row.steps.empty()) continue;
    rows.push_back(&row);
    names = std::max(names, kCharacter * static_cast<double>(row.setting.size()) + kFigure);
    double down = 0.0, upwards = 0.0;
    for (const ReportStep& step : row.steps) (step.share < 0.0 ? down : upwards) += step.share;
    least = std::min(least, down);
    most = std::max(most, upwards);
  }
  if (rows.empty()) return "";
  const auto x = [&](double share) { return names + (share - least) / (most - least) * (kEnd - names); };
  const double bottom = kHead + kBar * static_cast<double>(rows.size());
  std::string svg = fmt::format("<svg class=\"chart\" viewBox=\"0 0 1200 {:.0f}\" role=\"img\">\n", bottom + 22.0);
  for (std::size_t i = 0; i < rows[0]->steps.size(); ++i)
    svg += fmt::format("<rect x=\"{0}\" y=\"3\" width=\"10\" height=\"10\" fill=\"{1}\"/><text x=\"{2}\" y=\"12\">{3}</text>\n",
                       names + 115.0 * static_cast<double>(i), kColours[i % kColours.size()], names + 14.0 + 115.0 * static_cast<double>(i),
                       escapedHtml(rows[0]->steps[i].name));
  svg += fmt::format("<text x=\"{}\" y=\"12\" text-anchor=\"end\">RMSE</text>\n", names - 10.0);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double top = kHead + kBar * static_cast<double>(r);
    svg += fmt::format(
        "<text x=\"{0}\" y=\"{1:.1f}\" text-anchor=\"end\">{2}</text><text x=\"{3}\" y=\"{1:.1f}\" text-anchor=\"end\">{4:.4f}</text>\n",
        names - kFigure, top + 11.0, escapedHtml(rows[r]->setting), names - 10.0, lastError(*rows[r]));
    double down = 0.0, upwards = 0.0;
    for (std::size_t i = 0; i < rows[r]->steps.size(); ++i) {
      const ReportStep& step = rows[r]->steps[i];
      double& end = step.share < 0.0 ? down : upwards;
      const double from = end;
      end += step.share;
      svg += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"12\" fill=\"{}\"><title>{}: {:.0f} %, root mean square "
          "{:.4f}, bias {:+.4f}</title></rect>\n",
          x(std::min(from, end)), top + 1.0, x(std::max(from, end)) - x(std::min(from, end)), kColours[i % kColours.size()],
          escapedHtml(step.name), 100.0 * step.share, step.rms, step.bias);
    }
  }
  for (const double share : {0.0, 1.0})
    svg += fmt::format(
        "<path class=\"front\" d=\"M{0:.1f} {1}V{2:.1f}\"/><text x=\"{0:.1f}\" y=\"{3:.1f}\" text-anchor=\"middle\">{4} %</text>\n",
        x(share), kHead - 4.0, bottom, bottom + 14.0, 100.0 * share);
  return svg + "</svg>\n";
}

}  // namespace overcast
